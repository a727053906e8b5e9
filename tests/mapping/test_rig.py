"""What is known of a robot, in a file and for a walk that shows nothing."""

import json

import numpy as np
import pytest

from motorspace._errors import UserError
from motorspace.mapping.motion import chained
from motorspace.mapping.rig import CalibratedRig
from motorspace.mapping.rig_file import SHAPES
from motorspace.mapping.survey import survey
from motorspace.recordings.recording import Recording
from tests.mapping.robots import robot
from tests.mapping.rooms import REACH


def seeing_nothing(num: int, *, num_rays: int = 61, num_motors: int = 2, reach: float = REACH):
    random = np.random.default_rng(0)
    return Recording(
        name="nothing",
        time=np.arange(num + 1.0),
        sensors=np.full((num + 1, num_rays), reach),
        increments=random.uniform(-1, 1, (num, num_motors)),
        interval=np.arange(num),
        poses=np.full((num + 1, 4), np.nan),
        sensor_scale=(reach,) * num_rays,
        planar=False,
        usable=np.ones(num, bool),
    )


def test_a_calibration_is_read_as_it_was_written(tmp_path):
    robot().save(tmp_path / "robot.json")
    read = CalibratedRig.load(tmp_path / "robot.json")
    written = robot()
    for one, other in (
        (read.rig.odometry, written.rig.odometry),
        (read.rig.mounting, written.rig.mounting),
        (read.motion, written.motion),
    ):
        for name, value in one._asdict().items():
            np.testing.assert_array_equal(value, getattr(other, name))
    np.testing.assert_array_equal(read.rig.frame, written.rig.frame)
    assert read.rig.per_scan is True and read.rig.odometry.has_gaze is False


@pytest.mark.parametrize("num", [1, 2, 40])
def test_where_nothing_is_seen_there_is_odometry_and_its_covariance(num):
    known = robot()
    scans = known.rig.scans(seeing_nothing(num))
    found = survey(scans, known.motion)
    np.testing.assert_array_equal(found.poses, chained(known.motion.corrected(scans.steps)))
    assert len(found.loops.first) == 0 and found.motion is known.motion
    covariance = known.motion.covariance(scans.steps)
    assert covariance.shape == (num, 3, 3) and np.linalg.eigvalsh(covariance).min() > 0


@pytest.mark.parametrize(
    ("other", "sentence"),
    [
        ({"num_motors": 3}, "commands of 3 values; calibrate on a walk of this robot"),
        ({"num_rays": 30}, "30 rays instead of 61"),
        ({"reach": 8.0}, "readings up to 8 instead of 10"),
    ],
)
def test_a_calibration_of_another_robot_is_refused(other, sentence):
    with pytest.raises(UserError, match=sentence):
        robot().rig.scans(seeing_nothing(5, **other))


def without(name):
    def change(written):
        section, _, key = name.partition(".")
        del written[section][key]

    return change


def changed(name, value):
    def change(written):
        section, _, key = name.partition(".")
        written[section][key] = value

    return change


@pytest.mark.parametrize("name", SHAPES)
@pytest.mark.parametrize(
    ("value", "sentence"),
    [
        (np.nan, "numbers that are not finite"),
        ([[1.0], [2.0, 3.0]], "numbers alone"),
        ("12", "numbers alone"),
        (None, "numbers alone"),
        ([[[1.0]]], r"is of shape \[1, 1, 1\]"),
        ([], r"is of shape \[0\]"),
    ],
)
def test_a_broken_array_is_refused(name, value, sentence, tmp_path):
    refused(tmp_path, changed(name, value), f"robot.json: {name} .*{sentence}")


@pytest.mark.parametrize(
    ("change", "sentence"),
    [
        (lambda written: written.update(format_version=2), "version 2, and this program reads"),
        (lambda written: written.update(motion=[1]), "motion.twist is missing"),
        (without("rig.per_scan"), "rig.per_scan is missing"),
        (changed("rig.per_scan", 1), "rig.per_scan is neither true nor false"),
        (changed("odometry.gaze", [[1.0] * 4]), r"shape \[1, 4\], not \['F', 4\]"),
        (changed("motion.strength", [-1.0] * 12), "motion.strength is below 0"),
        (changed("mounting.reach", 0.0), "mounting.reach is not above 0"),
    ],
)
def test_what_makes_no_sense_is_refused(change, sentence, tmp_path):
    refused(tmp_path, change, sentence)


def refused(folder, change, sentence):
    path = folder / "robot.json"
    robot().save(path)
    written = json.loads(path.read_text())
    change(written)
    path.write_text(json.dumps(written))
    with pytest.raises(UserError, match=sentence):
        CalibratedRig.load(path)


@pytest.mark.parametrize("content", [b"", b"{", b"[1]", b"{}", b"\xff\xfe\x00", b"[" * 100_000])
def test_a_file_of_another_kind_is_no_calibration(content, tmp_path):
    (tmp_path / "other.json").write_bytes(content)
    with pytest.raises(UserError, match=r"other.json: this is no calibration; calibrate anew"):
        CalibratedRig.load(tmp_path / "other.json")
    with pytest.raises(UserError, match="cannot be read"):
        CalibratedRig.load(tmp_path)
    with pytest.raises(UserError, match="cannot be read"):
        CalibratedRig.load(tmp_path / "none.json")
