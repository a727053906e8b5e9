"""What each sense reads, against readings computed by hand."""

import jax.numpy as jnp
import numpy as np
import pytest

from motorspace import LatticeWorld, NodeIndex, Pose, RangeFan, UserError
from motorspace.worlds.layouts import layout

EMPTY = layout("empty")


def test_the_fan_reads_right_to_left_about_the_gaze():
    # Heading +x with the head turned to +y: right is the wall x = 40, left is out of range.
    pose = Pose(*jnp.array([37.0, 36.0, 0.0, np.pi / 2]))
    readings = RangeFan(3).sense(EMPTY, pose)
    np.testing.assert_allclose(readings, [3.0, 4.0, 10.0], rtol=1e-5)


def test_the_fan_spans_its_field_of_view():
    readings = RangeFan(3, 100.0, np.pi / 2).sense(EMPTY, Pose(*jnp.array([30.0, 20, 0, 0])))
    np.testing.assert_allclose(readings, [10 * 2**0.5, 10.0, 10 * 2**0.5], rtol=1e-5)


def test_the_sensed_head_is_the_last_sensor():
    fan = RangeFan(9, sense_head=True)
    readings = fan.sense(EMPTY, Pose(*jnp.array([20.0, 20.0, 1.0, 0.25])))
    assert readings.shape == (10,) and readings[-1] == 0.25
    np.testing.assert_array_equal(readings[:9], 10.0)
    space = fan.space(EMPTY)
    assert space.scale == (10.0,) * 9 + (np.pi / 2,)
    assert (space.low[-1], space.high[-1], space.names[-1]) == (-np.pi, np.pi, "head")


@pytest.mark.parametrize(("quarters", "index"), [(0, 0), (1, 1), (2, 2), (-1, 3), (-2, 2)])
def test_node_and_orientation_are_one_hot(quarters, index):
    world = LatticeWorld(6, 6)
    sensors = NodeIndex().sense(world, Pose(*jnp.array([2.0, 3.0, quarters * np.pi / 2, 0.0])))
    assert np.flatnonzero(sensors).tolist() == [3 * 6 + 2, 36 + index]
    space = NodeIndex().space(world)
    assert space.size == len(sensors) == 40
    assert space.names[np.flatnonzero(sensors)[0]] == "node_2_3"


def test_a_single_ray_looks_straight_ahead():
    pose = Pose(*jnp.array([37.0, 20.0, 0.0, 0.0]))
    np.testing.assert_allclose(RangeFan(1).sense(EMPTY, pose), [3.0], rtol=1e-5)


def test_rays_end_where_they_read():
    pose = Pose(*jnp.array([37.0, 36.0, 0.0, np.pi / 2]))
    rays = RangeFan(3).rays(EMPTY, pose)
    np.testing.assert_array_equal(rays[:, 0], [[37, 36]] * 3)
    np.testing.assert_allclose(rays[:, 1], [[40, 36], [37, 40], [27, 36]], atol=1e-4)
    assert NodeIndex().rays(LatticeWorld(), pose).shape == (0, 2, 2)


@pytest.mark.parametrize(
    ("options", "message"),
    [
        ({"num_rays": 0}, "num_rays must be at least 1, got 0"),
        ({"max_range": 0.0}, "max_range must be above 0 and finite, got 0"),
        ({"max_range": np.inf}, "max_range must be above 0 and finite, got inf"),
        ({"field_of_view": -1.0}, "field_of_view must be above 0 and at most 6.28319 radians"),
        ({"field_of_view": 7.0}, "field_of_view must be above 0 and at most 6.28319 radians"),
        ({"field_of_view": np.nan}, "field_of_view must be above 0 .* got nan"),
    ],
)
def test_impossible_fans_are_refused(options, message):
    with pytest.raises(UserError, match=message):
        RangeFan(**options)


def test_a_world_that_cannot_be_sensed_is_refused():
    with pytest.raises(UserError, match="a RangeFan cannot sense a LatticeWorld; choose a layout"):
        RangeFan().space(LatticeWorld())
    with pytest.raises(UserError, match=r"a NodeIndex cannot sense a WalledWorld; .*lattice:6"):
        NodeIndex().space(EMPTY)
