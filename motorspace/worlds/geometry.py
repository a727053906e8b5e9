"""Plane geometry on arrays: angles, displacements in SE(2), walls and rays."""

from collections.abc import Callable
from typing import Any, NamedTuple, TypeVar

import jax
import jax.numpy as jnp
from jaxtyping import Array, Bool, Float

from motorspace._types import Displacement, Pose, Walls
from motorspace.worlds.tiles import UNROLL, Tiles, in_groups

Batch = Float[Array, "*batch"]
Point = tuple[Batch, Batch]
Directions = tuple[Float[Array, "K *batch"], Float[Array, "K *batch"]]
Carry = TypeVar("Carry")

MARGIN = 1e-3
"""Half the thickness of a wall in world units. It dwarfs the rounding of float32 (4e-6 at
40 units), so that a move accepted here crosses no wall in exact arithmetic either."""


def wrap(angle: Batch) -> Batch:
    """The same angle in (-pi, pi], radians."""
    turn = 2 * jnp.pi
    return angle - turn * jnp.ceil((angle - jnp.pi) / turn)


def cos_sin(angle: Batch) -> tuple[Batch, Batch]:
    """Cosine and sine of angles of a few turns at most, radians; errors below 2e-7.

    The compiler evaluates its own one number after the other and, where they are used for many
    rays, once for each. These are the polynomials of Cephes (Moshier, 1992) on [-pi/4, pi/4],
    after whole quarters of a turn are taken off in three parts that float32 can subtract exactly.
    """
    quarters = jnp.round(angle * (2 / jnp.pi))
    rest = angle - quarters * 1.5703125 - quarters * 4.837512969970703e-4
    rest = rest - quarters * 7.549789948768648e-8
    square = rest * rest
    sin = ((-1.9515295891e-4 * square + 8.3321608736e-3) * square - 1.6666654611e-1) * square
    sin = sin * rest + rest
    cos = (2.443315711809948e-5 * square - 1.388731625493765e-3) * square + 4.166664568298827e-2
    cos = (cos * square - 0.5) * square + 1.0
    quadrant = quarters.astype(jnp.int32)
    odd = quadrant & 1 == 1
    cos, sin = jnp.where(odd, sin, cos), jnp.where(odd, cos, sin)
    return jnp.where((quadrant + 1) & 2 == 2, -cos, cos), jnp.where(quadrant & 2 == 2, -sin, sin)


def advance(pose: Pose, longitudinal: Batch, lateral: Batch) -> Pose:
    """The pose after a translation in the body's own frame, world units."""
    cos, sin = cos_sin(pose.heading)
    return Pose(
        pose.x + cos * longitudinal - sin * lateral,
        pose.y + sin * longitudinal + cos * lateral,
        pose.heading,
        pose.head,
    )


def relative(start: Pose, end: Pose) -> Displacement:
    """Displacement of the sensors from `start` to `end`: start^-1 o end in SE(2)."""
    cos, sin = cos_sin(start.gaze)
    dx, dy = end.x - start.x, end.y - start.y
    return jnp.stack([cos * dx + sin * dy, cos * dy - sin * dx, wrap(end.gaze - start.gaze)])


def compose(first: Displacement, then: Displacement) -> Displacement:
    """The displacement that undergoes `first` and after it `then`."""
    cos, sin = cos_sin(first[2])
    return jnp.stack(
        [
            first[0] + cos * then[0] - sin * then[1],
            first[1] + sin * then[0] + cos * then[1],
            wrap(first[2] + then[2]),
        ]
    )


def inverse(displacement: Displacement) -> Displacement:
    """The displacement that undoes another."""
    dx, dy, turn = displacement
    cos, sin = cos_sin(turn)
    return jnp.stack([-cos * dx - sin * dy, sin * dx - cos * dy, wrap(-turn)])


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
    frames = wall_frame(jnp.moveaxis(walls, 0, -1))
    nothing_near = jnp.full(place[0].shape, jnp.inf)
    return _over_walls(lambda least, wall: jnp.minimum(least, gap(wall)), nothing_near, frames)


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

    def cross(side: Batch, edge: Float[Array, "2 2"]) -> Batch:
        """`side` changes its sign with every edge to the right of the point."""
        (x0, y0), (x1, y1) = edge
        rise = jnp.where(y1 == y0, 1.0, y1 - y0)
        right = x0 + (y - y0) * ((x1 - x0) / rise) > x
        return jnp.where(((y0 > y) != (y1 > y)) & right, -side, side)

    return _over_walls(cross, jnp.ones(x.shape), edges) < 0


def cast(
    walls: Walls | Tiles,
    place: Point,
    directions: Directions,
    max_range: float,
) -> Float[Array, "K *batch"]:
    """Distance to the first wall along each ray, at most `max_range`; O(rays x walls).

    `directions` are the rays' cosines and sines. A ray's line meets a wall when its end points
    lie on both sides of it: s_a, s_b, the cross products of the direction with the end points,
    differ in sign. Two walls that share a corner see the same product, so nothing leaks through.
    The meeting point is (a x b) / (s_b - s_a) away. Its reciprocal needs one division for all
    the rays of a place, and is negative for what lies behind. In `Tiles` only walls are looked at
    that are nearer than what all rays have met.
    """
    if isinstance(walls, Tiles):
        return 1 / in_groups(
            lambda place, directions: walls.fold(
                _nearer(place, directions),
                jnp.full(directions[0].shape, 1 / max_range),
                place,
                lambda met: 1 / jnp.min(met, axis=0),
            ),
            place[0].shape,
            place,
            directions,
        )
    nothing_met = jnp.full(directions[0].shape, 1 / max_range)
    return 1 / _over_walls(_nearer(place, directions), nothing_met, walls)


def _nearer(place: Point, directions: Directions) -> Callable[[Array, Array], Array]:
    """How near the next wall is along each ray, if nothing before it was nearer: 1 / distance."""
    (x, y), (cos, sin) = place, directions

    def nearer(
        nearness: Float[Array, "K *batch"], wall: Float[Array, "2 2 *walls"]
    ) -> Float[Array, "K *batch"]:
        (ax, ay), (bx, by) = wall
        to_ax, to_ay = ax - x, ay - y
        side_a = cos * to_ay - sin * to_ax
        side_b = cos * (by - y) - sin * (bx - x)
        away = 1 / (to_ax * (by - ay) - to_ay * (bx - ax))
        met = (side_a >= 0) != (side_b >= 0)
        return jnp.maximum(nearness, jnp.where(met, (side_b - side_a) * away, 0.0))

    return nearer


def _over_walls(visit: Callable[[Carry, Any], Carry], start: Carry, walls: Any) -> Carry:
    """Fold `visit` over the walls, all agents at once.

    One wall at a time keeps every array as long as there are agents; a loop, rather than one
    expression, makes the compiler compute what `visit` closes over once and not per wall. The
    carry holds floats, since mixing them with flags keeps a loop from being vectorised.
    """

    def advance(found: Carry, wall: Any) -> tuple[Carry, None]:
        return visit(found, wall), None

    return jax.lax.scan(advance, start, walls, unroll=UNROLL)[0]
