"""What else the same network can be given to learn: the reference rows that need training."""

from collections.abc import Callable

import jax
import jax.numpy as jnp

from motorspace._types import Count, Displacement, Key, Motors, Pose
from motorspace.analysis.baselines import with_displacement_as_motors
from motorspace.analysis.probes import displacement_targets
from motorspace.models.model import Scaling
from motorspace.training.config import RunConfig, fresh_experience, simulation_scaling, simulator
from motorspace.trajectories.transitions import Experience, ExperienceSource, Trajectories
from motorspace.worlds.agents import AbstractAgent
from motorspace.worlds.simulation import nominal_displacement

Source = Callable[[Key, Count], Experience]
Lesson = Callable[[RunConfig], tuple[ExperienceSource, Scaling]]


def learned(config: RunConfig) -> tuple[ExperienceSource, Scaling]:
    """Fresh experience as it is."""
    return fresh_experience(config), simulation_scaling(config)


def oracle(config: RunConfig) -> tuple[Source, Scaling]:
    """Fresh experience whose command is the true displacement itself."""
    draw, reach = simulator(config), float(config.simulation.horizon)
    return (
        lambda key, epoch: with_displacement_as_motors(draw(key, epoch), reach),
        _told_scaling(config),
    )


def _told_scaling(config: RunConfig) -> Scaling:
    return Scaling(simulation_scaling(config).sensors, (1.0,) * 4)


def misjudged(config: RunConfig, angle: float) -> tuple[Source, Scaling]:
    """Fresh experience whose command is what the displacement seems to be to a body that takes
    its turns for `angle` times what they are; no walls bar its way."""
    draw, (_, agent, _) = simulator(config), config.simulation.build()
    return (
        lambda key, epoch: misjudged_experience(agent, draw(key, epoch), angle),
        _told_scaling(config),
    )


def misjudged_experience(agent: AbstractAgent, drawn: Trajectories, angle: float) -> Experience:
    """The same of trajectories; of agents whose first command is their only turn."""
    experience = drawn.experience
    here = Pose(*[jnp.zeros(())] * 4)

    def seems(motors: Motors, num_steps: Count) -> Displacement:
        taken = motors * jnp.ones(motors.shape[1]).at[0].set(angle)
        return nominal_displacement(agent, here, taken, num_steps)

    seeming = jax.vmap(seems)(experience.motors, experience.num_steps)
    told = Trajectories(experience, drawn.displacements._replace(achieved=seeming))
    return with_displacement_as_motors(told, float(experience.motors.shape[1]))


def shuffled(config: RunConfig) -> tuple[Source, Scaling]:
    """Fresh experience in which every sequence leads to what another one led to."""
    draw = simulator(config)

    def source(key: Key, epoch: Count) -> Experience:
        drawn = draw(key, epoch).experience
        later = jax.random.permutation(jax.random.fold_in(key, 1), drawn.later_sensors)
        return Experience(drawn.sensors, drawn.motors, drawn.num_steps, later)

    return source, simulation_scaling(config)


def supervised(config: RunConfig) -> tuple[Source, Scaling]:
    """Motor sequences with the displacement to be told, instead of the sensors."""
    draw, reach = simulator(config), float(config.simulation.horizon)

    def source(key: Key, epoch: Count) -> Experience:
        drawn = draw(key, epoch)
        told = jnp.asarray(displacement_targets(drawn.displacements.achieved))
        motors, num_steps = drawn.experience.motors, drawn.experience.num_steps
        return Experience(jnp.zeros_like(told), motors, num_steps, told)

    return source, Scaling((reach, reach, 1.0, 1.0), simulation_scaling(config).motors)
