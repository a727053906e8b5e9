"""The index of walls answers exactly as visiting all of them does."""

import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np
import pytest
import shapely

from motorspace import Pose, RangeFan, Scenario, WalledWorld, sample
from motorspace.worlds.layouts import INDEXED_FROM, layout
from motorspace.worlds.rooms import random_rooms
from motorspace.worlds.tiles import FAR_AWAY, GROUP, REACH, tiled

SENSE = eqx.filter_jit(lambda fan, world, pose: fan.sense(world, pose))
BLOCKED = eqx.filter_jit(lambda world, start, end: world.blocked(start, end))
FREE = eqx.filter_jit(lambda world, pose: world.free(pose))


def scattered(num, size=30.0):
    """Short walls anywhere, and one that crosses the whole world."""
    rng = np.random.default_rng(num)
    start = rng.uniform(0, size, (num - 1, 2))
    walls = np.stack([start, start + rng.normal(0, 1.0, start.shape)], axis=1)
    walls = np.concatenate([walls, [[[0.0, 1.0], [size, size - 1.0]]]])
    return walls, (0.0, 0.0, size, size)


def worlds(walls, bounds):
    """The same world without an index and with one."""
    plain = WalledWorld(jnp.asarray(walls, jnp.float32), jnp.zeros((0, 2, 2)), bounds)
    indexed = WalledWorld(plain.walls, plain.solids, bounds, tiled(walls, bounds))
    return plain, indexed


def poses(num, size, seed=0):
    rng = np.random.default_rng(seed)
    x, y = jnp.asarray(rng.uniform(0, size, (2, num)), jnp.float32)
    heading = jnp.asarray(rng.uniform(-np.pi, np.pi, num), jnp.float32)
    return Pose(x, y, heading, 0 * x)


@pytest.mark.parametrize("num_walls", [1, 9, 400])
@pytest.mark.parametrize("max_range", [2.0, REACH, 15.0])
def test_scans_are_the_same(num_walls, max_range):
    plain, indexed = worlds(*scattered(num_walls))
    here, fan = poses(3 * GROUP + 5, 30.0), RangeFan(max_range=max_range)
    found = SENSE(fan, indexed, here)
    np.testing.assert_allclose(found, SENSE(fan, plain, here), rtol=1e-6)
    assert float(found.min()) < max_range


@pytest.mark.parametrize("length", [1.0, 8.0, 20.0])
def test_the_same_moves_are_forbidden(length):
    """Also where a move is longer than the tiles reach."""
    plain, indexed = worlds(*scattered(300))
    start, end = poses(700, 30.0), poses(700, 30.0, seed=1)
    share = length / jnp.hypot(end.x - start.x, end.y - start.y).clip(length)
    end = Pose(
        start.x + share * (end.x - start.x),
        start.y + share * (end.y - start.y),
        *(2 * [start.head]),
    )
    found = BLOCKED(indexed, start, end)
    np.testing.assert_array_equal(found, BLOCKED(plain, start, end))
    assert found.any() and not (length == 1.0 and found.all())


def test_the_same_places_are_free():
    walls, bounds = scattered(300)
    plain, indexed = worlds(walls, bounds)
    # Half of the places next to walls, where it matters.
    ends = np.resize(walls[:, 0], (400, 2)) + np.random.default_rng(2).normal(0, 2e-3, (400, 2))
    there = Pose(*jnp.asarray(ends.T, jnp.float32), *jnp.zeros((2, 400)))
    for place in (poses(400, 30.0), there):
        np.testing.assert_array_equal(FREE(indexed, place), FREE(plain, place))
    assert 0 < FREE(indexed, there).sum() < 400


def test_one_agent_and_any_batch_are_answered_alike():
    _, indexed = worlds(*scattered(200))
    many, fan = poses(6, 30.0), RangeFan()
    expected = SENSE(fan, indexed, many)
    square = SENSE(fan, indexed, jax.tree.map(lambda field: field.reshape(2, 3), many))
    each = [Pose(*fields) for fields in zip(many.x, many.y, many.heading, many.head, strict=True)]
    alone = jnp.stack([SENSE(fan, indexed, pose) for pose in each])
    np.testing.assert_array_equal(square.reshape(9, 6), expected)
    np.testing.assert_allclose(alone.T, expected, rtol=1e-6)


def test_a_tile_lists_every_wall_within_reach_and_none_nearer_than_it_says():
    walls, bounds = scattered(60)
    tiles = tiled(walls, bounds)
    columns, rows = tiles.num_tiles
    segments = shapely.linestrings(walls)
    for tile in range(0, columns * rows, 7):
        x, y = tiles.side * (tile // rows), tiles.side * (tile % rows)
        distances = shapely.distance(segments, shapely.box(x, y, x + tiles.side, y + tiles.side))
        listed = np.asarray(tiles.walls[tile]).reshape(-1, 4)
        listed = listed[listed[:, 0] < FAR_AWAY]
        for wall, distance in zip(walls.reshape(-1, 4), distances, strict=True):
            place = np.flatnonzero(np.isclose(listed, wall, atol=1e-5).all(axis=1))
            assert len(place) == 1 or distance > REACH
            if len(place):
                assert tiles.gaps[tile, place[0] // 8] <= distance + 1e-4


@pytest.mark.slow
def test_layouts_of_many_walls_are_indexed_and_give_the_same_trajectories():
    rooms = random_rooms(size=120.0, key=jax.random.key(0))
    world = rooms.world()
    assert layout("paper").tiles is None
    assert len(world.walls) >= INDEXED_FROM and world.tiles is not None
    plain = eqx.tree_at(lambda w: w.tiles, world, None)
    drawn = [sample(Scenario(w), num=300, horizon=4, key=jax.random.key(1)) for w in (world, plain)]
    jax.tree.map(lambda a, b: np.testing.assert_allclose(a, b, atol=1e-5), *drawn)
