"""What else the same network can be given to learn: the reference rows that need training."""

from collections.abc import Callable

from motorspace._types import Count, Key
from motorspace.models.model import Scaling
from motorspace.training.config import RunConfig, fresh_experience, simulation_scaling, simulator
from motorspace.trajectories import derived
from motorspace.trajectories.transitions import Experience, ExperienceSource

Source = Callable[[Key, Count], Experience]
Lesson = Callable[[RunConfig], tuple[ExperienceSource, Scaling]]


def learned(config: RunConfig) -> tuple[ExperienceSource, Scaling]:
    """Fresh experience as it is."""
    return fresh_experience(config), simulation_scaling(config)


def oracle(config: RunConfig) -> tuple[Source, Scaling]:
    """Fresh experience whose command is the true displacement itself."""
    draw, reach = simulator(config), float(config.simulation.horizon)
    return (
        lambda key, epoch: derived.displacement_as_motors(draw(key, epoch), reach),
        _told_scaling(config),
    )


def _told_scaling(config: RunConfig) -> Scaling:
    return Scaling(simulation_scaling(config).sensors, (1.0,) * 4)


def misjudged(config: RunConfig, angle: float) -> tuple[Source, Scaling]:
    """Fresh experience whose command is what the displacement seems to be to a body that takes
    its turns for `angle` times what they are; no walls bar its way."""
    draw, (_, agent, _) = simulator(config), config.simulation.build()
    return (
        lambda key, epoch: derived.scaled_rotations(agent, draw(key, epoch), angle=angle),
        _told_scaling(config),
    )


def shuffled(config: RunConfig) -> tuple[Source, Scaling]:
    """Fresh experience in which every sequence leads to what another one led to."""
    draw = simulator(config)
    return lambda key, epoch: derived.shuffled(draw(key, epoch), key=key), simulation_scaling(
        config
    )


def supervised(config: RunConfig) -> tuple[Source, Scaling]:
    """Motor sequences with the displacement to be told, instead of the sensors."""
    draw, reach = simulator(config), float(config.simulation.horizon)
    scaling = Scaling((reach, reach, 1.0, 1.0), simulation_scaling(config).motors)
    return lambda key, epoch: derived.supervised(draw(key, epoch)), scaling
