"""The planner against ways that a person can measure."""

import jax.numpy as jnp
import numpy as np
import pytest

from motorspace import UserError
from motorspace.navigation.planner import corner_points, next_stop, survey, way_length, ways_to
from motorspace.worlds.layouts import Layout, layout
from motorspace.worlds.stacking import deal_worlds
from motorspace.worlds.world import LatticeWorld

WALL = Layout("a wall", (0.0, 0.0, 20.0, 20.0), (((10.0, 0.0), (10.0, 12.0)),))
PILLAR = Layout(
    "a pillar", (0.0, 0.0, 20.0, 20.0), (), (((8.0, 8.0), (12.0, 8.0), (12.0, 12.0), (8.0, 12.0)),)
)
CLOSED = Layout("closed", (0.0, 0.0, 20.0, 20.0), (((10.0, 0.0), (10.0, 20.0)),))


def ways(layouts, start, goal):
    """The shortest way in each of some layouts, and where to head for first."""
    worlds = [described.world() for described in layouts]
    walls = deal_worlds(worlds, len(worlds)).walls
    corners = survey(worlds)
    start, goal = ([jnp.full(len(worlds), c) for c in place] for place in (start, goal))
    to_goal = ways_to(walls, corners, tuple(goal))
    length = way_length(walls, corners, to_goal, tuple(goal), tuple(start))
    return length, np.stack(next_stop(walls, corners, to_goal, tuple(goal), tuple(start)), -1)


def test_a_way_bends_around_the_end_of_a_wall():
    length, stop = ways([WALL], (5.0, 6.0), (15.0, 6.0))
    np.testing.assert_allclose(length, 2 * np.hypot(5, 6), rtol=0.02)
    np.testing.assert_allclose(stop[0], (10, 12), atol=0.2)


def test_a_way_in_sight_is_straight():
    length, stop = ways([WALL], (5.0, 15.0), (15.0, 15.0))
    np.testing.assert_allclose(length, 10.0, rtol=1e-6)
    np.testing.assert_allclose(stop[0], (15, 15))


def test_a_way_around_a_pillar_and_through_a_closed_wall_in_one_batch():
    length, _ = ways([PILLAR, CLOSED, WALL], (2.0, 10.0), (18.0, 10.0))
    around = 2 * np.hypot(6, 2) + 4
    np.testing.assert_allclose(length[0], around, rtol=0.02)
    assert np.isinf(length[1])
    np.testing.assert_allclose(length[2], 2 * np.hypot(8, 2), rtol=0.02)


def test_nothing_bends_where_walls_meet():
    cross = (((5.0, 10.0), (15.0, 10.0)), ((10.0, 5.0), (10.0, 15.0)))
    crossing = Layout("a cross", (0.0, 0.0, 20.0, 20.0), cross).world()
    points = corner_points(np.asarray(crossing.walls, float))
    inside = points[((points > 1) & (points < 19)).all(axis=1)]
    assert len(inside) == 4, "the four ends, not the middle"


def test_every_room_of_the_bundled_layouts_is_connected():
    worlds = [layout(name) for name in ("paper", "four_rooms", "corridors", "pillars")]
    corners = survey(worlds)
    for number in range(len(worlds)):
        known = np.asarray(corners.x[:, number]) > 0
        assert known.sum() > 4
        assert np.isfinite(np.asarray(corners.between)[..., number][known][:, known]).all()


def test_a_lattice_has_no_walls_to_go_around():
    with pytest.raises(UserError, match="only walled worlds"):
        survey([LatticeWorld()])
