"""Logs that are odd rather than broken: read rightly, or told in one sentence."""

import pytest

from motorspace import UserError
from motorspace.recordings.readers.base import read_log
from motorspace.recordings.recording import describe

SCAN = "FLASER 2 1 1 {0} 0 0 {0} 0 0 {0} host {0}\n"
ROWS = "0,0.5,1\n1,0.25,3\n"


@pytest.mark.parametrize(
    "between",
    ["", "ODOM 0 0 0 0 0 0 0 host 0\n"],
    ids=["no odometry", "one row"],
)
def test_a_log_without_increments_is_told(tmp_path, between):
    path = tmp_path / "robot.log"
    path.write_text(SCAN.format(0) + between + SCAN.format(1))
    with pytest.raises(UserError, match=r"robot\.log: the log holds no raw odometry"):
        read_log(path)


def test_odometry_after_the_last_scan_is_no_increment(tmp_path):
    after = "ODOM 0 0 0 0 0 0 0 host 0\nODOM 1 0 0 0 0 0 0 host 0\n"
    path = tmp_path / "robot.log"
    path.write_text(SCAN.format(0) + SCAN.format(1) + after)
    with pytest.raises(UserError, match="no raw odometry"):
        read_log(path)


@pytest.mark.parametrize("prefix", ["", "\ufeff"], ids=["plain", "byte order mark"])
def test_blank_lines_and_a_byte_order_mark_are_no_values(tmp_path, prefix):
    path = tmp_path / "robot.csv"
    path.write_text(f"{prefix}time,motor_a,sensor_a\n{ROWS}\n", encoding="utf-8")
    recording = read_log(path)
    assert recording.time.tolist() == [0, 1]
    assert recording.increments.tolist() == [[0.5]]


def test_lines_are_still_numbered_after_a_blank_one(tmp_path):
    path = tmp_path / "robot.csv"
    path.write_text(f"time,motor_a,sensor_a\n\n{ROWS}2,fast,4\n")
    with pytest.raises(UserError, match="line 5: 'fast' is not a number"):
        read_log(path)


def test_columns_of_one_name_are_told(tmp_path):
    path = tmp_path / "robot.csv"
    path.write_text("time,motor_a,motor_a,sensor_a\n0,1,5,1\n1,2,6,2\n")
    with pytest.raises(UserError, match="more than one column is named motor_a"):
        read_log(path)


def test_description_gives_the_median_step(tmp_path):
    path = tmp_path / "robot.csv"
    rows = "0,0,1,0,0,0\n1,0,1,3,4,0\n2,0,1,3,5,0\n3,0,1,3,7,0\n"
    path.write_text(f"time,motor_a,sensor_a,x,y,theta\n{rows}")
    described = describe(read_log(path))
    assert described["step between scans (median)"] == 2.0
    assert described["path length"] == 8.0
