"""Rays: how far it is to the next wall, and which wall that is."""

from collections.abc import Callable
from typing import NamedTuple

import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Float, Int

from motorspace._types import Pose, Scalar, Walls
from motorspace.se2 import cos_sin
from motorspace.worlds.tiles import Tiles, in_groups
from motorspace.worlds.walls import Point, over_walls

Directions = tuple[Float[Array, "K *batch"], Float[Array, "K *batch"]]
"""Cosines and sines."""

PACKED_BELOW = 128
"""So few walls that a nearness has bits to spare for their numbers."""

FARTHEST = 1e6
"""How far away a ray meets something that meets no wall, world units."""


class Met(NamedTuple):
    """What rays meet first."""

    nearness: Float[Array, "K *batch"]
    """1 / distance; 0 where there is no wall."""
    wall: Float[Array, "K *batch"]
    """The number of the wall, as a float; -1 where there is none."""


def fan_directions(angles: Float[np.ndarray, " K"], gaze: Float[Array, "*batch"]) -> Directions:
    """The directions of rays at these angles from the gaze, turned so that only it needs a sine."""
    cos, sin = cos_sin(gaze)

    def turned(ray: tuple[Scalar, Scalar]) -> tuple[Array, Array]:
        ray_cos, ray_sin = ray
        return ray_cos * cos - ray_sin * sin, ray_sin * cos + ray_cos * sin

    # A loop, since in one expression the compiler takes the gaze's sine for every ray.
    rays = jnp.asarray(np.cos(angles), jnp.float32), jnp.asarray(np.sin(angles), jnp.float32)
    return jax.lax.map(turned, rays)


def segments_of(
    pose: Pose, angles: Float[np.ndarray, " R"], ranges: Float[np.ndarray, " R"]
) -> Float[np.ndarray, "R 2 2"]:
    """What a picture shows of rays from one pose: segments that reach as far as the rays do."""
    x, y, gaze = map(float, pose.frame)
    ends = np.stack([x + ranges * np.cos(gaze + angles), y + ranges * np.sin(gaze + angles)], -1)
    return np.stack([np.broadcast_to([x, y], ends.shape), ends], axis=1)


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


def first_met(walls: Walls, tiles: Tiles | None, place: Point, directions: Directions) -> Met:
    """The first wall along each ray, however far away it is; O(rays x walls).

    As `cast`, which needs no wall's number. With `tiles` walls are looked up around each place,
    and all of them only for agents of whom a ray meets none of those.
    """
    if tiles is None and len(walls) < PACKED_BELOW:
        return _first_of_few(walls, place, directions)
    if tiles is None:
        return _first_of_all(walls, place, directions, _nothing(directions))

    def looked_up(place: Point, directions: Directions) -> Float[Array, "2 K *batch"]:
        start = _nothing(directions)
        near = tiles.fold(
            _earlier(place, directions),
            start._replace(nearness=start.nearness + 1 / tiles.reach),
            place,
            lambda met: 1 / jnp.min(met.nearness, axis=0),
            numbered=True,
        )
        met = jax.lax.cond(
            jnp.any(near.wall < 0),
            lambda: _first_of_all(walls, place, directions, near),
            lambda: near,
        )
        return jnp.stack(met)

    return Met(*in_groups(looked_up, place[0].shape, place, directions))


def _first_of_few(walls: Walls, place: Point, directions: Directions) -> Met:
    """The same with each wall's number in the lowest bits of its nearness: one array to carry.

    Of the 24 bits of precision those are lost that numbers take. It halves the time.
    """
    bits = (1 << len(walls).bit_length()) - 1

    def nearer(
        best: Int[Array, "K *batch"],
        numbered: tuple[Float[Array, "2 2 *walls"], Int[Array, "..."]],
    ) -> Int[Array, "K *batch"]:
        wall, number = numbered
        nearness = jnp.maximum(_nearness(place, directions, wall), 0.0)
        # Floats above zero are in the order of the whole numbers that their bits are.
        ordered = jax.lax.bitcast_convert_type(nearness, jnp.int32)
        return jnp.maximum(best, (ordered & ~bits) | number)

    numbers = jnp.arange(1, len(walls) + 1, dtype=jnp.int32)
    nothing = jnp.zeros(directions[0].shape, jnp.int32)
    best = over_walls(nearer, nothing, (walls, numbers))
    nearness = jax.lax.bitcast_convert_type(best & ~bits, jnp.float32)
    return Met(nearness, jnp.where(nearness > 0, (best & bits).astype(jnp.float32), 0.0) - 1)


def _first_of_all(walls: Walls, place: Point, directions: Directions, known: Met) -> Met:
    start = known._replace(nearness=jnp.where(known.wall < 0, 0.0, known.nearness))
    numbered = walls, jnp.arange(len(walls), dtype=jnp.float32)
    return over_walls(_earlier(place, directions), start, numbered)


def _nothing(directions: Directions) -> Met:
    zero = jnp.zeros_like(directions[0])
    return Met(zero, zero - 1)


def _earlier(place: Point, directions: Directions) -> Callable[[Met, tuple[Array, Array]], Met]:
    """What each ray meets first, if before a wall with a number it has met something already."""

    def earlier(met: Met, numbered: tuple[Float[Array, "2 2 *walls"], Float[Array, "..."]]) -> Met:
        wall, number = numbered
        nearness = _nearness(place, directions, wall)
        first = nearness > met.nearness
        return Met(jnp.where(first, nearness, met.nearness), jnp.where(first, number, met.wall))

    return earlier


def _nearer(place: Point, directions: Directions) -> Callable[[Array, Array], Array]:
    """How near the next wall is along each ray, if nothing before it was nearer: 1 / distance."""

    def nearer(
        nearness: Float[Array, "K *batch"], wall: Float[Array, "2 2 *walls"]
    ) -> Float[Array, "K *batch"]:
        return jnp.maximum(nearness, _nearness(place, directions, wall))

    return nearer


def _nearness(
    place: Point, directions: Directions, wall: Float[Array, "2 2 *walls"]
) -> Float[Array, "K *batch"]:
    """1 / distance of a wall along each ray; 0 or less where the ray does not meet it."""
    (x, y), (cos, sin), ((ax, ay), (bx, by)) = place, directions, wall
    to_ax, to_ay = ax - x, ay - y
    side_a = cos * to_ay[None] - sin * to_ax[None]
    side_b = cos * (by - y)[None] - sin * (bx - x)[None]
    away = 1 / (to_ax * (by - ay) - to_ay * (bx - ax))
    met = (side_a >= 0) != (side_b >= 0)
    return jnp.where(met, (side_b - side_a) * away[None], 0.0)
