"""Bodies: what a motor command does to a pose, and how commands are drawn."""

import abc
import math
from typing import Literal

import equinox as eqx
import jax
import jax.numpy as jnp
from jaxtyping import Array, Float

from motorspace._types import Key, Motor, Pose
from motorspace.worlds.geometry import advance, wrap


class AbstractAgent(eqx.Module):
    """What a body must answer. Commands are in the agent's own units (radians, world units).

    `start` and `draw` answer for one agent; `move` and `turn` for one or for any batch.
    """

    @property
    @abc.abstractmethod
    def motor_scale(self) -> tuple[float, ...]:
        """The largest magnitude of each motor channel; its length is the motor size."""

    @abc.abstractmethod
    def start(self, place: Pose, *, key: Key) -> Pose:
        """The pose in which a trajectory begins at `place`."""

    @abc.abstractmethod
    def draw(self, *, key: Key) -> Motor:
        """A random motor command, as the agent explores."""

    @abc.abstractmethod
    def move(self, pose: Pose, motor: Motor) -> tuple[Pose, ...]:
        """The poses at the end of each straight leg of the command, walls aside."""

    @abc.abstractmethod
    def turn(self, pose: Pose, motor: Motor) -> Pose:
        """The pose after the same command when its translation does not happen."""


class ForwardAgent(AbstractAgent):
    """Turns by an angle uniform in [-r, r], then moves ahead by a length uniform in [0, 1].

    Motor command: (rotation in radians, move in world units). `max_rotation` is r.
    """

    max_rotation: float = eqx.field(static=True, default=0.8 * math.pi)

    @property
    def motor_scale(self) -> tuple[float, ...]:
        return (self.max_rotation, 1.0)

    def start(self, place: Pose, *, key: Key) -> Pose:
        del key
        return place

    def draw(self, *, key: Key) -> Motor:
        turn, move = jax.random.uniform(key, (2,))
        return jnp.stack([(2 * turn - 1) * self.max_rotation, move])

    def move(self, pose: Pose, motor: Motor) -> tuple[Pose, ...]:
        turned = self.turn(pose, motor)
        return (advance(turned, motor[1], jnp.zeros_like(motor[1])),)

    def turn(self, pose: Pose, motor: Motor) -> Pose:
        return Pose(pose.x, pose.y, wrap(pose.heading + motor[0]), pose.head)


class HolonomicAgent(AbstractAgent):
    """A body that turns and slides, under a head that carries the sensors.

    Motor command: (body rotation in [-r, r], longitudinal and lateral move in [-1, 1], head
    angle in [-pi/2, pi/2]), carried out in this order. `head_rule="set"` makes the head
    command the new angle relative to the body; `"turn"` adds it. `head_start` is the head's
    angle when a trajectory begins: `"aligned"` with the body, or `"random"`.
    """

    max_rotation: float = eqx.field(static=True, default=0.8 * math.pi)
    head_rule: Literal["set", "turn"] = eqx.field(static=True, default="set")
    head_start: Literal["aligned", "random"] = eqx.field(static=True, default="aligned")

    @property
    def motor_scale(self) -> tuple[float, ...]:
        return (self.max_rotation, 1.0, 1.0, math.pi / 2)

    def start(self, place: Pose, *, key: Key) -> Pose:
        if self.head_start == "aligned":
            return place
        head = jax.random.uniform(key, minval=-jnp.pi / 2, maxval=jnp.pi / 2)
        return Pose(place.x, place.y, place.heading, head)

    def draw(self, *, key: Key) -> Motor:
        return jax.random.uniform(key, (4,), minval=-1.0) * jnp.array(self.motor_scale)

    def move(self, pose: Pose, motor: Motor) -> tuple[Pose, ...]:
        turned = self.turn(pose, motor)
        along = advance(turned, motor[1], jnp.zeros_like(motor[1]))
        return along, advance(along, jnp.zeros_like(motor[2]), motor[2])

    def turn(self, pose: Pose, motor: Motor) -> Pose:
        head = motor[3] if self.head_rule == "set" else wrap(pose.head + motor[3])
        return Pose(pose.x, pose.y, wrap(pose.heading + motor[0]), head)


class LatticeAgent(AbstractAgent):
    """Turns by -90, 0 or +90 degrees, then moves ahead by 0 or 1 node.

    Motor command: one-hot over the six pairs, index 2 x (turn + 1) + move.
    """

    @property
    def motor_scale(self) -> tuple[float, ...]:
        return (1.0,) * 6

    def start(self, place: Pose, *, key: Key) -> Pose:
        del key
        return place

    def draw(self, *, key: Key) -> Motor:
        return jax.nn.one_hot(jnp.floor(jax.random.uniform(key, maxval=6.0)).astype(int), 6)

    def move(self, pose: Pose, motor: Motor) -> tuple[Pose, ...]:
        turned = self.turn(pose, motor)
        move = _weighted((0.0, 1.0) * 3, motor)
        ahead = advance(turned, move, jnp.zeros_like(move))
        # Nodes are whole numbers: rounding keeps long walks on the lattice.
        return (Pose(jnp.round(ahead.x), jnp.round(ahead.y), ahead.heading, ahead.head),)

    def turn(self, pose: Pose, motor: Motor) -> Pose:
        quarters = _weighted((-1.0, -1.0, 0.0, 0.0, 1.0, 1.0), motor)
        heading = wrap(pose.heading + quarters * jnp.pi / 2)
        return Pose(pose.x, pose.y, jnp.round(heading * 2 / jnp.pi) * jnp.pi / 2, pose.head)


def _weighted(weights: tuple[float, ...], motor: Motor) -> Float[Array, "*batch"]:
    """The channels of a command added up."""
    return jnp.tensordot(jnp.array(weights), motor, axes=1)
