"""Walks and references: bodies that do not do as they are told, and ways without codes."""

import jax
import jax.numpy as jnp
import numpy as np
import pytest

from motorspace.analysis.paths import absolute_error
from motorspace.mapping.references import reference_paths
from motorspace.mapping.trials import BIAS, MotorErrors
from motorspace.recordings.recording import Recording
from motorspace.trajectories.transitions import Experience
from tests.mapping.rooms import REACH, mounting, ranges, steps_of, walk

ALIKE = {"still", "raw", "kinematics", "regressor", "matcher", "matcher_loops"}


@pytest.fixture(scope="module")
def log():
    """A log whose odometry reads turns too narrow, and its true path."""
    truth = walk()
    steps = steps_of(truth) * np.array([[1.05], [1.05], [0.9]])
    num = truth.shape[1]
    recording = Recording(
        name="rooms",
        time=np.arange(num, dtype=float),
        sensors=ranges(truth, mounting().angles),
        increments=steps.T,
        interval=np.arange(num - 1),
        poses=np.concatenate([truth, np.zeros((1, num))]).T,
        sensor_scale=(REACH,) * 61,
        planar=True,
        usable=np.ones(num - 1, bool),
    )
    return recording, truth


def test_references_come_in_the_order_of_what_they_are_given(log):
    recording, truth = log
    paths = reference_paths(recording, truth)
    assert paths.keys() == ALIKE
    errors = {way: absolute_error(path, truth) for way, path in paths.items()}
    assert errors["matcher_loops"] < 0.1 < errors["raw"] < errors["still"]
    assert errors["kinematics"] < 0.5 * errors["raw"]
    assert errors["regressor"] < errors["raw"]


def test_a_body_does_what_commands_say_and_its_bias_beside():
    executed = jnp.arange(12.0).reshape(2, 3, 2)
    blank = jnp.zeros((2, 1))
    experience = Experience(blank, executed, jnp.full(2, 3), blank)

    def source(key, epoch):
        del key, epoch
        return experience

    def commanded(noise):
        return MotorErrors(source, noise, BIAS)(jax.random.key(0), jnp.int32(0)).motors

    np.testing.assert_allclose(commanded(0.0) + BIAS, executed, rtol=1e-6)
    spread = np.asarray((executed - BIAS) / commanded(0.05) - 1)
    assert 0.01 < np.abs(spread).mean() < 0.1
