"""Places: where an agent may be, and which moves a wall forbids."""

import abc
from typing import Any, NamedTuple

import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Float

from motorspace._types import Count, Flag, Flags, Key, Pose, Walls
from motorspace.worlds.checks import whole
from motorspace.worlds.coat import Coat
from motorspace.worlds.tiles import Tiles, in_groups
from motorspace.worlds.walls import (
    MARGIN,
    WallFrame,
    gap_to_move,
    gap_to_point,
    inside,
    least_gap,
)

START_ATTEMPTS = 256


class Drawing(NamedTuple):
    """What a picture of a world shows; world units."""

    bounds: tuple[float, float, float, float]
    """The part of the plane to show: x low, y low, x high, y high."""
    lines: Float[np.ndarray, "S 2 2"]
    """Walls, two end points each."""
    points: Float[np.ndarray, "P 2"]
    """Nodes."""
    pointer: float
    """Length of the line from an agent that shows where it looks."""
    solids: tuple[Float[np.ndarray, "_ 2"], ...] = ()
    """Corners of each closed obstacle."""


class AbstractWorld(eqx.Module):
    """What a place must answer."""

    @abc.abstractmethod
    def random_pose(self, *, key: Key) -> Pose:
        """A uniformly random position in the bounds and heading; the head looks ahead."""

    @abc.abstractmethod
    def drawing(self) -> Drawing:
        """What a picture of this world shows."""

    @abc.abstractmethod
    def free(self, pose: Pose) -> Flags:
        """Whether an agent may stand at a pose, for one or a batch."""

    def place(self, *, key: Key) -> Pose:
        """A uniformly random free pose."""

        def again(carry: tuple[Count, Pose]) -> Flag:
            attempt, pose = carry
            return ~self.free(pose) & (attempt < START_ATTEMPTS)

        def redraw(carry: tuple[Count, Pose]) -> tuple[Count, Pose]:
            attempt = carry[0] + 1
            return attempt, self.random_pose(key=jax.random.fold_in(key, attempt))

        first = (jnp.zeros((), jnp.int32), self.random_pose(key=jax.random.fold_in(key, 0)))
        return jax.lax.while_loop(again, redraw, first)[1]

    @abc.abstractmethod
    def blocked(self, start: Pose, end: Pose) -> Flags:
        """Whether the straight move from `start` to `end` is forbidden, for one or a batch."""


def _float32(values: Any) -> Array:
    return jnp.asarray(values, jnp.float32)


class WalledWorld(AbstractWorld):
    """A rectangle with walls: the paper's continuous world.

    Args:
        walls: Every segment [S, 2, 2], the outer ones included. World units.
        solids: Those [E, 2, 2] that bound closed obstacles, in whose inside nothing may stand.
        bounds: (x low, y low, x high, y high). Plain numbers are constants to `eqx.filter_jit`;
            `stack_worlds` makes arrays of them.
        tiles: Many walls sorted by place, so that those around one are found.
        coat: The walls' colours, for eyes.
    """

    walls: Walls = eqx.field(converter=_float32)
    solids: Walls = eqx.field(converter=_float32)
    bounds: tuple[float, float, float, float]
    tiles: Tiles | None = None
    coat: Coat | None = None

    def walls_within(self, reach: float) -> Walls | Tiles:
        """Where to look for walls that are at most `reach` away from a place in the bounds."""
        if self.tiles is None or reach > self.tiles.reach:
            return self.walls
        return self.tiles

    def random_pose(self, *, key: Key) -> Pose:
        x_low, y_low, x_high, y_high = self.bounds
        low = jnp.array([x_low, y_low, -jnp.pi], jnp.float32)
        high = jnp.array([x_high, y_high, jnp.pi], jnp.float32)
        x, y, heading = jax.random.uniform(key, (3,), jnp.float32, minval=low, maxval=high)
        return Pose(x, y, heading, jnp.zeros_like(x))

    def drawing(self) -> Drawing:
        solids, corners, start = np.asarray(self.solids), [], 0
        for stop in range(1, len(solids) + 1):
            # A polygon's edges follow each other and end where they began.
            if np.array_equal(solids[stop - 1, 1], solids[start, 0]):
                corners.append(solids[start:stop, 0])
                start = stop
        x_low, y_low, x_high, y_high = map(float, self.bounds)  # arrays in a world of a stack
        bounds = (x_low, y_low, x_high, y_high)
        return Drawing(bounds, np.asarray(self.walls), np.zeros((0, 2)), 1.5, tuple(corners))

    def free(self, pose: Pose) -> Flags:
        x_low, y_low, x_high, y_high = self.bounds
        x, y = pose.x, pose.y
        in_bounds = (x > x_low) & (x < x_high) & (y > y_low) & (y < y_high)
        apart = in_groups(self._apart, x.shape, pose) if self.tiles else self._apart(pose)
        return in_bounds & apart & ~inside(self.solids, x, y)

    def blocked(self, start: Pose, end: Pose) -> Flags:
        tiles = self.tiles
        if tiles is None:
            return _hindered(self.walls, start, end)

        def hindered(start: Pose, end: Pose) -> Flags:
            return jax.lax.cond(
                jnp.max(_length(start, end)) < tiles.reach - 1,
                lambda: _hindered(tiles, start, end),
                lambda: _hindered(self.walls, start, end),
            )

        return in_groups(hindered, start.x.shape, start, end)

    def _apart(self, pose: Pose) -> Flags:
        x, y = pose.x, pose.y
        walls, reach = self.walls_within(1.0), jnp.full(x.shape, 3 * MARGIN)
        gap = least_gap(walls, lambda wall: gap_to_point(wall, x, y), (x, y), reach)
        return gap > 0


def _length(start: Pose, end: Pose) -> Float[Array, "*batch"]:
    return jnp.hypot(end.x - start.x, end.y - start.y)


def _hindered(walls: Walls | Tiles, start: Pose, end: Pose) -> Flags:
    """Whether a move meets a wall, or ends too near to one."""

    def gap(wall: WallFrame) -> Float[Array, "*batch"]:
        move = gap_to_move(wall, start, end)
        return jnp.minimum(move, gap_to_point(wall, end.x, end.y))

    reach = _length(start, end) + 3 * MARGIN
    return least_gap(walls, gap, (start.x, start.y), reach) <= 0


class LatticeWorld(AbstractWorld):
    """A grid of nodes one unit apart, with four orientations: the paper's discrete world.

    Node (0, 0) is at the origin; a move that leaves the grid is forbidden.

    Raises:
        UserError: For a side that is not a whole number above 0.
    """

    width: int = eqx.field(static=True, default=6)
    """Nodes along x."""
    height: int = eqx.field(static=True, default=6)
    """Nodes along y."""

    def __check_init__(self) -> None:
        whole("width", self.width)
        whole("height", self.height)

    @property
    def num_nodes(self) -> int:
        """Nodes of the lattice."""
        return self.width * self.height

    def random_pose(self, *, key: Key) -> Pose:
        low = jnp.array([0.0, 0.0, -1.0], jnp.float32)
        high = jnp.array([self.width, self.height, 3.0], jnp.float32)
        node = jax.random.uniform(key, (3,), jnp.float32, minval=low, maxval=high)
        x, y, quarters = jnp.floor(node)
        return Pose(x, y, quarters * jnp.pi / 2, jnp.zeros_like(x))

    def drawing(self) -> Drawing:
        bounds = (-1.0, -1.0, float(self.width), float(self.height))
        nodes = np.array(list(np.ndindex(self.width, self.height)), float)
        return Drawing(bounds, np.zeros((0, 2, 2)), nodes, pointer=0.4)

    def free(self, pose: Pose) -> Flags:
        return jnp.ones(pose.x.shape, bool)

    def blocked(self, start: Pose, end: Pose) -> Flags:
        del start
        # Half a unit of slack: positions are whole numbers up to rounding.
        outside_x = (end.x < -0.5) | (end.x > self.width - 0.5)
        outside_y = (end.y < -0.5) | (end.y > self.height - 0.5)
        return outside_x | outside_y
