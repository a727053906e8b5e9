"""What an agent observes, in parts: readings, bumps, commands, and where its goal is.

A part may remember: it is updated at every command, for all agents at once (last axis).
"""

import abc
from collections.abc import Sequence
from typing import Any, NamedTuple

import equinox as eqx
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Float

from motorspace._types import Flags, Motor, Pose, Sensors
from motorspace.navigation.problems import Problem
from motorspace.navigation.tasks import AbstractNavigation, Bounds, body
from motorspace.se2 import relative
from motorspace.worlds.scenario import Scenario
from motorspace.worlds.spaces import ContinuousCommands, SensorSpace

Rows = Float[Array, "F N"]
Memory = Any
"""What a part remembers: arrays with agents in the last axis."""

FAR = 1000.0
"""Beyond this nothing is observed; no world of these tasks is as large."""


class Moment(NamedTuple):
    """All there is after a command, for N agents (last axis)."""

    sensors: Sensors
    motor: Motor
    """The command; zeros at the start."""
    blocked: Flags
    """Whether the agent senses that a wall took its translation away."""
    pose: Pose
    acting: Flags
    """Whether the next command is the agent's own: it no longer wanders."""
    problem: Problem


class AbstractPart(eqx.Module):
    """What a part of an observation must answer."""

    @abc.abstractmethod
    def bounds(self, scenario: Scenario) -> Bounds:
        """The smallest and the largest value of each of its numbers."""

    @abc.abstractmethod
    def read(self, memory: Memory, moment: Moment) -> Rows:
        """The part of the observation."""

    def begin(self, moment: Moment) -> Memory:
        """What is remembered at the start; nothing by default."""
        del moment
        return ()

    def update(self, memory: Memory, moment: Moment) -> Memory:
        """What is remembered after a command."""
        del moment
        return memory


class Ranges(AbstractPart):
    """The readings, each divided by its scale."""

    space: SensorSpace = eqx.field(static=True)

    def bounds(self, scenario: Scenario) -> Bounds:
        return _scaled(self.space.low, self.space), _scaled(self.space.high, self.space)

    def read(self, memory: Memory, moment: Moment) -> Rows:
        return moment.sensors / np.asarray(self.space.scale, np.float32)[:, None]


class Bump(AbstractPart):
    """1 after a command whose translation a wall took away, else 0."""

    def bounds(self, scenario: Scenario) -> Bounds:
        return (0.0,), (1.0,)

    def read(self, memory: Memory, moment: Moment) -> Rows:
        return moment.blocked[None].astype(jnp.float32)


class LastCommand(AbstractPart):
    """The command before, each channel divided by its scale."""

    commands: ContinuousCommands = eqx.field(static=True)

    def bounds(self, scenario: Scenario) -> Bounds:
        # The command is zero at the start, which may be no command.
        low = [min(bound, 0.0) for bound in self.commands.low]
        high = [max(bound, 0.0) for bound in self.commands.high]
        return _scaled(low, self.commands), _scaled(high, self.commands)

    def read(self, memory: Memory, moment: Moment) -> Rows:
        return moment.motor / np.asarray(self.commands.scale, np.float32)[:, None]


class Stack(AbstractPart):
    """What other parts, which remember nothing, showed at the `num` moments before this one."""

    parts: tuple[AbstractPart, ...]
    num: int = eqx.field(static=True, default=4)

    def bounds(self, scenario: Scenario) -> Bounds:
        low, high = Observer(self.parts).bounds(scenario)
        # Before the first moment there are zeros.
        lowest, highest = (tuple(f(v, 0.0) for v in vs) for f, vs in ((min, low), (max, high)))
        return lowest * self.num, highest * self.num

    def begin(self, moment: Moment) -> Memory:
        now = self._now(moment)
        return jnp.zeros(((self.num + 1) * len(now), now.shape[-1])).at[: len(now)].set(now)

    def update(self, memory: Memory, moment: Moment) -> Memory:
        now = self._now(moment)
        return jnp.concatenate([now, memory[: -len(now)]])

    def read(self, memory: Memory, moment: Moment) -> Rows:
        return memory[len(memory) // (self.num + 1) :]

    def _now(self, moment: Moment) -> Rows:
        return jnp.concatenate([part.read((), moment) for part in self.parts])


class TrueDisplacement(AbstractPart):
    """Where the goal truly is, seen from here: (longitudinal, lateral) / 10, cosine, sine."""

    def bounds(self, scenario: Scenario) -> Bounds:
        return (-FAR, -FAR, -1.0, -1.0), (FAR, FAR, 1.0, 1.0)

    def read(self, memory: Memory, moment: Moment) -> Rows:
        forth, left, turn = relative(body(moment.pose), body(moment.problem.goal))
        return jnp.stack([forth / 10, left / 10, jnp.cos(turn), jnp.sin(turn)])


class Given(AbstractPart):
    """What the task gives: a hint at the goal, and whether the agent still wanders."""

    task: AbstractNavigation

    def bounds(self, scenario: Scenario) -> Bounds:
        low, high = self.task.hint_bounds(scenario)
        wanders = self.task.wanders
        return low + (0.0,) * wanders, high + (1.0,) * wanders

    def read(self, memory: Memory, moment: Moment) -> Rows:
        hint = self.task.hint(moment.problem)
        if not self.task.wanders:
            return hint
        return jnp.concatenate([hint, moment.acting[None].astype(jnp.float32)])


class Observer(eqx.Module):
    """All parts of an observation, one below the other."""

    parts: tuple[AbstractPart, ...]

    def bounds(self, scenario: Scenario) -> Bounds:
        """The smallest and the largest value of each number of an observation."""
        each = [part.bounds(scenario) for part in self.parts]
        low, high = (tuple(v for of_part in each for v in of_part[side]) for side in (0, 1))
        return low, high

    def begin(self, moment: Moment) -> Memory:
        """What is remembered at the start of an episode."""
        return tuple(part.begin(moment) for part in self.parts)

    def update(self, memory: Memory, moment: Moment) -> Memory:
        """What is remembered after a command."""
        pairs = zip(self.parts, memory, strict=True)
        return tuple(part.update(of_part, moment) for part, of_part in pairs)

    def read(self, memory: Memory, moment: Moment) -> Rows:
        """The observation, finite."""
        pairs = zip(self.parts, memory, strict=True)
        found = jnp.concatenate([part.read(of_part, moment) for part, of_part in pairs])
        return jnp.clip(jnp.nan_to_num(found), -FAR, FAR)


def _scaled(values: Sequence[float], space: SensorSpace | ContinuousCommands) -> tuple[float, ...]:
    return tuple(value / scale for value, scale in zip(values, space.scale, strict=True))
