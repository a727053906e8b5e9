"""Shortest ways on the true map: which problems can be solved, and how well.

Among straight walls a shortest way bends only where walls end, so a graph of those points and of
the lines of sight between them answers exactly (Lozano-Pérez and Wesley, 1979). The points are
`CLEARANCE` away from the walls, and ways longer by about as much at each bend.
"""

import math
from collections.abc import Sequence

import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Float

from motorspace._types import Flags, Pose, Walls
from motorspace.worlds.simulation import to_agents_last
from motorspace.worlds.stacking import stack_worlds
from motorspace.worlds.walls import Point, gap_to_move, least_gap
from motorspace.worlds.world import AbstractWorld, WalledWorld

CLEARANCE = 0.1
"""How far from the end of a wall a way passes it, world units."""

TOUCHING = 2e-3
"""Walls that are nearer than this to each other meet, world units."""

Distances = Float[Array, "*batch"]

Goals = tuple[Float[Array, "G N"], Float[Array, "G N"]]
"""x and y of G places for each agent."""


class Corners(eqx.Module):
    """The points where ways bend, for each of N worlds or agents (last axis).

    Args:
        x: World units. Worlds with fewer points are padded with some that nothing leads to.
        y: World units.
        between: The length of the shortest way between two of them; infinite where there is none.
    """

    x: Float[Array, "V N"]
    y: Float[Array, "V N"]
    between: Float[Array, "V V N"]

    def at(self, rows: Array) -> "Corners":
        """Those of the worlds with these numbers."""
        return jax.tree.map(lambda leaf: leaf[..., rows], self)


def survey(worlds: Sequence[AbstractWorld]) -> Corners:
    """The points where ways bend in each of some walled worlds.

    Raises:
        UserError: As `stack_worlds`.
    """
    stacked = to_agents_last(stack_worlds(worlds))
    found = [corner_points(np.asarray(world.walls, float)) for world in _walled(worlds)]
    places = np.full((2, max(1, *map(len, found)), len(found)), np.nan, np.float32)
    for number, points in enumerate(found):
        places[:, : len(points), number] = points.T
    return _connected(stacked, *jnp.asarray(places))


def _walled(worlds: Sequence[AbstractWorld]) -> list[WalledWorld]:
    return [world for world in worlds if isinstance(world, WalledWorld)]


@jax.jit
def _connected(world: WalledWorld, x: Float[Array, "V W"], y: Float[Array, "V W"]) -> Corners:
    """Floyd and Warshall's shortest ways over the lines of sight; NaN stands for no point."""
    each = jax.tree.map(lambda leaf: leaf[..., None, :], world)
    nowhere = jnp.isnan(x) | ~each.free(_poses(x, y))
    pairs = (len(x), *x.shape)
    start = jnp.broadcast_to(x[:, None], pairs), jnp.broadcast_to(y[:, None], pairs)
    end = jnp.broadcast_to(x[None], pairs), jnp.broadcast_to(y[None], pairs)
    between = _seen_length(each.walls[..., None, :], start, end)
    between = jnp.where(nowhere[None] | nowhere[:, None], jnp.inf, between)

    def through(k: Array, between: Float[Array, "V V W"]) -> Float[Array, "V V W"]:
        return jnp.minimum(between, between[:, k, None] + between[None, k])

    between = jax.lax.fori_loop(0, len(x), through, between)
    return Corners(jnp.where(nowhere, 0.0, x), jnp.where(nowhere, 0.0, y), between)


def corner_points(walls: Float[np.ndarray, "S 2 2"]) -> Float[np.ndarray, "V 2"]:
    """The points beside the ends of walls around which a way can bend, world units."""
    ends = np.unique(np.round(walls.reshape(-1, 2), 4), axis=0)
    sides = [(end, _widest_side(end, walls)) for end in ends]
    bends = [end + CLEARANCE * side for end, side in sides if side is not None]
    return np.reshape(bends, (-1, 2))


def _widest_side(
    end: Float[np.ndarray, "2"], walls: Float[np.ndarray, "S 2 2"]
) -> Float[np.ndarray, "2"] | None:
    """The direction into the side of a wall's end that is wider than half a turn, if one is."""
    along = walls - end
    far = np.linalg.norm(along, axis=-1)
    span = walls[:, 1] - walls[:, 0]
    length = np.linalg.norm(span, axis=-1)
    across = np.abs(along[:, 0, 0] * span[:, 1] - along[:, 0, 1] * span[:, 0]) / length
    on_it = (across < TOUCHING) & (far.max(axis=1) < length + TOUCHING)
    directions = [a for wall in np.flatnonzero(on_it) for a in along[wall][far[wall] > TOUCHING]]
    angles = np.unique(np.round([math.atan2(dy, dx) for dx, dy in directions], 3))
    gaps = np.diff(angles, append=angles[0] + 2 * math.pi)
    widest = int(gaps.argmax())
    if gaps[widest] < math.pi + 0.01:
        return None
    middle = angles[widest] + gaps[widest] / 2
    return np.array([math.cos(middle), math.sin(middle)])


def in_sight(walls: Walls, start: Point, end: Point) -> Flags:
    """Whether the straight way between places meets no wall, for any batch of them."""
    poses = _poses(*start), _poses(*end)
    return least_gap(walls, lambda wall: gap_to_move(wall, *poses), start, start[0]) > 0


def ways_to(walls: Walls, corners: Corners, goal: Point) -> Float[Array, "V N"]:
    """The length of the shortest way from every corner to each agent's goal, world units."""
    last = _from_corners(walls, corners, goal)
    return jnp.min(corners.between + last[None], axis=1)


def way_length(
    walls: Walls, corners: Corners, to_goal: Float[Array, "V N"], goal: Point, place: Point
) -> Float[Array, " N"]:
    """The length of the shortest way from a place to a goal; infinite where there is none.

    Args:
        walls: Those of each agent's world, [S, 2, 2, N].
        corners: Where ways bend in it.
        to_goal: What `ways_to` answers for the goal.
        goal: x and y of each agent's goal, [N].
        place: x and y of each agent, [N].
    """
    around = _from_corners(walls, corners, place) + to_goal
    return jnp.minimum(_seen_length(walls, place, goal), around.min(axis=0))


def way_lengths(
    walls: Walls, corners: Corners, to_goals: Float[Array, "G V N"], goals: Goals, place: Point
) -> Float[Array, "G N"]:
    """The length of the shortest way from a place to each of G goals; see `way_length`."""
    bends = _from_corners(walls, corners, place)

    def one(goal: tuple[Array, Array, Array]) -> Float[Array, " N"]:
        x, y, to_goal = goal
        return jnp.minimum(_seen_length(walls, place, (x, y)), (bends + to_goal).min(axis=0))

    return jax.lax.map(one, (*goals, to_goals))


def next_stop(
    walls: Walls, corners: Corners, to_goal: Float[Array, "V N"], goal: Point, place: Point
) -> Point:
    """The first bend of the shortest way, or its end: where to head for. As `way_length`."""
    around = _from_corners(walls, corners, place) + to_goal
    best = jnp.argmin(around, axis=0)[None]
    direct = _seen_length(walls, place, goal) <= around.min(axis=0)

    def chosen(corner: Float[Array, "V N"], end: Float[Array, " N"]) -> Float[Array, " N"]:
        return jnp.where(direct, end, jnp.take_along_axis(corner, best, axis=0)[0])

    return chosen(corners.x, goal[0]), chosen(corners.y, goal[1])


def _from_corners(walls: Walls, corners: Corners, place: Point) -> Float[Array, "V N"]:
    """The straight way between every corner and each agent's place; infinite where none is."""
    x, y = (jnp.broadcast_to(c[None], corners.x.shape) for c in place)
    return _seen_length(walls[..., None, :], (corners.x, corners.y), (x, y))


def _seen_length(walls: Walls, start: Point, end: Point) -> Distances:
    length = jnp.hypot(end[0] - start[0], end[1] - start[1])
    return jnp.where(in_sight(walls, start, end), length, jnp.inf)


def _poses(x: Float[Array, "*batch"], y: Float[Array, "*batch"]) -> Pose:
    return Pose(x, y, jnp.zeros_like(x), jnp.zeros_like(x))
