"""Walks that an agent explores with: commands and readings, and no pose."""

from collections.abc import Mapping
from typing import Literal, NamedTuple

import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Float

from motorspace._errors import UserError
from motorspace._types import Key, Motor, Pose
from motorspace.worlds.checks import whole
from motorspace.worlds.scenario import Scenario
from motorspace.worlds.spaces import ContinuousCommands

TRIES = 16
"""Commands that are tried for a step before the agent only turns."""
Manner = Literal["straight", "random", "slow"]
"""How an agent explores: it keeps its direction, which covers more ground; its commands are
uniformly random; or it hardly leaves the spot, so that it moves in all directions alike."""


class _Habits(NamedTuple):
    kept: float
    """How often the translation of the last command is repeated."""
    calm: float
    """By what rotations are scaled."""
    slow: float
    """By what translations are scaled."""


HABITS: Mapping[Manner, _Habits] = {
    "straight": _Habits(0.8, 0.15, 1.0),
    "random": _Habits(0.0, 1.0, 1.0),
    "slow": _Habits(0.0, 1.0, 0.3),
}


class Walk(NamedTuple):
    """What agents did and sensed on n walks of T steps side by side.

    Args:
        motors: The commands, [T, n, M]. Of a step that walls forbade the translation is zero:
            the agent only turned.
        sensors: What was sensed before, between and after them, [T + 1, n, K], raw units.
    """

    motors: Float[np.ndarray, "T n M"]
    sensors: Float[np.ndarray, "S n K"]

    @property
    def num_steps(self) -> int:
        """Commands of each walk (T)."""
        return len(self.motors)

    def windows(self, length: int, most: int) -> "Walk":
        """Pieces of `length` steps, spread evenly over the walks, about `most` of them."""
        length = min(length, self.num_steps)
        rows = -(-most // self.motors.shape[1])
        firsts = np.linspace(0, self.num_steps - length, min(rows, self.num_steps)).astype(int)
        firsts = np.unique(firsts)
        motors = [self.motors[first : first + length] for first in firsts]
        sensors = [self.sensors[first : first + length + 1] for first in firsts]
        return Walk(*(np.concatenate(part, axis=1)[:, :most] for part in (motors, sensors)))


def joined(*walks: Walk) -> Walk:
    """Walks of equally many steps side by side."""
    motors, sensors = zip(*walks, strict=True)
    return Walk(np.concatenate(motors, axis=1), np.concatenate(sensors, axis=1))


def walk(
    scenario: Scenario,
    *,
    num_steps: int,
    num_walks: int = 1,
    manner: Manner = "straight",
    key: Key,
) -> Walk:
    """Walks of an agent that explores, each from a random free place.

    A command that a wall forbids is not executed; another is tried. Where all are forbidden the
    agent only turns, and knows it.

    Args:
        scenario: The world, the agent and its sensors.
        num_steps: Commands in a row (T).
        num_walks: Walks side by side (n).
        manner: `"straight"` keeps its direction for some steps, which covers more ground;
            `"random"` commands are uniformly random; `"slow"` ones hardly leave the spot.
        key: Source of randomness.

    Returns:
        Commands and readings.

    Raises:
        UserError: For sizes below one, and an agent whose commands are discrete.

    Example:
        >>> walk(Scenario("empty"), num_steps=5, key=jax.random.key(0)).sensors.shape
        (6, 1, 9)
    """
    whole("num_steps", num_steps)
    whole("num_walks", num_walks)
    if not isinstance(scenario.commands, ContinuousCommands):
        raise UserError(
            "the agent's commands are discrete", remedy="choose the agent forward or holonomic"
        )
    # One program serves every manner.
    habits = _Habits(*map(jnp.float32, HABITS[manner]))
    motors, sensors = _walk(scenario, num_steps, num_walks, habits, key=key)
    first, last = np.asarray(motors, np.float64), np.asarray(sensors, np.float64)
    return Walk(np.moveaxis(first, 1, -1), np.moveaxis(last, 1, -1))


@eqx.filter_jit
def _walk(
    scenario: Scenario, num_steps: int, num_walks: int, habits: _Habits, *, key: Key
) -> tuple[Float[Array, "T M n"], Float[Array, "S K n"]]:
    start_key, motor_key, walk_key = jax.random.split(key, 3)
    commands = scenario.commands
    start = jax.vmap(lambda k: scenario.start(key=k))(jax.random.split(start_key, num_walks))
    sample = jax.vmap(lambda k: commands.sample(key=k), out_axes=-1)
    translating = jnp.isin(jnp.arange(commands.size), jnp.array(commands.translating))
    turning = jnp.isin(jnp.arange(commands.size), jnp.array(commands.turning))

    def proposals(last: Motor, key: Key) -> Float[Array, "M n TRIES"]:
        sample_key, keep_key = jax.random.split(key)
        keys = jax.random.split(sample_key, (num_walks, TRIES))
        tried = jax.vmap(sample, out_axes=1)(keys)
        tried = jnp.where(translating[:, None, None], habits.slow * tried, tried)
        kept = jax.random.uniform(keep_key, (num_walks,)) < habits.kept
        usual = jnp.where(turning[:, None], habits.calm * tried[..., 0], tried[..., 0])
        usual = jnp.where(translating[:, None] & kept[None], last, usual)
        return tried.at[..., 0].set(usual)

    def advance(carry: tuple[Pose, Motor], key: Key) -> tuple[tuple[Pose, Motor], tuple]:
        pose, last = carry
        tried = proposals(last, key)
        shape = (num_walks, TRIES)
        here = jax.tree.map(lambda field: jnp.broadcast_to(field[:, None], shape), pose)
        after, blocked = scenario.step(here, tried)
        first = jnp.argmin(blocked, axis=-1)[:, None]

        def chosen(field: Float[Array, "n TRIES"]) -> Float[Array, " n"]:
            return jnp.take_along_axis(field, first, axis=-1)[:, 0]

        then, stuck = jax.tree.map(chosen, after), jnp.all(blocked, axis=-1)
        motor = jax.vmap(chosen)(tried)
        motor = commands.without_translation(motor, stuck)
        return (then, motor), (motor, scenario.sense(then))

    begin = start, sample(jax.random.split(motor_key, num_walks))
    _, (motors, sensors) = jax.lax.scan(advance, begin, jax.random.split(walk_key, num_steps))
    return motors, jnp.concatenate([scenario.sense(start)[None], sensors])
