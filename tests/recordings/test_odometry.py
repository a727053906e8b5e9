"""Raw and corrected logs: told apart by the data, and no motion is lost."""

import math

import numpy as np
import pytest

from motorspace import UserError
from motorspace.recordings.readers.base import read_log
from motorspace.recordings.readers.odometry import Track, across_scans, is_one_frame
from motorspace.recordings.recording import chained_per_interval
from tests.recordings.logs import corrected_log, flaser, odom, raw_log, robotlaser, write


@pytest.fixture
def read(tmp_path):
    """A function from the text of a log to its recording."""

    def reading(text, **options):
        return read_log(write(tmp_path / "robot.log", text), **options)

    return reading


def curved_log(num=40, noise=0.0, **options):
    """A raw log along a curve of changing speed and direction; what drives each interval."""
    rng = np.random.default_rng(0)
    lines, scans = [], []
    x = y = theta = 0.0
    for index in range(num):
        for step in range(3):
            time = index + step / 3
            if step == 0 and index:
                lines.append(flaser(x, y, theta, time=time))
                scans.append((x, y))
            speed, turn = rng.uniform(0.05, 0.2), rng.uniform(-0.2, 0.2)
            theta += turn
            x += speed * math.cos(theta)
            y += speed * math.sin(theta)
            lines.append(odom(x, y, theta, time=time + 0.2))
    return "\n".join(lines), np.hypot(*np.diff(scans, axis=0).T)


@pytest.mark.parametrize(
    ("claimed", "time"),
    [(1.5, 0.0), (1.1, 0.0), (1.05, 0.0), (1.5, 1.0), (1.05, 1.0), (0.95, 1.0), (0.5, 1.0)],
)
def test_increments_of_a_corrected_log_never_cross_a_scan(read, claimed, time):
    recording = read(corrected_log(claimed=claimed, time=time))
    assert np.bincount(recording.interval).tolist() == [2, 2, 2, 2, 2]
    half = claimed / 2
    expected = [half * math.cos(0.1), half * math.sin(0.1), 0.1]
    np.testing.assert_allclose(recording.increments[::2], [expected] * 5, atol=1e-9)
    np.testing.assert_allclose(recording.increments[1::2], [[half, 0, 0]] * 5, atol=1e-9)
    assert any("corrected log" in note for note in recording.notes)


@pytest.mark.parametrize("steps", [1, 2, 5])
@pytest.mark.parametrize("start", [0.5, 0.25, 0.0])
@pytest.mark.parametrize("scan", [flaser, robotlaser], ids=["FLASER", "ROBOTLASER1"])
def test_a_raw_log_loses_no_motion(read, steps, start, scan):
    recording = read(raw_log(steps=steps, start=start, scan=scan))
    np.testing.assert_allclose(chained_per_interval(recording), [[1.0, 0, 0]] * 7, atol=1e-9)
    assert any("raw odometry; true poses are unknown" in note for note in recording.notes)


def test_a_raw_log_along_a_curve_loses_no_motion(read):
    text, moved = curved_log()
    driven = chained_per_interval(read(text))
    np.testing.assert_allclose(np.hypot(*driven[:, :2].T), moved, atol=1e-9)


def test_rows_that_repeat_the_pose_of_a_scan_add_no_command(read):
    lines = []
    for index in range(6):
        lines += [odom(index, time=index), flaser(index, time=index), odom(index, time=index)]
        lines += [odom(index + 0.5, time=index + 0.5)]
    recording = read("\n".join(lines))
    assert recording.increments[:, 0].tolist() == [0.5] * 10


def test_a_standing_robot_executes_commands_that_do_not_move_it(read):
    lines = []
    for index in range(8):
        here = min(index, 4)
        lines += [flaser(here, time=index), odom(here, time=index), odom(here, time=index + 0.5)]
        lines += [odom(min(index + 1, 4), time=index + 0.9)]
    recording = read("\n".join(lines))
    assert recording.usable.all()
    assert chained_per_interval(recording)[:, 0].tolist() == [1, 1, 1, 1, 0, 0, 0]


def test_scans_written_late_stand_where_they_were_taken(read):
    """The odometry has gone on before the scan arrives in the log, as on real robots."""
    lines = [odom(step / 10, time=step / 10) for step in range(3)]
    for index in range(1, 8):
        lines += [odom(index + step / 10, time=index + step / 10) for step in (-0.5, 1, 2)]
        lines.append(flaser(index - 0.2, time=index))
    recording = read("\n".join(lines))
    np.testing.assert_allclose(chained_per_interval(recording)[:, 0], 1.0)
    assert (recording.increments[:, 0] > 0).all()


def test_corrected_poses_beside_raw_odometry_are_the_truth(read):
    lines = []
    for index in range(10):
        lines += [odom(index, time=index), odom(index + 0.5, time=index + 0.5)]
        raw = f"{index + 0.5} 0 0"
        lines.append(flaser(0.9 * index, 0.1 * index, time=index + 0.5, odometry=raw))
    recording = read("\n".join(lines))
    assert chained_per_interval(recording)[:, 0].tolist() == [1.0] * 9
    np.testing.assert_allclose(recording.poses[:, 1], 0.1 * np.arange(10))
    assert not any("unknown" in note for note in recording.notes)


def test_a_laser_in_front_of_the_robot_is_no_correction(read):
    lines = []
    for index in range(6):
        angle = 0.3 * index
        ahead = (index + 0.2 * math.cos(angle), 0.2 * math.sin(angle), angle)
        lines += [odom(index, 0.0, angle, time=index)]
        lines.append(flaser(*ahead, time=index, odometry=f"{index} 0 {angle}"))
    recording = read("\n".join(lines))
    assert any("true poses are unknown" in note for note in recording.notes)
    np.testing.assert_allclose(
        recording.poses[2, :3], [2 + 0.2 * math.cos(0.6), 0.2 * math.sin(0.6), 0.6]
    )


def test_scans_alone_with_odometry_of_their_own_are_enough(read):
    scans = [flaser(0.9 * i, 0.1 * i * i, time=i, odometry=f"{i} 0 0") for i in range(6)]
    recording = read("\n".join(scans))
    assert recording.increments.tolist() == [[1, 0, 0]] * 5
    np.testing.assert_allclose(recording.poses[:, 1], 0.1 * np.arange(6) ** 2)


SILENT = {
    "no odometry": [flaser(i, time=i) for i in range(4)],
    "one row": [flaser(0), odom(0), flaser(1, time=1)],
    "odometry after the last scan": [flaser(0), flaser(1, time=1), odom(1), odom(2)],
    "one row between scans, off their way": [
        line
        for i in range(9)
        for line in (flaser(i, (-1) ** i, time=i), odom(i + 0.8, time=i + 0.9))
    ],
}


@pytest.mark.parametrize("case", SILENT)
def test_a_log_whose_odometry_may_be_corrected_is_refused_unless_it_is_named_raw(read, case):
    text = "\n".join(SILENT[case])
    with pytest.raises(UserError, match=r"robot\.log: the log holds no raw odometry.*to raw if"):
        read(text)
    recording = read(text, odometry="raw")
    assert recording.usable.all()


def test_a_log_named_corrected_is_read_as_one(read):
    assert len(read(raw_log(steps=2), odometry="corrected").increments) == 7


def test_scans_without_poses_and_odometry_are_refused(read):
    text = "\n".join(robotlaser(0, i, row="RAWLASER1") for i in range(4))
    for odometry in ("auto", "raw"):
        with pytest.raises(UserError, match=r"no poses, and there is no odometry|no raw odometry"):
            read(text, odometry=odometry)


def tracked(rows):
    """A track from (x, y, angle, time, is a scan) rows."""
    table = np.array(rows, float)
    return Track(table[:, :3], table[:, 3], table[:, 4] == 1)


def test_the_frame_is_found_on_noisy_random_drives():
    """What was never corrected is raw; corrections of a tenth of a step are found."""
    rng = np.random.default_rng(1)
    for corrected in (False, True):
        rows, pose = [], np.zeros(3)
        for index in range(300):
            if corrected and index:
                pose = pose + rng.normal(0, 0.02, 3)
            rows += [(*pose, index, 1), (*pose, index, 0)]
            for step in (1, 2, 3):
                speed, turn = 0.2 + rng.normal(0, 0.02), rng.normal(0, 0.1)
                angle = pose[2] + turn
                pose = np.array(
                    [pose[0] + speed * np.cos(angle), pose[1] + speed * np.sin(angle), angle]
                )
                rows.append((*pose, index + step / 3, 0))
        assert is_one_frame(tracked(rows)) == (not corrected)


def test_poses_between_rows_follow_the_clock():
    rows = [
        (0, 0, 0, 0.0, 0),
        (np.nan,) * 3 + (0.5, 1),
        (2, 0, 0, 1.0, 0),
        (np.nan,) * 3 + (1.25, 1),
    ]
    _, poses = across_scans(tracked([*rows, (4, 0, 0, 2.0, 0)]))
    assert poses[:, 0].tolist() == [1.0, 2.5]
