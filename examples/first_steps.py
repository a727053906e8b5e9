"""A world, an agent, its senses; trajectories; a small network; what its codes know."""

import jax

import motorspace as ms
from motorspace.analysis.coordinates import COMPONENTS
from motorspace.analysis.probes import displacement_targets, linear_probe

config = ms.RunConfig(
    ms.SimulationConfig(agent="forward", max_rotation=0.2, horizon=3),
    training=ms.TrainingConfig(epochs=30, trajectories_per_epoch=1000),
)
run = ms.train(config, ms.fresh_experience(config), ms.simulation_scaling(config))

world, agent, sensor = config.simulation.build()
test = ms.sample(ms.Scenario(world, agent, sensor), num=2000, horizon=3, key=jax.random.key(1))
codes = run.encode(test.experience.motors)
targets = displacement_targets(test.displacements.achieved)
r2 = linear_probe(codes[:1000], targets[:1000], codes[1000:], targets[1000:])
print({name: round(float(value), 2) for name, value in zip(COMPONENTS, r2, strict=True)})
