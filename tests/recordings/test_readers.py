"""Readers of robots' logs on small synthetic files; on the real ones where they lie nearby."""

import gzip
import math
import os
from pathlib import Path

import jax
import numpy as np
import pytest

from motorspace import UserError
from motorspace.recordings.readers.base import read_log
from motorspace.recordings.recording import chained, describe, relative_poses, split_blocks, windows

DATA = Path(os.environ.get("MOTORSPACE_DATA", Path(__file__).parents[3] / "shared" / "data"))


def flaser(pose: tuple[float, float, float], beams: int = 5, time: float = 0.0) -> str:
    ranges = " ".join(str(0.5 + 20.0 * (i == 0)) for i in range(beams))
    x, y, theta = pose
    return f"FLASER {beams} {ranges} {x} {y} {theta} {x} {y} {theta} {time} host {time}"


def odom(x: float, y: float, theta: float) -> str:
    return f"ODOM {x} {y} {theta} 0 0 0 0 host 0"


def carmen_text(num: int = 6) -> str:
    """A robot that turns left by 0.1 and moves 1 ahead; its odometry claims 1.5 ahead."""
    lines = ["# a comment", "PARAM robot_width 0.4 host 0"]
    x = y = theta = 0.0
    for scan in range(num):
        lines += [flaser((x, y, theta), time=float(scan)), odom(x, y, theta)]
        turned = theta + 0.1
        for share in (0.75, 1.5):
            lines.append(odom(x + share * math.cos(turned), y + share * math.sin(turned), turned))
        x, y, theta = x + math.cos(turned), y + math.sin(turned), turned
    return "\n".join(lines) + "\n"


def write(path: Path, text: str) -> Path:
    if path.suffix == ".gz":
        path.write_bytes(gzip.compress(text.encode()))
    else:
        path.write_text(text)
    return path


@pytest.mark.parametrize("name", ["robot.log", "robot.log.gz", "robot.clf"])
def test_carmen_increments_never_cross_a_scan(tmp_path, name):
    recording = read_log(write(tmp_path / name, carmen_text()))
    assert len(recording) == 6
    assert np.bincount(recording.interval).tolist() == [2, 2, 2, 2, 2]
    expected = [0.75 * math.cos(0.1), 0.75 * math.sin(0.1), 0.1]
    np.testing.assert_allclose(recording.increments[::2], [expected] * 5, atol=1e-9)
    np.testing.assert_allclose(recording.increments[1::2], [[0.75, 0, 0]] * 5, atol=1e-9)
    assert recording.sensors.shape == (6, 9)
    assert recording.sensors[:, 0].tolist() == [10.0] * 6  # no return: clipped to the range
    assert recording.sensors[:, 4].tolist() == [0.5] * 6


def test_windows_chain_commands_or_keep_every_increment(tmp_path):
    recording = read_log(write(tmp_path / "robot.log", carmen_text()))
    per_scan = windows(recording, horizon_scans=2, per_scan=True)
    raw = windows(recording, horizon_scans=2, per_scan=False)
    assert per_scan.experience.motors.shape == (4, 2, 3)
    assert raw.experience.motors.shape == (4, 4, 3)
    assert raw.experience.num_steps.tolist() == [4] * 4
    np.testing.assert_allclose(per_scan.displacements.nominal, raw.displacements.nominal, atol=1e-6)
    np.testing.assert_allclose(
        per_scan.displacements.nominal[:, :2],
        1.5 * np.asarray(per_scan.displacements.achieved[:, :2]),
        atol=1e-5,
    )


def test_sequences_of_unequal_length_are_padded_with_zeros(tmp_path):
    lines = [flaser((0, 0, 0)), odom(0, 0, 0), odom(1, 0, 0), flaser((0, 0, 0))]
    lines += [odom(0, 0, 0), odom(1, 0, 0), odom(3, 0, 0), flaser((0, 0, 0))]
    recording = read_log(write(tmp_path / "robot.log", "\n".join(lines)))
    experience = windows(recording, horizon_scans=1, per_scan=False).experience
    assert experience.num_steps.tolist() == [1, 2]
    assert experience.motors[:, :, 0].tolist() == [[1, 0], [1, 2]]


def test_blocks_share_no_scan(tmp_path):
    recording = read_log(write(tmp_path / "robot.log", carmen_text(200)))
    parts = split_blocks(recording, horizon=3, num_blocks=10, key=jax.random.key(0))
    scans = [{int(s) + k for s in part for k in range(4)} for part in parts]
    assert not scans[0] & scans[1] and not scans[0] & scans[2] and not scans[1] & scans[2]
    assert [len(part) for part in parts] == [6 * 17, 2 * 17, 2 * 17]


def test_chaining_undoes_taking_apart():
    rng = np.random.default_rng(0)
    poses = rng.uniform(-3, 3, (20, 3))
    increments = relative_poses(poses[:-1], poses[1:])
    np.testing.assert_allclose(
        chained(increments[None])[0], relative_poses(poses[:1], poses[-1:])[0], atol=1e-9
    )


BROKEN = {
    "cut number of beams": ("FLASER 5 1 2", "line 1: a FLASER row of 5 beams ends after 4 words"),
    "text for a number": (
        carmen_text().replace(" 0.5", " half", 1),
        "line 3: 'half' is not a number",
    ),
    "not finite": (carmen_text().replace(" 0.5", " nan", 1), "line 3: 'nan' is not a number"),
    "no beams": ("FLASER", "line 1: a FLASER row begins with its number of beams"),
    "short odometry": ("ODOM 1 2", "line 1: an ODOM row needs x, y and theta"),
    "empty": ("", "the log holds 0 FLASER rows; at least two are needed"),
}


@pytest.mark.parametrize("case", BROKEN)
def test_broken_carmen_logs_name_file_and_line(tmp_path, case):
    text, message = BROKEN[case]
    with pytest.raises(UserError) as error:
        read_log(write(tmp_path / "robot.log", text))
    assert str(tmp_path / "robot.log") in str(error.value)
    assert message in str(error.value)


def test_a_cut_gzip_file_is_told(tmp_path):
    path = write(tmp_path / "robot.log.gz", carmen_text(500))
    path.write_bytes(path.read_bytes()[:-200])
    with pytest.raises(UserError, match="the gzip file is cut off"):
        read_log(path)


def test_unknown_and_missing_files(tmp_path):
    with pytest.raises(UserError, match="belongs to no known format; give a file that ends in"):
        read_log(write(tmp_path / "robot.bag", "x"))
    with pytest.raises(UserError, match="cannot be read \\(No such file or directory\\)"):
        read_log(tmp_path / "nowhere.log")


TABLE = "time,motor_a,sensor_a,sensor_b\n0,0.5,1,2\n1,0.25,3,4\n2,0.1,5,-6\n"


def test_tables_of_both_kinds_say_the_same(tmp_path):
    parquet = pytest.importorskip("pyarrow.parquet")
    from pyarrow import csv

    path = write(tmp_path / "robot.csv", TABLE)
    parquet.write_table(csv.read_csv(path), tmp_path / "robot.parquet")
    for recording in (read_log(path), read_log(tmp_path / "robot.parquet")):
        assert recording.increments.tolist() == [[0.5], [0.25]]
        assert recording.sensor_scale == (5.0, 6.0)
        transitions = windows(recording, horizon_scans=2, per_scan=True)
        assert transitions.experience.motors.tolist() == [[[0.5], [0.25]]]
        assert transitions.experience.later_sensors.tolist() == [[5, -6]]
        assert np.isnan(transitions.displacements.achieved).all()
        assert describe(recording)["scans"] == 3


BROKEN_TABLES = {
    "no motors": ("time,sensor_a\n0,1\n1,2\n", "at least one motor_*"),
    "ragged": (TABLE + "3,1\n", "line 5: 2 values for 4 columns"),
    "text": (TABLE.replace("0.25", "fast"), "line 3: 'fast' is not a number"),
    "one row": ("time,motor_a,sensor_a\n0,1,1\n", "the table holds 1 rows"),
    "empty": ("", "the table is empty"),
}


@pytest.mark.parametrize("case", BROKEN_TABLES)
def test_broken_tables_are_told(tmp_path, case):
    text, message = BROKEN_TABLES[case]
    with pytest.raises(UserError) as error:
        read_log(write(tmp_path / "robot.csv", text))
    assert message in str(error.value)


def test_a_recording_too_short_for_its_horizon(tmp_path):
    recording = read_log(write(tmp_path / "robot.log", carmen_text(3)))
    with pytest.raises(UserError, match="3 scans hold no transition over 3 scans"):
        windows(recording, horizon_scans=3, per_scan=True)


@pytest.mark.parametrize(
    ("name", "scans", "drift"),
    [("intel-corrected.log.gz", 910, 61.8), ("freiburg-079-corrected.log.gz", 4791, 45.6)],
)
def test_recorded_robots(name, scans, drift):
    if not (DATA / name).exists():
        pytest.skip("the recorded log is not here; set MOTORSPACE_DATA to its folder")
    described = describe(read_log(DATA / name))
    assert described["scans"] == scans
    assert described["drift of chained increments at the end"] == pytest.approx(drift, abs=0.1)
