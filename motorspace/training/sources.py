"""From the data that a configuration names to the transitions that training draws from."""

from dataclasses import dataclass
from functools import lru_cache
from typing import Any

import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np

from motorspace._errors import UserError
from motorspace._types import Count, Key, Scalar
from motorspace.models.model import Scaling
from motorspace.recordings.recording import Recording
from motorspace.recordings.windows import split_blocks, windows
from motorspace.training.config import RunConfig
from motorspace.training.data import (
    Data,
    Derived,
    DerivedKind,
    Logged,
    Simulated,
    base_of,
    simulated,
)
from motorspace.trajectories import derived
from motorspace.trajectories.curriculum import sequence_lengths
from motorspace.trajectories.sampling import SamplingPlan, simulate
from motorspace.trajectories.transitions import Experience, ExperienceSource, Trajectories
from motorspace.worlds.agents import AbstractAgent
from motorspace.worlds.scenario import Scenario

SPLIT_SEED = 0

ROUNDING = 1e-5
"""Spread of a command that does not vary, relative to its magnitude."""


class Change(eqx.Module):
    """What a baseline is given for the trajectories of an agent; see `Derived`."""

    kind: DerivedKind = eqx.field(static=True)
    agent: AbstractAgent
    reach: float | Scalar
    """The longest way that a trajectory goes, world units."""
    angle: float | Scalar

    def __call__(self, sampled: Trajectories, *, key: Key) -> Experience:
        match self.kind:
            case "oracle":
                return derived.displacement_as_motors(sampled, self.reach)
            case "shuffled":
                return derived.shuffled(sampled, key=key)
            case "supervised":
                return derived.supervised(sampled)
        return derived.scaled_rotations(self.agent, sampled, angle=self.angle)


@dataclass(frozen=True)
class DataSource:
    """What training draws from."""

    experience: ExperienceSource
    scaling: Scaling
    validation: Experience | None = None


def source_of(config: RunConfig) -> DataSource:
    """The source of the data that the configuration names. Raises `UserError` if it names none."""
    match config.data:
        case Simulated() | Derived(base=Simulated()):
            return _simulation_source(config)
        case Logged():
            data = logged_data(config.data)
            return DataSource(data.train.experience, data.scaling, data.validation.experience)
        case Derived():
            return _derived_from_log(config.data)
    raise UserError(
        f"the configuration names no data ({config.data.description})",
        remedy="pass them: train(config, experience)",
    )


def given_source(
    config: RunConfig, experience: ExperienceSource, scaling: Scaling | None
) -> DataSource:
    """The source of data of one's own; see `train` for the scaling."""
    if scaling is None:
        some = experience
        if not isinstance(some, Experience):
            some = some(jax.random.key(config.training.seed), jnp.zeros((), jnp.int32))
        sensors = np.abs(np.asarray(some.sensors)).max(axis=0)
        scaling = Scaling(_above_zero(sensors), motor_spread(some))
    return DataSource(experience, scaling)


class Simulator(eqx.Module):
    """A function from a key and the epoch to one epoch's new trajectories, short ones first."""

    scenario: Scenario
    plan: SamplingPlan = eqx.field(static=True)
    shortest: int = eqx.field(static=True)
    """Commands of the shortest trajectory once the curriculum is over."""
    curriculum_epochs: Count
    only_key: Key | None
    """The key of every epoch's trajectories, if they are to be the same."""

    def __call__(self, key: Key, epoch: Count) -> Trajectories:
        key = key if self.only_key is None else self.only_key
        lengths = sequence_lengths(
            epoch, self.curriculum_epochs, shortest=self.shortest, horizon=self.plan.horizon
        )
        return simulate(self.scenario, self.plan, lengths, key=key)


class Simulation(eqx.Module):
    """What a network is given of simulated trajectories: themselves, or what is derived of them."""

    draw: Simulator
    change: Change | None = None

    def __call__(self, key: Key, epoch: Count) -> Experience:
        sampled = self.draw(key, epoch)
        return sampled.experience if self.change is None else self.change(sampled, key=key)


def simulator(config: RunConfig) -> Simulator:
    """What draws the trajectories of a simulated run."""
    data, training = simulated(config.data), config.training
    plan = SamplingPlan(training.trajectories_per_epoch, data.horizon, data.collision)
    only_key = None if training.resample_each_epoch else jax.random.key(training.seed)
    growing = jnp.int32(training.curriculum_epochs)
    shortest = data.min_horizon or data.horizon
    return Simulator(data.scenario(), plan, shortest, growing, only_key)


def simulation_scaling(config: RunConfig) -> Scaling:
    """What simulated sensors and commands are divided by."""
    scenario = simulated(config.data).scenario()
    commands = scenario.agent.commands
    raw = config.model.motor_scaling == "raw"
    motors = (1.0,) * commands.size if raw else commands.scale
    return Scaling(scenario.sensor.space(scenario.world).scale, motors)


def derive(data: Derived, sampled: Trajectories, *, key: Key) -> Experience:
    """What a baseline on simulated data is given for these trajectories."""
    return _change_of(data)(sampled, key=key)


def _change_of(data: Derived) -> Change:
    return Change(data.change, data.scenario().agent, float(data.horizon), data.angle)


def _simulation_source(config: RunConfig) -> DataSource:
    scaling, draw = simulation_scaling(config), simulator(config)
    if not isinstance(config.data, Derived):
        return DataSource(Simulation(draw), scaling)
    reach = float(config.data.horizon)
    match config.data.change:
        case "oracle" | "scaled_rotations":
            scaling = Scaling(scaling.sensors, (1.0,) * 4)
        case "supervised":
            scaling = Scaling((reach, reach, 1.0, 1.0), scaling.motors)
    return DataSource(Simulation(draw, _change_of(config.data)), scaling)


@dataclass(frozen=True)
class LoggedData:
    """Transitions of one recording, in disjoint blocks of time."""

    train: Trajectories
    """Of every number of scans from the shortest to the longest."""
    validation: Trajectories
    test: Trajectories
    scaling: Scaling


def logged_data(data: Data) -> LoggedData:
    """A log's transitions, split 60 / 20 / 20 by blocks of time.

    Of data derived from a log, the oracle's: one command each, the true displacement. Raises
    `UserError` for a log that has changed, cannot be read, or is too short.
    """
    log = base_of(data)
    assert isinstance(log, Logged), "the caller has made sure"
    return _oracle_of(_logged_data(log)) if isinstance(data, Derived) else _logged_data(log)


@lru_cache(maxsize=4)
def _logged_data(data: Logged) -> LoggedData:
    recording = data.recording()
    train, validation, test = _split(recording, data, data.horizon)
    shorter = [
        _split(recording, data, scans)[0]
        for scans in range(data.min_horizon or data.horizon, data.horizon)
    ]
    padded = [_padded(part, train.experience.motors.shape[1]) for part in (*shorter, train)]
    together = jax.tree.map(lambda *parts: jnp.concatenate(parts), *padded)
    scaling = Scaling(recording.sensor_scale, motor_spread(train.experience))
    return LoggedData(together, validation, test, scaling)


def _derived_from_log(data: Derived) -> DataSource:
    oracle = logged_data(data)
    return DataSource(oracle.train.experience, oracle.scaling, oracle.validation.experience)


def _oracle_of(data: LoggedData) -> LoggedData:
    reach = float(np.abs(np.asarray(data.train.displacements.achieved[:, :2])).max())
    train, validation, test = (
        Trajectories(derived.displacement_as_motors(part, reach), part.displacements)
        for part in (data.train, data.validation, data.test)
    )
    return LoggedData(train, validation, test, Scaling(data.scaling.sensors, (1.0,) * 4))


def _split(
    recording: Recording, data: Logged, scans: int
) -> tuple[Trajectories, Trajectories, Trajectories]:
    everything = windows(recording, horizon=scans, per_scan=data.per_scan)
    train, validation, test = split_blocks(
        recording, horizon=scans, num_blocks=data.num_blocks, key=jax.random.key(SPLIT_SEED)
    )
    return everything[train], everything[validation], everything[test]


def _padded(part: Trajectories, horizon: int) -> Trajectories:
    """The same trajectories, their motor sequences padded with zeros to one horizon."""
    motors = part.experience.motors
    padded = jnp.pad(motors, ((0, 0), (0, horizon - motors.shape[1]), (0, 0)))
    return eqx.tree_at(lambda t: t.experience.motors, part, padded)


def motor_spread(experience: Experience) -> tuple[float, ...]:
    """The standard deviation of each channel over the commands that were executed."""
    executed = np.arange(experience.motors.shape[1]) < np.asarray(experience.num_steps)[:, None]
    motors = np.asarray(experience.motors)[executed]
    spread = motors.std(axis=0)
    # The same command every time seems to vary by its rounding.
    rounding = ROUNDING * np.abs(motors).max(axis=0)
    return _above_zero(np.where(spread > rounding, spread, 0.0))


def _above_zero(values: Any) -> tuple[float, ...]:
    """The values, with ones for zeros: what does not vary is not scaled."""
    return tuple(float(value) if value > 0 else 1.0 for value in values)
