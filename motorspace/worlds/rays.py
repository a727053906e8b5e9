"""Rays: how far it is to the next wall."""

from collections.abc import Callable

import jax.numpy as jnp
from jaxtyping import Array, Float

from motorspace._types import Walls
from motorspace.worlds.tiles import Tiles, in_groups
from motorspace.worlds.walls import Point, over_walls

Directions = tuple[Float[Array, "K *batch"], Float[Array, "K *batch"]]


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
    return 1 / over_walls(_nearer(place, directions), nothing_met, walls)


def _nearer(place: Point, directions: Directions) -> Callable[[Array, Array], Array]:
    """How near the next wall is along each ray, if nothing before it was nearer: 1 / distance."""
    (x, y), (cos, sin) = place, directions

    def nearer(
        nearness: Float[Array, "K *batch"], wall: Float[Array, "2 2 *walls"]
    ) -> Float[Array, "K *batch"]:
        (ax, ay), (bx, by) = wall
        to_ax, to_ay = ax - x, ay - y
        side_a = cos * to_ay[None] - sin * to_ax[None]
        side_b = cos * (by - y)[None] - sin * (bx - x)[None]
        away = 1 / (to_ax * (by - ay) - to_ay * (bx - ax))
        met = (side_a >= 0) != (side_b >= 0)
        return jnp.maximum(nearness, jnp.where(met, (side_b - side_a) * away[None], 0.0))

    return nearer
