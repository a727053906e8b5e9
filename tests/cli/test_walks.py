"""Which walks there is a truth to score by."""

import dataclasses

import numpy as np
import pytest

from motorspace import se2
from motorspace.cli.walks import truth_of
from motorspace.recordings.recording import Recording


@pytest.fixture
def driven() -> Recording:
    """A robot's log, and where it was."""
    steps = np.tile([0.1, 0.0, 0.05], (10, 1))
    path = [np.zeros(3)]
    for step in steps:
        path.append(np.asarray(se2.compose(path[-1], step)))
    return Recording(
        name="log",
        time=np.arange(11.0),
        sensors=np.ones((11, 3)),
        increments=steps,
        interval=np.arange(10),
        poses=np.column_stack([np.stack(path), np.zeros(11)]),
        sensor_scale=(10.0,) * 3,
        planar=True,
        usable=np.ones(10, bool),
    )


def test_odometry_is_no_truth(driven):
    assert truth_of(dataclasses.replace(driven, odometry_poses=True)) is None


def test_known_poses_are(driven):
    np.testing.assert_allclose(truth_of(driven), driven.poses[:, :3].T)


def test_unknown_poses_are_none(driven):
    poses = np.full_like(driven.poses, np.nan)
    assert truth_of(dataclasses.replace(driven, poses=poses)) is None
