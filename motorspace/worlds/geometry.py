"""Plane geometry on arrays: angles, displacements in SE(2), walls and rays."""

import jax.numpy as jnp
from jaxtyping import Array, Bool, Float

from motorspace._types import Displacement, Flag, Pose, Scalar, Walls

MARGIN = 1e-3
"""Half the thickness of a wall in world units. It dwarfs the rounding of float32 (4e-6 at
40 units), so that a move accepted here crosses no wall in exact arithmetic either."""


def wrap(angle: Float[Array, "*batch"]) -> Float[Array, "*batch"]:
    """The same angle in (-pi, pi], radians."""
    return jnp.pi - jnp.mod(jnp.pi - angle, 2 * jnp.pi)


def advance(pose: Pose, longitudinal: Scalar, lateral: Scalar) -> Pose:
    """The pose after a translation in the body's own frame, world units."""
    cos, sin = jnp.cos(pose.heading), jnp.sin(pose.heading)
    return Pose(
        pose.x + cos * longitudinal - sin * lateral,
        pose.y + sin * longitudinal + cos * lateral,
        pose.heading,
        pose.head,
    )


def relative(start: Pose, end: Pose) -> Displacement:
    """Displacement of the sensors from `start` to `end`: start^-1 o end in SE(2)."""
    cos, sin = jnp.cos(start.gaze), jnp.sin(start.gaze)
    dx, dy = end.x - start.x, end.y - start.y
    return jnp.stack([cos * dx + sin * dy, cos * dy - sin * dx, wrap(end.gaze - start.gaze)])


def compose(first: Displacement, then: Displacement) -> Displacement:
    """The displacement that undergoes `first` and after it `then`."""
    cos, sin = jnp.cos(first[2]), jnp.sin(first[2])
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
    cos, sin = jnp.cos(turn), jnp.sin(turn)
    return jnp.stack([-cos * dx - sin * dy, sin * dx - cos * dy, wrap(-turn)])


def touches(walls: Walls, x: Scalar, y: Scalar) -> Flag:
    """Whether a point lies within two margins of any wall; O(walls).

    The second margin keeps an accepted end point outside the thickness that `crosses` tests
    at the next step, however it is rounded.
    """
    along, across, half = _in_wall_frame(walls, x, y)
    reach = 2 * MARGIN
    return jnp.any((jnp.abs(along) < half + reach) & (jnp.abs(across) < reach))


def crosses(walls: Walls, start: Pose, end: Pose) -> Flag:
    """Whether a straight move meets any wall, taken one margin thick on every side; O(walls).

    A move misses a wall's box when one of three axes separates them: along the wall, across
    it, or across the move (separating axis theorem; Gottschalk, Lin and Manocha, 1996).
    """
    a0, b0, half = _in_wall_frame(walls, start.x, start.y)
    a1, b1, _ = _in_wall_frame(walls, end.x, end.y)
    da, db, length = a1 - a0, b1 - b0, half + MARGIN
    apart_along = jnp.abs(a0 + a1) > 2 * length + jnp.abs(da)
    apart_across = jnp.abs(b0 + b1) > 2 * MARGIN + jnp.abs(db)
    apart_sideways = jnp.abs(a0 * db - b0 * da) > length * jnp.abs(db) + MARGIN * jnp.abs(da)
    return jnp.any(~(apart_along | apart_across | apart_sideways))


def _in_wall_frame(
    walls: Walls, x: Scalar, y: Scalar
) -> tuple[Float[Array, " S"], Float[Array, " S"], Float[Array, " S"]]:
    """Coordinates of a point along and across every wall from its middle; half lengths."""
    middle, half_span = (walls[:, 0] + walls[:, 1]) / 2, (walls[:, 1] - walls[:, 0]) / 2
    half = jnp.hypot(half_span[:, 0], half_span[:, 1])
    ux, uy = half_span[:, 0] / half, half_span[:, 1] / half
    dx, dy = x - middle[:, 0], y - middle[:, 1]
    return ux * dx + uy * dy, ux * dy - uy * dx, half


def inside(edges: Walls, x: Scalar, y: Scalar) -> Flag:
    """Whether a point lies inside the closed polygons drawn by `edges` (even-odd rule)."""
    (x0, y0), (x1, y1) = (edges[:, 0, 0], edges[:, 0, 1]), (edges[:, 1, 0], edges[:, 1, 1])
    straddles: Bool[Array, " S"] = (y0 > y) != (y1 > y)
    rise = jnp.where(y1 == y0, 1.0, y1 - y0)
    right = x0 + (y - y0) / rise * (x1 - x0) > x
    return jnp.sum(straddles & right) % 2 == 1


def cast(
    walls: Walls, x: Scalar, y: Scalar, angles: Float[Array, " K"], max_range: float
) -> Float[Array, " K"]:
    """Distance to the first wall along each ray, at most `max_range`; O(rays x walls).

    A ray's line meets a wall when its end points lie on both sides of it: s_a, s_b, the
    cross products of the direction with the end points, differ in sign. Two walls that
    share a corner see the same product, so nothing leaks through. The meeting point is
    interpolated between the ends, so that its error stays small when the wall is seen
    nearly edge-on.
    """
    cos, sin = jnp.cos(angles)[:, None], jnp.sin(angles)[:, None]
    dx, dy = walls[:, :, 0] - x, walls[:, :, 1] - y
    side_a = cos * dy[None, :, 0] - sin * dx[None, :, 0]
    side_b = cos * dy[None, :, 1] - sin * dx[None, :, 1]
    ahead_a = cos * dx[None, :, 0] + sin * dy[None, :, 0]
    ahead_b = cos * dx[None, :, 1] + sin * dy[None, :, 1]
    between = (side_a >= 0) != (side_b >= 0)
    share = side_a / jnp.where(between, side_a - side_b, 1.0)
    distance = ahead_a + share * (ahead_b - ahead_a)
    hit = between & (distance >= 0)
    return jnp.min(jnp.where(hit, distance, max_range), axis=1, initial=max_range)
