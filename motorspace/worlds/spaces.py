"""What commands an agent takes, and what readings its sensors give: bounds, names, meaning."""

import abc
import math
from dataclasses import dataclass
from typing import Any

import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Float, Int

from motorspace._errors import UserError
from motorspace._types import Flags, Key, Motor

Bounds = tuple[Any, ...]
"""Numbers, one for each channel; scalar arrays within a program that is given them."""


class AbstractCommands(abc.ABC):
    """The motor commands of an agent: M channels, each with a name and bounds."""

    names: tuple[str, ...]
    turning: tuple[int, ...] = ()
    translating: tuple[int, ...] = ()
    looking: tuple[int, ...] = ()

    @property
    def size(self) -> int:
        """The number of channels M."""
        return len(self.names)

    @property
    @abc.abstractmethod
    def scale(self) -> Bounds:
        """The largest magnitude of each channel."""

    @abc.abstractmethod
    def sample(self, *, key: Key) -> Motor:
        """A uniformly random command."""

    @abc.abstractmethod
    def clip(self, motor: Motor) -> Motor:
        """The nearest command within the bounds."""

    def without_translation(self, motor: Motor, blocked: Flags) -> Motor:
        """Commands as a wall leaves them: those that it blocked do not move the body."""
        moves = tuple(channel in self.translating for channel in range(self.size))
        return jnp.where(_channels(moves, motor) & blocked[None], 0.0, motor)


@dataclass(frozen=True)
class ContinuousCommands(AbstractCommands):
    """Commands whose channels each take any value from `low` to `high`, in the agent's units.

    Example:
        >>> commands = ContinuousCommands((-3.0, 0.0), (3.0, 1.0), ("rotation", "move"))
        >>> commands.scale
        (3.0, 1.0)

    Raises:
        UserError: For bounds that are not finite or not in order, or that differ in number.
    """

    low: Bounds
    """The smallest value of each channel."""
    high: Bounds
    """The largest value of each channel."""
    names: tuple[str, ...]
    """What each channel is."""
    turning: tuple[int, ...] = ()
    """The channels that turn the body, by an angle in radians."""
    translating: tuple[int, ...] = ()
    """The channels that move the body along its own axes, after it has turned."""
    looking: tuple[int, ...] = ()
    """The channels that set the angle of the sensors relative to the body, radians."""

    def __post_init__(self) -> None:
        _check_bounds("command", self.low, self.high, self.names)
        channels = set(self.turning + self.translating + self.looking)
        if not channels <= set(range(self.size)):
            raise UserError(f"there is no command channel {max(channels)}, only {self.size}")

    @property
    def scale(self) -> Bounds:
        return tuple(map(_magnitude, self.low, self.high))

    def sample(self, *, key: Key) -> Motor:
        """A uniformly random command."""
        return self.spread(jax.random.uniform(key, (self.size,), jnp.float32))

    def clip(self, motor: Motor) -> Motor:
        low, high = (_channels(bound, motor) for bound in (self.low, self.high))
        return jnp.clip(motor, low, high)

    def from_unit(self, action: Float[Array | np.ndarray, "M *batch"]) -> Motor:
        """The command at an action in [-1, 1], of one agent or a batch; others are clipped."""
        symmetric, span, offset = self._stretch(action)
        action = jnp.clip(action, -1.0, 1.0)
        return jnp.where(symmetric, action, (action + 1.0) / 2.0) * span + offset

    def spread(self, share: Float[Any, "M *batch"]) -> Float[Any, "M *batch"]:
        """The commands at shares in [0, 1] of the way from `low` to `high`; NumPy or JAX."""
        symmetric, span, offset = self._stretch(share)
        xp = share.__array_namespace__()
        return xp.where(symmetric, 2 * share - 1, share) * span + offset

    def shares(self, motor: Motor) -> Float[Array, "M *batch"]:
        """How far commands are on the way from `low` to `high`: the inverse of `spread`."""
        low, high = (_channels(bound, motor) for bound in (self.low, self.high))
        return (motor - low) / (high - low)

    def _stretch(self, like: Float[Any, "M *batch"]) -> tuple[Any, Any, Any]:
        """Which channels are symmetric, and the span and offset that make commands of shares.

        Shares are in [-1, 1] in a symmetric channel, so that 0 is exactly 0, and in [0, 1] in
        another.
        """
        low, high = (_channels(bound, like) for bound in (self.low, self.high))
        symmetric, xp = low == -high, low.__array_namespace__()
        offset = xp.where(symmetric, 0.0, low)
        return symmetric, high - offset, offset


@dataclass(frozen=True)
class DiscreteCommands(AbstractCommands):
    """`num` different commands, each a one-hot vector.

    Example:
        >>> DiscreteCommands(6).size
        6

    Raises:
        UserError: For fewer than one command, or names that differ in number.
    """

    num: int
    """How many commands there are."""
    names: tuple[str, ...] = ()
    """What each command does; its number where nothing is said."""

    def __post_init__(self) -> None:
        if self.num < 1:
            raise UserError(f"the number of commands must be at least 1, got {self.num}")
        names = self.names or tuple(map(str, range(self.num)))
        if len(names) != self.num:
            raise UserError(f"{self.num} commands have {len(names)} names")
        object.__setattr__(self, "names", names)

    @property
    def scale(self) -> Bounds:
        return (1.0,) * self.num

    def sample(self, *, key: Key) -> Motor:
        """One of the commands, each with the same probability."""
        number = jnp.floor(jax.random.uniform(key, (), jnp.float32, maxval=float(self.num)))
        return self.from_index(number.astype(jnp.int32))

    def clip(self, motor: Motor) -> Motor:
        return self.from_index(jnp.argmax(motor, axis=0))

    def from_index(self, action: Int[Array | np.ndarray, "*batch"]) -> Motor:
        """The commands with these numbers, for one agent or a batch."""
        return jax.nn.one_hot(action, self.num, axis=0, dtype=jnp.float32)


CommandSpace = ContinuousCommands | DiscreteCommands


@dataclass(frozen=True)
class SensorSpace:
    """The readings of a sensor: K channels, each from `low` to `high` in raw units.

    Example:
        >>> SensorSpace((0.0, -1.0), (10.0, 1.0), ("distance", "head")).scale
        (10.0, 1.0)

    Raises:
        UserError: For bounds that are not finite or not in order, or that differ in number.
    """

    low: Bounds
    """The smallest reading of each channel."""
    high: Bounds
    """The largest reading of each channel."""
    names: tuple[str, ...]
    """What each channel is."""
    shape: tuple[int, ...] = ()
    """How the channels are arranged, for instance (height, width, 3); [K] where nothing is said."""
    divisors: Bounds = ()
    """What readings are divided by before a network sees them; the scale where nothing is said."""

    def __post_init__(self) -> None:
        _check_bounds("sensor", self.low, self.high, self.names)
        if not self.shape:
            object.__setattr__(self, "shape", (self.size,))
        if math.prod(self.shape) != self.size:
            raise UserError(f"{self.size} sensor channels do not fill the shape {self.shape}")

    @property
    def size(self) -> int:
        """The number of channels K."""
        return len(self.low)

    @property
    def scale(self) -> Bounds:
        """The largest magnitude of each channel, or `divisors` where they are given."""
        return self.divisors or tuple(map(_magnitude, self.low, self.high))


def _check_bounds(what: str, low: Bounds, high: Bounds, names: tuple[str, ...]) -> None:
    if not len(low) == len(high) == len(names):
        raise UserError(
            f"{what} channels need a bound on both sides and a name each,"
            f" got {len(low)} low, {len(high)} high, {len(names)} names"
        )
    for lowest, highest, name in zip(low, high, names, strict=True):
        # Within a compiled program a bound may be an argument, which was checked as a number.
        known = not isinstance(lowest, jax.core.Tracer) and not isinstance(highest, jax.core.Tracer)
        if known and not -math.inf < lowest < highest < math.inf:
            raise UserError(f"the {what} {name!r} cannot go from {lowest} to {highest}")


def _magnitude(low: float, high: float) -> float:
    return max(abs(low), abs(high))


def _channels(values: tuple[Any, ...], like: Float[Any, "M *batch"]) -> Any:
    """One value for each channel, over every agent of a batch."""
    dtype = bool if isinstance(values[0], bool) else like.dtype
    xp = jnp if any(isinstance(value, jax.Array) for value in values) else np
    return xp.asarray(values, dtype).reshape(-1, *(1,) * (like.ndim - 1))
