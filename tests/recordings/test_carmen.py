"""CARMEN logs: which rows are read, and what they say."""

import math

import numpy as np
import pytest

from motorspace import UserError
from motorspace.recordings.readers.base import read_log
from tests.recordings.logs import RANGES, corrected_log, flaser, odom, raw_log, robotlaser, write


@pytest.fixture
def read(tmp_path):
    """A function from the text of a log to its recording."""

    def reading(text, name="robot.log", **options):
        return read_log(write(tmp_path / name, text), **options)

    return reading


def with_scans(scan, num=5, **options):
    """A raw log with one row of odometry between two scans that `scan` writes."""
    lines = []
    for index in range(num):
        lines += [odom(index, time=index), scan(index, time=index, **options)]
    return "\n".join(lines)


def test_a_scan_is_thinned_out_to_rays_from_right_to_left(read):
    recording = read(corrected_log())
    assert recording.sensors.shape == (6, 9)
    assert recording.sensors[:, 0].tolist() == [10.0] * 6
    assert recording.sensors[:, 4].tolist() == [0.5] * 6
    assert recording.sensor_scale == (10.0,) * 9


@pytest.mark.parametrize(
    ("beams", "ahead"), [(9, 4), (10, 5), (18, 9), (180, 90), (181, 90), (360, 180), (361, 180)]
)
def test_one_ray_looks_straight_ahead(read, beams, ahead):
    ranges = " ".join(str(1 + index / 100) for index in range(beams))
    for num_rays in (1, 3):
        recording = read(with_scans(flaser, ranges=ranges), num_rays=num_rays)
        assert recording.sensors[0, num_rays // 2] == pytest.approx(1 + ahead / 100)


def test_a_narrow_view_leaves_out_the_sides(read):
    recording = read(with_scans(flaser), num_rays=3, field_of_view=math.pi / 2)
    assert recording.sensors[0].tolist() == [3, 5, 3]


def test_scans_of_different_numbers_of_beams_are_read_by_angle(read):
    double = " ".join(word for word in RANGES.split() for _ in (0, 1))
    lines = [odom(0, time=0)]
    for index in range(6):
        lines += [flaser(index, time=index, ranges=(RANGES, double)[index % 2])]
        lines += [odom(index + 0.5, time=index + 0.5), odom(index + 1, time=index + 1)]
    recording = read("\n".join(lines))
    assert (recording.sensors == [1, 2, 3, 4, 5, 4, 3, 2, 1]).all()
    assert any("number of beams varies (9 in 3 scans, 18 in 3" in note for note in recording.notes)


def test_more_rays_than_beams_are_noted(read):
    recording = read(with_scans(flaser, ranges="1 2 3"))
    assert set(recording.sensors[0].tolist()) == {1, 2, 3}
    assert any("scans of 3 beams" in note for note in recording.notes)


def test_newer_rows_say_what_the_laser_sees(read):
    everywhere = read(with_scans(robotlaser, first=-math.pi), field_of_view=2 * math.pi)
    assert everywhere.sensors[0].tolist() == [1, 2, 3, 4, 5, 4, 3, 2, 1]
    ahead = read(with_scans(robotlaser, first=-math.pi))
    assert ahead.sensors[0, [0, 4, 8]].tolist() == [3, 5, 3]
    assert everywhere.time.tolist() == [0, 1, 2, 3, 4]
    assert everywhere.poses[:, 0].tolist() == [0, 1, 2, 3, 4]


def test_a_laser_that_does_not_look_ahead_is_told(read):
    first = 0.5
    row = f"ROBOTLASER1 0 {first} 1.0 0.5 80 0.01 0 3 1 2 3 0 0 0 0 0 0 0 0 0 0 0 0"
    text = "\n".join([odom(0), *(f"{row} {i} h {i}\n{odom(i)}" for i in range(4))])
    with pytest.raises(UserError, match="the laser sees 29 to 86 degrees"):
        read(text, num_rays=1)
    assert read(text).sensors[0, -1] == 3


def test_the_range_of_a_newer_row_bounds_the_readings(read):
    recording = read(with_scans(robotlaser, limit=4.0))
    assert recording.sensor_scale == (4.0,) * 9
    assert recording.sensors[0].tolist() == [1, 2, 3, 4, 4, 4, 3, 2, 1]


def test_raw_rows_stand_where_the_odometry_was_at_their_time(read):
    def late(x, time):
        return robotlaser(x, time + 0.25, row="RAWLASER1")

    recording = read(with_scans(late))
    assert recording.poses[:-1, 0].tolist() == [0.25, 1.25, 2.25, 3.25]
    assert recording.increments[:2, 0].tolist() == [0.75, 0.25]
    assert np.bincount(recording.interval).tolist()[:3] == [2, 2, 2]


@pytest.mark.parametrize("row", ["RLASER", "REMISSIONRLASER", "ROBOTLASER2"])
def test_another_laser_is_an_option(read, row):
    ranges = " ".join(f"{word} 0.5" for word in RANGES.split())

    def scan(x, time):
        if row == "ROBOTLASER2":
            return robotlaser(x, time, row=row)
        if row == "RLASER":
            return flaser(x, time=time, row=row)
        return flaser(x, time=time, ranges=ranges, row=row).replace(" 18 ", " 9 ")

    assert read(with_scans(scan), laser="rear").sensors[0].tolist() == [1, 2, 3, 4, 5, 4, 3, 2, 1]
    with pytest.raises(UserError, match="no scans of the front laser; it has those of the rear"):
        read(with_scans(scan))


def test_of_two_kinds_of_rows_for_one_laser_the_first_is_read(read):
    both = with_scans(lambda x, time: f"{robotlaser(x, time)}\n{flaser(x, time=time)}")
    recording = read(both)
    assert len(recording) == 5
    assert any("5 ROBOTLASER1" in note for note in recording.notes)


def test_rows_of_other_kinds_are_counted(read):
    text = corrected_log() + "SYNC x\nNMEA-GGA 1\nNMEA-GGA 2\nTRUEPOS 0 0 0 0 0 0\n"
    (note,) = (note for note in read(text).notes if "not read" in note)
    assert note == "rows that are not read: 2 NMEA-GGA, 1 TRUEPOS, 1 SYNC, 1 PARAM"


@pytest.mark.parametrize("words", [3, 6, 7])
def test_old_rows_without_times_or_odometry(read, words):
    lines = []
    for index in range(5):
        tail = [str(index), "0", "0", str(index), "0", "0", str(10 * index)][:words]
        lines += [odom(index), f"FLASER 9 {RANGES} {' '.join(tail)}"]
    recording = read("\n".join(lines))
    assert recording.time.tolist() == [(10 if words == 7 else 1) * index for index in range(5)]
    assert recording.increments[:, 0].tolist() == [1] * 4
    numbered = any("numbered instead" in note for note in recording.notes)
    assert numbered == (words < 7)


def test_a_maximum_range_between_ranges_and_pose_is_skipped(read):
    lines = []
    for index in range(5):
        lines += [
            odom(index),
            f"FLASER 9 {RANGES} 81.91 {index} 0 0 {index} 0 0 {index} host {index}",
        ]
    recording = read("\n".join(lines))
    assert recording.poses[:, 0].tolist() == [0, 1, 2, 3, 4]
    assert recording.time.tolist() == [0, 1, 2, 3, 4]


def test_clocks_that_cannot_be_read_are_named(read):
    text = raw_log(num=8).replace("2.5 host 2.5", "soon host soon")
    recording = read(text)
    assert recording.usable.tolist() == [True, False, False, True, True, True, True]
    assert "2 whose time stamps cannot be read (first after scan 1)" in recording.notes[-1]
    wild = read(raw_log(num=8).replace("2.5 host 2.5", "1e18 host 1e18"))
    assert wild.usable.tolist() == [True, False, False, True, True, True, True]
    assert ", up to 1e+18 s" in wild.notes[-1]


def test_a_log_cut_off_in_its_last_row_loses_that_row_alone(read):
    recording = read(raw_log(num=8) + flaser(9.0)[:15])
    assert len(recording) == 8
    assert any("cut off" in note for note in recording.notes)


BROKEN = {
    "cut number of beams": ("FLASER 5 1 2\n" * 3, "line 1: a FLASER row of 5 beams ends after 4"),
    "text for a range": (
        corrected_log().replace(" 0.5", " half", 1),
        "line 3: 'half' is not a number",
    ),
    "a pose that is not finite": (
        raw_log().replace("ODOM 1.75", "ODOM nan"),
        "line 6: 'nan' is not finite",
    ),
    "no beams": ("FLASER x\n" * 3, "line 1: 'x' is not a number"),
    "endless beams": ("FLASER inf 1\n" * 3, "line 1: a FLASER row begins with its number of beams"),
    "short odometry": (
        "FLASER 1 1\nODOM 1 2\nFLASER 1 1",
        "line 2: an ODOM row needs x, y and theta",
    ),
    "short new row": ("ROBOTLASER1 0 1\n" * 3, "line 1: the ROBOTLASER1 row is too short"),
    "one scan": (flaser(0) + "\n" + odom(0), "the log holds 1 scans; at least two are needed"),
    "no scans": (
        odom(0) + "\n" + odom(1),
        "holds no scans of the front laser; give a log with FLA",
    ),
    "part of a pose": ("FLASER 1 1 0 0\n" * 3, "line 1: a pose of 2 numbers follows the ranges"),
}


@pytest.mark.parametrize("case", BROKEN)
def test_broken_logs_name_file_and_line(read, tmp_path, case):
    text, message = BROKEN[case]
    with pytest.raises(UserError) as error:
        read(text)
    assert str(tmp_path / "robot.log") in str(error.value)
    assert message in str(error.value)


@pytest.mark.parametrize(
    "options",
    [
        {"num_rays": 0},
        {"max_range": -1.0},
        {"field_of_view": 0.0},
        {"max_gap": 0.0},
        {"laser": "up"},
    ],
)
def test_options_that_make_no_sense_are_refused(read, options):
    with pytest.raises(UserError):
        read(raw_log(), **options)
