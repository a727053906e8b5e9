"""Train in simulation, measure the prediction, and see how the codes are structured."""

import math

import jax

import motorspace as ms

agent = ms.ForwardAgent(max_rotation=0.2 * math.pi)
config = ms.RunConfig(
    ms.Simulated(agent, horizon=3),
    training=ms.TrainingConfig(epochs=30, trajectories_per_epoch=1000),
)
run = ms.train(config)
print(ms.evaluate(run, num=8000))

fresh = ms.sample(config.data.scenario(), num=8000, horizon=3, key=jax.random.key(1))
codes = run.encode(fresh.experience.motors)
print(ms.topology(codes, fresh.displacements.achieved))
