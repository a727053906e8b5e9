"""Logs of wheel encoders: columns, geometry, and what is broken in them."""

import math

import numpy as np
import pytest

from motorspace import UserError
from motorspace.recordings.catalog import reader_for
from motorspace.recordings.readers.base import read_log
from motorspace.recordings.readers.encoders import EncoderReader
from motorspace.recordings.readers.motion import Motion, commanded, driven, interpolated, ordered
from motorspace.testing.reader import check_reader
from tests.recordings.logs import write

METRE = 2000 / (2 * math.pi * 0.077)
"""Counts in a metre of the way."""


def log(num=12, left=0.1, right=0.12, beams=61, other=21, changed=None):
    """Rows as of the CoreSLAM logs: time, one number, left, right, 21 more, and the ranges."""
    rows = []
    for k in range(num):
        ranges = [1000 + 10 * beam + k for beam in range(beams)]
        row = [100_000 * k + 5_000_000, 14_000, left * METRE * k, right * METRE * k]
        rows.append([*row, *[7] * other, *ranges])
    for (k, column), value in (changed or {}).items():
        rows[k][column] = value
    return "\n".join(" ".join(map(str, row)) for row in rows) + "\n"


def test_the_counts_become_arcs(tmp_path):
    path = write(tmp_path / "exp.dat", log())
    assert reader_for(path) == "encoders"
    found = check_reader(EncoderReader(num_rays=3, field_of_view=2.0), path)
    assert len(found) == 12 and found.planar and found.usable.all()
    turn = 0.02 / 0.33
    ahead = 0.11 * np.sinc(turn / 2 / math.pi) * math.cos(turn / 2)
    np.testing.assert_allclose(found.increments[:, 0], ahead, atol=1e-9)
    np.testing.assert_allclose(found.increments[:, 2], turn, atol=1e-9)
    assert np.diff(found.time) == pytest.approx(0.1)
    assert found.sensors[0, 1] == pytest.approx(1.3)


def test_columns_and_geometry_are_options(tmp_path):
    rows = "".join(f"{k} {3 * k} {k} " + "2 " * 60 + "\n" for k in range(5))
    path = write(tmp_path / "own.txt", rows)
    options = {
        "time_unit": "s",
        "left_column": 2,
        "right_column": 1,
        "ranges_column": 3,
        "range_unit": 1.0,
        "ticks_per_turn": 2 * math.pi,
        "wheel_radius": 0.1,
        "track": 0.5,
    }
    found = read_log(path, reader="encoders", **options)
    np.testing.assert_allclose(found.increments[:, 2], 0.4)
    assert (found.sensors == 2).all()
    with pytest.raises(UserError, match="the columns are 0, 2, 2, 25: they have to differ"):
        read_log(path, right_column=2)
    with pytest.raises(UserError, match="laser_view must be from -2 to 2"):
        read_log(path, laser_view=9.0)


def test_error_codes_of_the_laser_and_its_direction(tmp_path):
    path = write(tmp_path / "a.dat", log(changed={(0, 55): 6, (1, 55): 0, (2, 55): -4}))
    found = read_log(path, num_rays=1)
    assert found.sensors[:3, 0].tolist() == [10, 10, 10]
    assert any("3 of 12 readings" in n or "1 of 12 readings are invalid" in n for n in found.notes)
    left = read_log(path, num_rays=3, laser_view=-4.18)
    right = read_log(path, num_rays=3, laser_view=4.18)
    np.testing.assert_array_equal(left.sensors[3:], right.sensors[3:, ::-1])


BROKEN = {
    "a word": {(4, 2): "left"},
    "no number": {(4, 3): "nan"},
    "a word among the ranges": {(4, 40): "--"},
}


@pytest.mark.parametrize("case", BROKEN)
def test_broken_rows_are_named_or_left_out(tmp_path, case):
    path = write(tmp_path / "a.dat", log(changed=BROKEN[case]))
    with pytest.raises(UserError, match=r"a\.dat, line 5: .*skip_bad"):
        read_log(path, reader="encoders")
    found = read_log(path, reader="encoders", skip_bad=True)
    assert len(found) == 11
    assert any(note.startswith("skipped 1 broken:") and "line 5" in note for note in found.notes)


def test_short_rows_gaps_and_time_that_runs_back(tmp_path):
    text = log(changed={(6, 0): 4_000_000, (9, 0): 9_000_000, (10, 0): 9_100_000})
    text = text.replace("\n", " 1 2\n", 1) + "1 2 3\n"
    path = write(tmp_path / "a.dat", text)
    with pytest.raises(UserError, match="line 13: the row ends after 3 numbers"):
        read_log(path)
    found = read_log(path, skip_bad=True)
    assert (~found.usable).sum() >= 2
    assert any("time runs backwards" in note for note in found.notes)
    assert any("the number of beams varies" in note for note in found.notes)
    assert read_log(write(tmp_path / "b.dat", log(num=2))).usable.all()
    with pytest.raises(UserError, match="the log holds 0 scans"):
        read_log(write(tmp_path / "c.dat", log(num=1)))


def test_arcs_and_commands_agree_with_geometry():
    circle = driven(np.tile([0.1 * math.pi, 0.0, 0.1 * math.pi], (20, 1)))
    np.testing.assert_allclose(circle[10], [0.0, 2.0, math.pi], atol=1e-12)
    np.testing.assert_allclose(circle[-1, :2], 0.0, atol=1e-12)
    time, velocity = np.array([0.0, 1.0]), np.array([[1.0, 0.0, 0.0], [0.0, 1.0, 0.0]])
    motion = commanded(time, velocity, np.array([0.5, 3.0]), timeout=None)
    assert motion.pose[-1].tolist() == [1.0, 2.0, 0.0]
    assert interpolated(motion, np.array([0.25]))[0].tolist() == [0.25, 0.0, 0.0]
    stopped = commanded(time, velocity, np.array([0.5, 3.0]), timeout=0.5)
    assert stopped.pose[-1].tolist() == [0.5, 0.5, 0.0]
    order, late, repeated = ordered(np.array([0.0, 2.0, 1.0, 1.0]))
    assert (order.tolist(), late, repeated) == ([0, 2, 1], 1, 1)
    assert interpolated(Motion(np.array([0.0, 1.0]), np.zeros((2, 3))), np.array([5.0])).max() == 0
