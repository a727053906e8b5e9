"""Walls: how near places and moves come to them, and what lies inside."""

from collections.abc import Callable
from typing import Any, NamedTuple, TypeVar

import jax
import jax.numpy as jnp
from jaxtyping import Array, Bool, Float

from motorspace._types import Pose, Walls
from motorspace.worlds.tiles import Tiles, unroll

Batch = Float[Array, "*batch"]
Point = tuple[Batch, Batch]
Carry = TypeVar("Carry")

MARGIN = 1e-3
"""Half the thickness of a wall in world units. It dwarfs the rounding of float32 (4e-6 at
40 units), so that a move accepted here crosses no wall in exact arithmetic either."""


class WallFrame(NamedTuple):
    """A wall as a frame of its own: its middle, the direction along it, half its length."""

    x: Float[Array, "*S"]
    y: Float[Array, "*S"]
    along_x: Float[Array, "*S"]
    along_y: Float[Array, "*S"]
    half: Float[Array, "*S"]

    def locate(self, x: Batch, y: Batch) -> tuple[Batch, Batch]:
        """Coordinates of points along and across the wall, from its middle."""
        dx, dy = x - self.x, y - self.y
        return self.along_x * dx + self.along_y * dy, self.along_x * dy - self.along_y * dx


def wall_frame(ends: Float[Array, "2 2 *S"]) -> WallFrame:
    """The frames of walls, given by their two end points' x and y."""
    (ax, ay), (bx, by) = ends
    span_x, span_y = (bx - ax) / 2, (by - ay) / 2
    half = jnp.hypot(span_x, span_y)
    return WallFrame((ax + bx) / 2, (ay + by) / 2, span_x / half, span_y / half, half)


def least_gap(
    walls: Walls | Tiles, gap: Callable[[WallFrame], Batch], place: Point, reach: Batch
) -> Batch:
    """The smallest of `gap` over all walls; in `Tiles`, over those within `reach` of a place."""
    if isinstance(walls, Tiles):
        return walls.fold(
            lambda least, ends: jnp.minimum(least, gap(wall_frame(ends))),
            jnp.full(place[0].shape, jnp.inf),
            place,
            lambda least: reach,
        )
    frames = wall_frame(jnp.moveaxis(walls, 0, 2))
    nothing_near = jnp.full(place[0].shape, jnp.inf)
    return over_walls(lambda least, wall: jnp.minimum(least, gap(wall)), nothing_near, frames)


def gap_to_point(wall: WallFrame, x: Batch, y: Batch) -> Batch:
    """Above zero for points that are more than two margins away from a wall.

    The second margin keeps an accepted end point outside the thickness that `gap_to_move`
    tests at the next step, however it is rounded.
    """
    along, across = wall.locate(x, y)
    reach = 2 * MARGIN
    return jnp.maximum(jnp.abs(along) - (wall.half + reach), jnp.abs(across) - reach)


def gap_to_move(wall: WallFrame, start: Pose, end: Pose) -> Batch:
    """Above zero for straight moves that miss a wall, taken one margin thick on every side.

    A move misses a wall's box when one of three axes separates them: along the wall, across
    it, or across the move (separating axis theorem; Gottschalk, Lin and Manocha, 1996).
    """
    a0, b0 = wall.locate(start.x, start.y)
    a1, b1 = wall.locate(end.x, end.y)
    da, db, length = a1 - a0, b1 - b0, wall.half + MARGIN
    along = jnp.abs(a0 + a1) - (2 * length + jnp.abs(da))
    across = jnp.abs(b0 + b1) - (2 * MARGIN + jnp.abs(db))
    sideways = jnp.abs(a0 * db - b0 * da) - (length * jnp.abs(db) + MARGIN * jnp.abs(da))
    return jnp.maximum(jnp.maximum(along, across), sideways)


def inside(edges: Walls, x: Batch, y: Batch) -> Bool[Array, "*batch"]:
    """Whether points lie inside the closed polygons drawn by `edges` (even-odd rule)."""

    def cross(side: Batch, edge: Float[Array, "2 2 *worlds"]) -> Batch:
        """`side` changes its sign with every edge to the right of the point."""
        (x0, y0), (x1, y1) = edge
        rise = jnp.where(y1 == y0, 1.0, y1 - y0)
        right = x0 + (y - y0) * ((x1 - x0) / rise) > x
        return jnp.where(((y0 > y) != (y1 > y)) & right, -side, side)

    return over_walls(cross, jnp.ones(x.shape), edges) < 0


def over_walls(visit: Callable[[Carry, Any], Carry], start: Carry, walls: Any) -> Carry:
    """Fold `visit` over the walls, all agents at once.

    One wall at a time keeps every array as long as there are agents; a loop, rather than one
    expression, makes the compiler compute what `visit` closes over once and not per wall. The
    carry holds floats, since mixing them with flags keeps a loop from being vectorised.
    """

    def advance(found: Carry, wall: Any) -> tuple[Carry, None]:
        return visit(found, wall), None

    return jax.lax.scan(advance, start, walls, unroll=unroll())[0]
