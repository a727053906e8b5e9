"""What each sense reads, against readings computed by hand."""

import jax.numpy as jnp
import numpy as np
import pytest

from motorspace import LatticeWorld, NodeIndex, Pose, RangeFan, layout

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
    assert fan.scale(EMPTY) == (10.0,) * 9 + (np.pi / 2,)


@pytest.mark.parametrize(("quarters", "index"), [(0, 0), (1, 1), (2, 2), (-1, 3), (-2, 2)])
def test_node_and_orientation_are_one_hot(quarters, index):
    world = LatticeWorld(6, 6)
    sensors = NodeIndex().sense(world, Pose(*jnp.array([2.0, 3.0, quarters * np.pi / 2, 0.0])))
    assert np.flatnonzero(sensors).tolist() == [3 * 6 + 2, 36 + index]
    assert len(NodeIndex().scale(world)) == len(sensors) == 40
