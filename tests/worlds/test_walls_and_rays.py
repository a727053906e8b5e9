"""Rays and crossings agree with shapely."""

import jax
import jax.numpy as jnp
import numpy as np
import pytest
import shapely
from hypothesis import given, settings
from hypothesis import strategies as st

from motorspace import Pose
from motorspace.se2 import cos_sin
from motorspace.worlds.layouts import layout
from motorspace.worlds.rays import cast
from motorspace.worlds.walls import MARGIN, gap_to_move, gap_to_point, inside, least_gap


def point(x, y):
    zero = jnp.zeros(())
    return Pose(jnp.float32(x), jnp.float32(y), zero, zero)


def range_by_shapely(walls, origin, angle, max_range):
    """Distance along a ray to walls, float64."""
    end = origin + max_range * np.array([np.cos(angle), np.sin(angle)])
    met = shapely.intersection(shapely.linestrings([origin, end]), shapely.linestrings(walls))
    points = met[~shapely.is_empty(met)]
    return shapely.distance(shapely.points(origin), points).min(initial=max_range)


@pytest.mark.parametrize("name", ["paper", "pillars", "rooms:3"])
def test_cast_agrees_with_shapely(name):
    world, rng = layout(name), np.random.default_rng(1)
    origins = rng.uniform(1, 39, (400, 2)).astype(np.float32)
    angles = rng.uniform(-np.pi, np.pi, 400).astype(np.float32)
    found = cast(
        world.walls, tuple(jnp.asarray(origins.T)), cos_sin(jnp.asarray(angles)[None]), 10.0
    )[0]
    walls = np.asarray(world.walls, np.float64)
    expected = [
        range_by_shapely(walls, o, a, 10.0)
        for o, a in zip(origins.astype(float), angles.astype(float), strict=True)
    ]
    np.testing.assert_allclose(found, expected, atol=1e-3)
    assert min(expected) < 5 and max(expected) == 10.0


def test_no_ray_leaks_through_a_corner():
    """Towards the ends of an unbroken outline a ray never reads farther than the corner."""
    world, rng = layout("empty"), np.random.default_rng(2)
    read = jax.jit(lambda x, y, angles: cast(world.walls, (x, y), cos_sin(angles), 100.0))
    for origin in rng.uniform(1, 39, (50, 2)):
        corners = np.asarray(world.walls[:, 0], float) - origin
        angles = jnp.asarray(np.arctan2(corners[:, 1], corners[:, 0]), jnp.float32)
        found = read(*jnp.asarray(origin, jnp.float32), angles)
        np.testing.assert_allclose(found, np.hypot(*corners.T), rtol=1e-4)


def test_a_ray_along_a_wall_reads_a_wall_and_no_nonsense():
    wall = jnp.array([[[2.0, 0.0], [5.0, 0.0]]])
    edge_on = cast(wall, (jnp.float32(0), jnp.float32(0)), cos_sin(jnp.zeros(1)), 10.0)[0]
    assert any(np.isclose(edge_on, reading) for reading in (2.0, 5.0, 10.0))
    grazing = cast(wall, (jnp.float32(0), jnp.float32(1e-3)), cos_sin(jnp.array([-2.5e-4])), 10.0)[
        0
    ]
    np.testing.assert_allclose(grazing, 4.0, atol=1e-2)


def test_rays_behind_and_beyond_the_range_read_the_range():
    wall = jnp.array([[[2.0, -1.0], [2.0, 1.0]]])
    readings = cast(wall, (jnp.float32(0), jnp.float32(0)), cos_sin(jnp.array([0.0, np.pi])), 10.0)
    np.testing.assert_allclose(readings, [2.0, 10.0])
    assert cast(wall, (jnp.float32(0), jnp.float32(0)), cos_sin(jnp.zeros(1)), 1.5)[0] == 1.5


whole = st.integers(-8, 8).map(lambda v: v / 4)
corner = st.tuples(whole, whole)
GAP_TO_MOVE = jax.jit(
    lambda walls, start, end: least_gap(
        walls, lambda wall: gap_to_move(wall, start, end), (start.x, start.y), jnp.float32(0)
    )
)


@settings(max_examples=300, deadline=None)
@given(corner, corner, corner, corner, st.floats(-2e-3, 2e-3))
def test_gaps_to_moves_agree_with_shapely(a, b, start, end, nudge):
    """On a coarse grid touching, collinear and degenerate cases are common."""
    if a == b:
        return
    end = (end[0] + nudge, end[1])
    crossed = GAP_TO_MOVE(jnp.array([[a, b]]), point(*start), point(*end)) <= 0
    distance = shapely.distance(
        shapely.LineString([a, b]), shapely.LineString([start, np.float32(end)])
    )
    if distance == 0:
        assert crossed
    if distance > 1.5 * MARGIN:
        assert not crossed


def test_gaps_to_points_and_inside():
    square = [(0, 0), (2, 0), (2, 2), (0, 2)]
    edges = jnp.array([*zip(square, square[1:] + square[:1], strict=True)], float)
    x, y = jnp.array([2 + MARGIN, 2 + 3 * MARGIN]), jnp.ones(2)
    gaps = least_gap(edges, lambda wall: gap_to_point(wall, x, y), (x, y), 0 * x)
    np.testing.assert_array_equal(gaps > 0, [False, True])
    x, y = jnp.array([0.1, 2.1, -1.0]), jnp.array([1.9, 1.0, 1.0])
    np.testing.assert_array_equal(inside(edges, x, y), [True, False, False])
