"""Bodies: which motor commands they take, and what a command does to a pose."""

import abc
import math
from typing import Any, ClassVar, Literal

import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Float

from motorspace._errors import UserError
from motorspace._kinds import Registry
from motorspace._types import Key, Motor, Pose
from motorspace.se2 import advance, wrap
from motorspace.worlds.catalog import AGENTS
from motorspace.worlds.checks import one_of, positive
from motorspace.worlds.spaces import CommandSpace, ContinuousCommands, DiscreteCommands
from motorspace.worlds.world import AbstractWorld, LatticeWorld


class AbstractAgent(eqx.Module):
    """What a body must answer; its fields are its options.

    A number among them is an argument of compiled programs unless its field is static: bodies that
    differ by it are trained as one program.

    Commands are in the agent's own units (radians, world units). `start` answers for one agent;
    `move` and `turn` for one or for any batch.
    """

    registry: ClassVar[Registry[Any]] = AGENTS

    @property
    @abc.abstractmethod
    def commands(self) -> CommandSpace:
        """The motor commands that this body takes."""

    @abc.abstractmethod
    def start(self, place: Pose, *, key: Key) -> Pose:
        """The pose in which a trajectory begins at `place`."""

    @abc.abstractmethod
    def move(self, pose: Pose, motor: Motor) -> tuple[Pose, ...]:
        """The poses at the end of each straight leg of the command, walls aside."""

    @abc.abstractmethod
    def turn(self, pose: Pose, motor: Motor) -> Pose:
        """The pose after the same command when its translation does not happen."""

    def check(self, world: AbstractWorld) -> None:
        """Raise `UserError` for a world that this body cannot move in; none by default."""
        del world


class ForwardAgent(AbstractAgent):
    """Turns by an angle in [-r, r], then moves ahead by a length in [0, 1] (paper, section 3).

    Motor command: (rotation in radians, move in world units); r is `max_rotation`.

    Example:
        >>> ForwardAgent(max_rotation=0.5).commands.high
        (0.5, 1.0)

    Raises:
        UserError: For a largest rotation that is not finite and above 0.
    """

    max_rotation: float = eqx.field(
        default=0.8 * math.pi, metadata={"in_pi": True, "positive": True}
    )
    """Largest body rotation per step."""

    def __check_init__(self) -> None:
        positive("max_rotation", self.max_rotation, unit="radians")

    @property
    def commands(self) -> ContinuousCommands:
        high = (self.max_rotation, 1.0)
        return ContinuousCommands(
            (-self.max_rotation, 0.0), high, ("rotation", "move"), turning=(0,), translating=(1,)
        )

    def start(self, place: Pose, *, key: Key) -> Pose:
        del key
        return place

    def move(self, pose: Pose, motor: Motor) -> tuple[Pose, ...]:
        turned = self.turn(pose, motor)
        return (advance(turned, motor[1], jnp.zeros_like(motor[1])),)

    def turn(self, pose: Pose, motor: Motor) -> Pose:
        return Pose(pose.x, pose.y, wrap(pose.heading + motor[0]), pose.head)


class HolonomicAgent(AbstractAgent):
    """A body that turns and slides, under a head that carries the sensors (paper, section 3).

    Motor command: (body rotation in [-r, r], longitudinal and lateral move in [-1, 1], head
    angle in [-pi/2, pi/2]), carried out in this order; r is `max_rotation`. Radians and world
    units. `head_rule="set"` makes the head command the new angle relative to the body; `"turn"`
    adds it. `head_start` is the head's angle when a trajectory begins: `"aligned"` with the body,
    or `"random"`.

    Raises:
        UserError: For a largest rotation that is not finite and above 0, or an unknown rule.
    """

    max_rotation: float = eqx.field(
        default=0.8 * math.pi, metadata={"in_pi": True, "positive": True}
    )
    """Largest body rotation per step."""
    head_rule: Literal["set", "turn"] = eqx.field(static=True, default="set")
    """The head command: set the head's angle, or turn the head by it."""
    head_start: Literal["aligned", "random"] = eqx.field(static=True, default="aligned")
    """The head's angle when a trajectory begins."""

    def __check_init__(self) -> None:
        positive("max_rotation", self.max_rotation, unit="radians")
        one_of("head_rule", self.head_rule, ("set", "turn"))
        one_of("head_start", self.head_start, ("aligned", "random"))

    @property
    def commands(self) -> ContinuousCommands:
        high = (self.max_rotation, 1.0, 1.0, math.pi / 2)
        return ContinuousCommands(
            tuple(-bound for bound in high),
            high,
            ("rotation", "longitudinal", "lateral", "head"),
            turning=(0,),
            translating=(1, 2),
            looking=(3,) if self.head_rule == "set" else (),
        )

    def start(self, place: Pose, *, key: Key) -> Pose:
        if self.head_start == "aligned":
            return place
        quarter = jnp.pi / 2
        head = jax.random.uniform(key, (), jnp.float32, minval=-quarter, maxval=quarter)
        return Pose(place.x, place.y, place.heading, head)

    def move(self, pose: Pose, motor: Motor) -> tuple[Pose, ...]:
        turned = self.turn(pose, motor)
        along = advance(turned, motor[1], jnp.zeros_like(motor[1]))
        return along, advance(along, jnp.zeros_like(motor[2]), motor[2])

    def turn(self, pose: Pose, motor: Motor) -> Pose:
        head = motor[3] if self.head_rule == "set" else wrap(pose.head + motor[3])
        return Pose(pose.x, pose.y, wrap(pose.heading + motor[0]), head)


class LatticeAgent(AbstractAgent):
    """Turns by -90, 0 or +90 degrees, then moves ahead by 0 or 1 node (paper, section 3).

    Motor command: one-hot over the six pairs, index 2 x (turn + 1) + move.
    """

    @property
    def commands(self) -> DiscreteCommands:
        turns, moves = ("right", "straight", "left"), ("stay", "move")
        return DiscreteCommands(6, tuple(f"{turn}_{move}" for turn in turns for move in moves))

    def start(self, place: Pose, *, key: Key) -> Pose:
        del key
        return place

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

    def check(self, world: AbstractWorld) -> None:
        if not isinstance(world, LatticeWorld):
            raise UserError(
                f"a LatticeAgent moves from node to node, and a {type(world).__name__} has none",
                remedy="choose a layout such as lattice:6",
            )


def _weighted(weights: tuple[float, ...], motor: Motor) -> Float[Array, "*batch"]:
    """The channels of a command added up."""
    return jnp.tensordot(np.asarray(weights, motor.dtype), motor, axes=1)
