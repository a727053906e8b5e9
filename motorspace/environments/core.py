"""What single and vector environments share: spaces, actions and the compiled step."""

import math
from collections.abc import Callable
from typing import Any, NamedTuple

import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np
from gymnasium import spaces
from jaxtyping import Array, Float, Shaped

from motorspace._errors import UserError
from motorspace._forks import refuse_forked
from motorspace._types import Key, Keys, Motor, Pose
from motorspace.environments.render import Image, render
from motorspace.environments.tasks import AbstractTask, Transition
from motorspace.worlds.checks import whole
from motorspace.worlds.scenario import Scenario
from motorspace.worlds.simulation import to_agents_last, to_rows
from motorspace.worlds.spaces import CommandSpace, DiscreteCommands, SensorSpace

Action = Shaped[Array | np.ndarray, "*batch_action"]
"""Gymnasium's actions: agents first, then the channels of a command, if it has any."""

StepResult = Float[Array, "*batch O"]
"""Pose (x, y, heading, head), whether a wall was in the way, reward, whether the task is done,
sensors: one row per agent, since every array that enters or leaves the compiled step costs
microseconds."""

RENDER_MODES = ("rgb_array",)


class Unpacked(NamedTuple):
    """A step's result as NumPy arrays of their own, or numbers of one agent."""

    observation: Float[np.ndarray, "..."]
    pose: Float[np.ndarray, "*batch 4"]
    blocked: Any
    reward: Any
    terminated: Any


def unpack(result: StepResult, space: SensorSpace) -> Unpacked:
    """The parts of a step's result; the readings in the shape of the sensor."""
    row = np.array(result, np.float32)
    if row.ndim == 1:  # numbers are faster than arrays without an axis
        blocked, reward, done = row[4:7].tolist()
        return Unpacked(row[7:].reshape(space.shape), row[:4], blocked > 0, reward, done > 0)
    readings = row[:, 7:].reshape(len(row), *space.shape)
    return Unpacked(readings, row[:, :4], row[:, 4] > 0, row[:, 5].astype(float), row[:, 6] > 0)


class CompiledStep(NamedTuple):
    """The rules of an episode, compiled."""

    begin: Callable[[Key], StepResult]
    begin_all: Callable[[Keys], StepResult]
    advance: Callable[[StepResult, Action], StepResult]


class Episode(eqx.Module):
    """A scenario and a task, with agents in rows as Gymnasium has them."""

    scenario: Scenario
    task: AbstractTask

    def begin(self, key: Key) -> StepResult:
        """A random free pose and what is sensed there."""
        pose = self.scenario.start(key=key)
        zero = jnp.zeros_like(pose.x)
        return self._result(pose, [zero, zero, zero], self.scenario.sense(pose))

    def advance(self, before: StepResult, action: Action) -> StepResult:
        """What comes of an action after what came of the one before, for one agent or a batch."""
        start = Pose(*to_agents_last(before)[:4])
        after, blocked = self.scenario.step(start, motor_of(self.scenario.commands, action))
        happened = Transition(start, after, blocked, self.scenario.sense(after))
        facts = [blocked, self.task.reward(happened), self.task.terminated(happened)]
        return self._result(after, facts, happened.sensors)

    def compiled(self) -> CompiledStep:
        """The rules with the episode as a constant: as an argument it costs twice a single step."""
        return CompiledStep(
            jax.jit(lambda key: self.begin(key)),
            jax.jit(lambda keys: jax.vmap(self.begin)(keys)),
            jax.jit(lambda before, action: self.advance(before, action)),
        )

    def _result(self, pose: Pose, facts: list[Array], sensors: Array) -> StepResult:
        # Rounding may put a reading a little beyond its bounds.
        low, high = _bounds(self.scenario.space, (-1, *(1,) * (sensors.ndim - 1)))
        fields = [pose.x, pose.y, pose.heading, pose.head, *facts]
        rows = jnp.stack([field.astype(jnp.float32) for field in fields])
        return to_rows(jnp.concatenate([rows, jnp.clip(sensors, low, high)]))


def action_space(commands: CommandSpace) -> spaces.Space[Any]:
    """The number of a discrete command, else every motor channel in [-1, 1]."""
    if isinstance(commands, DiscreteCommands):
        return spaces.Discrete(commands.num)
    return spaces.Box(-1.0, 1.0, (commands.size,), np.float32)


def observation_space(space: SensorSpace) -> spaces.Box:
    """The sensors in raw units."""
    low, high = _bounds(space, space.shape)
    return spaces.Box(low, high, dtype=np.float32)


def _bounds(space: SensorSpace, shape: tuple[int, ...]) -> tuple[np.ndarray, np.ndarray]:
    low, high = (np.asarray(bound, np.float32) for bound in (space.low, space.high))
    return low.reshape(shape), high.reshape(shape)


def motor_of(commands: CommandSpace, action: Action) -> Motor:
    """The motor command behind an action."""
    if isinstance(commands, DiscreteCommands):
        return commands.from_index(action)
    return commands.from_unit(to_agents_last(action))


def checked_action(commands: CommandSpace, action: Any, num: int | None = None) -> np.ndarray:
    """The action of one agent or, with `num`, of so many, as an array.

    Raises:
        UserError: For an action of another shape, a number that is not finite, and no number of a
            command. Finite values outside [-1, 1] pass: they are clipped.
    """
    batch, each = ((), "an action") if num is None else ((num,), f"actions of {num} agents")
    discrete = isinstance(commands, DiscreteCommands)
    shape = batch if discrete else (*batch, commands.size)
    try:
        array = np.asarray(action) if discrete else np.asarray(action, np.float32)
    except (TypeError, ValueError):
        raise UserError(f"{each} must be numbers, got {action!r}") from None
    if array.shape != shape:
        raise UserError(
            f"{each} must have the shape {shape}, got {array.shape}",
            remedy=f"the channels are {', '.join(commands.names)}",
        )
    if discrete and not _numbers_of_commands(array, commands.size):
        raise UserError(
            f"{each} must be whole numbers from 0 to {commands.size - 1}, got {action!r}"
        )
    if not discrete and not _finite(array):
        raise UserError(f"{each} must be finite, got {action!r}")
    return array


def _finite(array: Float[np.ndarray, "..."]) -> bool:
    if array.ndim == 1:  # faster for a few numbers
        return all(map(math.isfinite, array.tolist()))
    return bool(np.isfinite(array).all())


def _numbers_of_commands(array: np.ndarray, num: int) -> bool:
    return array.dtype.kind in "iu" and bool(((array >= 0) & (array < num)).all())


def episode_length(max_steps: Any, max_episode_steps: Any) -> int | None:
    """The steps of an episode: our own option, or Gymnasium's; None where neither says any.

    Raises:
        UserError: For a number below 1, and for more steps than Gymnasium allows.
    """
    given = {"max_steps": max_steps, "max_episode_steps": max_episode_steps}
    lengths = [whole(name, value) for name, value in given.items() if value is not None]
    if lengths and lengths[0] > min(lengths):
        raise UserError(
            f"Gymnasium ends an episode after {lengths[1]} steps, before max_steps {lengths[0]}",
            remedy="give max_episode_steps instead",
        )
    return lengths[0] if lengths else None


def checked_mode(mode: str | None) -> str | None:
    """The render mode. Raises `UserError` unless there is such a one."""
    if mode is not None and mode not in RENDER_MODES:
        raise UserError(f"there is no render mode {mode!r}", remedy=f"use {RENDER_MODES[0]}")
    return mode


def jax_key(random: np.random.Generator) -> Key:
    """A JAX key from Gymnasium's own generator."""
    refuse_forked()
    return jax.random.key(int(random.integers(2**31)))


def picture(episode: Episode, result: StepResult) -> Image:
    """One agent in its world as pixels."""
    return render(episode.scenario, Pose(*result[:4]))


class Compiled:
    """An environment whose compiled step is made anew where a copy of it is unpickled."""

    episode: Episode
    _compiled: CompiledStep

    def _set_episode(self, episode: Episode) -> None:
        self.episode, self._compiled = episode, episode.compiled()
        # Kept, since making them takes longer than a step.
        self._commands, self._space = episode.scenario.commands, episode.scenario.space

    def __getstate__(self) -> dict[str, Any]:
        return {name: value for name, value in vars(self).items() if name != "_compiled"}

    def __setstate__(self, state: dict[str, Any]) -> None:
        vars(self).update(state)
        self._compiled = self.episode.compiled()
