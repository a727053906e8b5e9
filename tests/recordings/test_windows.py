"""Transitions, splits, and what is part of none."""

import re

import jax
import numpy as np
import pytest

from motorspace import UserError
from motorspace.recordings.readers.base import read_log
from motorspace.recordings.recording import describe, transition_starts
from motorspace.recordings.rules import leave_out
from motorspace.recordings.windows import split_blocks, windows
from tests.recordings.logs import corrected_log, flaser, odom, raw_log, write


@pytest.fixture
def read(tmp_path):
    """A function from the text of a log or table to its recording."""

    def reading(text, **options):
        return read_log(write(tmp_path / "robot", text), **options)

    return reading


def table(times, motors=None, x=None):
    """A table with a row for each time; sensor_a numbers the rows."""
    motors = motors or [0.5] * len(times)
    x = x or range(len(times))
    rows = [
        f"{t},{m},{index},{p},0,0"
        for index, (t, m, p) in enumerate(zip(times, motors, x, strict=True))
    ]
    return "\n".join(["time,motor_a,sensor_a,x,y,theta", *rows])


def test_windows_chain_commands_or_keep_every_increment(read):
    recording = read(corrected_log())
    per_scan = windows(recording, horizon=2, per_scan=True)
    raw = windows(recording, horizon=2, per_scan=False)
    assert per_scan.experience.motors.shape == (4, 2, 3)
    assert raw.experience.motors.shape == (4, 4, 3)
    assert raw.experience.num_steps.tolist() == [4] * 4
    np.testing.assert_allclose(per_scan.displacements.nominal, raw.displacements.nominal, atol=1e-6)
    np.testing.assert_allclose(
        per_scan.displacements.nominal[:, :2],
        1.5 * np.asarray(per_scan.displacements.achieved[:, :2]),
        atol=1e-5,
    )


def test_sequences_of_unequal_length_are_padded_with_zeros(read):
    lines = [flaser(0), odom(0), odom(1), flaser(0, time=1)]
    lines += [odom(0), odom(1), odom(3), flaser(0, time=2)]
    recording = read("\n".join(lines), odometry="corrected")
    experience = windows(recording, horizon=1, per_scan=False).experience
    assert experience.num_steps.tolist() == [1, 2]
    assert experience.motors[:, :, 0].tolist() == [[1, 0], [1, 2]]


def test_intervals_without_a_command_are_no_command_of_zero(read):
    lines = []
    for index in range(8):
        lines.append(flaser(0.9 * index, time=index))
        if index != 3:
            lines += [odom(0.9 * index, time=index), odom(0.9 * index + 1, time=index + 1)]
    recording = read("\n".join(lines), odometry="corrected")
    assert recording.usable.tolist() == [True, True, True, False, True, True, True]
    assert "1 without a motor command (first after scan 3)" in recording.notes[-1]
    transitions = windows(recording, horizon=2, per_scan=True)
    assert transition_starts(recording, 2).tolist() == [0, 1, 4, 5]
    assert (np.asarray(transitions.experience.motors)[..., 0] == 1).all()


REGULAR = [float(step) for step in range(12)]
CLOCKS = {
    "regular": (REGULAR, [], ""),
    "one gap": (
        [*REGULAR[:6], *(t + 600 for t in REGULAR[6:])],
        [5],
        "1 longer than 10 s, up to 601",
    ),
    "a step back": (
        [*REGULAR[:6], *(t - 5 for t in REGULAR[6:])],
        [5],
        "1 where time runs backwards (first after scan 5)",
    ),
    "a correction of the clock": (
        [*REGULAR[:6], *(t - 1.4 for t in REGULAR[6:])],
        [],
        "the clock steps back 1 times by at most half the usual interval (0.4 s): kept",
    ),
    "a scan twice": ([*REGULAR[:6], *REGULAR[5:11]], [5], "1 where time stands still"),
    "backwards": (REGULAR[::-1], range(11), "11 of 11 intervals between scans"),
    "a coarse clock": ([t // 4 for t in REGULAR], [], "the clock is too coarse"),
    "no clock": ([0.0] * 12, [], "the time stamps do not change or cannot be read"),
    "an unreadable clock": (["soon"] * 12, [], "the time stamps do not change or cannot be read"),
    "an unreadable stamp": (
        [*REGULAR[:6], "?", *REGULAR[7:]],
        [5, 6],
        "2 whose time stamps cannot",
    ),
    "a corrupt stamp": ([*REGULAR[:6], 1e18, *REGULAR[7:]], [5, 6], "1 where time runs backwards"),
}


@pytest.mark.parametrize("case", CLOCKS)
def test_clocks(read, case):
    times, left_out, note = CLOCKS[case]
    recording = read(table(times))
    assert np.flatnonzero(~recording.usable).tolist() == list(left_out)
    assert note in "".join(recording.notes)
    assert read(table(times), clock="ignore").usable.all()


def test_limits_are_options(read):
    times = [*REGULAR[:6], *(t + 4 for t in REGULAR[6:])]
    assert read(table(times)).usable.all()
    assert (~read(table(times), max_gap=4.5).usable).sum() == 1
    gap = CLOCKS["one gap"][0]
    assert read(table(gap), max_gap=1e9).usable.all()
    jump = [*range(6), *range(56, 62)]
    assert np.flatnonzero(~read(table(REGULAR, x=jump)).usable).tolist() == [5]
    assert read(table(REGULAR, x=jump), max_jump=100.0).usable.all()
    assert not read(table(REGULAR, x=jump), max_jump=0.5).usable.any()


def test_jumps_of_the_odometry_are_left_out(read):
    lines = []
    for index in range(10):
        here = index + 50 * (index > 4)
        lines += [
            flaser(here, time=index),
            odom(here, time=index),
            odom(here + 0.5, time=index + 0.5),
        ]
    recording = read("\n".join(lines))
    assert np.flatnonzero(~recording.usable).tolist() == [4]
    assert "1 that jump in position (first after scan 4)" in recording.notes[-1]


def test_a_robot_that_mostly_stands_does_not_jump_when_it_drives(read):
    x = np.cumsum([0.0] * 30 + [0.01] * 3 + [0.3] * 6 + [0.0] * 20).tolist()
    assert read(table([float(t) for t in range(len(x))], x=x)).usable.all()


def test_an_interval_counts_for_one_reason(read):
    times = [*REGULAR[:6], *(t + 600 for t in REGULAR[6:])]
    recording = read(table(times, x=[*range(6), *range(56, 62)]))
    assert recording.notes[-1].startswith("left out: 1 of 11 intervals")
    assert "jump" not in recording.notes[-1]


def test_rules_applied_twice_change_nothing(read):
    recording = read(table(CLOCKS["one gap"][0]))
    again = leave_out(recording, max_gap=None, max_jump=None, clock="check")
    assert (again.usable == recording.usable).all()


def test_blocks_share_no_scan(read):
    recording = read(corrected_log(200))
    parts = split_blocks(recording, horizon=3, num_blocks=10, key=jax.random.key(0))
    scans = [{int(s) + k for s in part for k in range(4)} for part in parts]
    assert not scans[0] & scans[1] and not scans[0] & scans[2] and not scans[1] & scans[2]
    assert [len(part) for part in parts] == [6 * 17, 2 * 17, 2 * 17]


def test_blocks_are_rows_of_the_windows_that_are_left(read):
    times = np.arange(60.0) + 600 * (np.arange(60) > 33)
    recording = read(table(times.tolist()))
    transitions = windows(recording, horizon=2, per_scan=True)
    parts = split_blocks(recording, horizon=2, num_blocks=6, key=jax.random.key(0))
    whole = split_blocks(
        read(table(np.arange(60.0).tolist())), horizon=2, num_blocks=6, key=jax.random.key(0)
    )
    seen = [np.asarray(transitions[part].experience.sensors[:, 0], int).tolist() for part in parts]
    expected = [[scan for scan in part if scan not in (32, 33)] for part in map(list, whole)]
    assert seen == expected


def test_too_few_scans_say_how_many_are_enough(read):
    recording = read(raw_log(40))
    with pytest.raises(UserError) as error:
        split_blocks(recording, horizon=5, num_blocks=20, key=jax.random.key(0))
    enough, fewer = map(
        int, re.findall(r"(\d+) scans are enough .* num_blocks (\d+)", str(error.value))[0]
    )
    split_blocks(recording, horizon=5, num_blocks=fewer, key=jax.random.key(0))
    split_blocks(read(raw_log(enough)), horizon=5, num_blocks=20, key=jax.random.key(0))
    for num_blocks in (0, 1, 2, 3):
        with pytest.raises(UserError, match="choose at least 5 blocks"):
            split_blocks(recording, horizon=1, num_blocks=num_blocks, key=jax.random.key(0))
    split_blocks(recording, horizon=1, num_blocks=5, key=jax.random.key(0))


@pytest.mark.parametrize("horizon", [0, -1, 3, 4])
def test_a_recording_too_short_for_its_horizon(read, horizon):
    recording = read(corrected_log(3))
    with pytest.raises(UserError, match=f"3 scans hold no transition over {horizon} scans"):
        windows(recording, horizon=horizon, per_scan=True)


def test_a_recording_of_which_nothing_is_left_says_so(read):
    recording = read(table(REGULAR[::-1]))
    with pytest.raises(UserError, match="11 of 11 intervals between scans are left out; see why"):
        windows(recording, horizon=1, per_scan=True)
    described = describe(recording)
    assert described["intervals left out"] == 11
    assert described["notes"] == list(recording.notes)


def test_description_of_a_corrected_log(read):
    described = describe(read(corrected_log(11)))
    assert described["scans"] == 11
    assert described["duration in seconds"] == 10
    assert described["path length"] == pytest.approx(10)
    assert described["increments per interval (median)"] == 2
    assert described["drift of chained increments at the end"] > 1
