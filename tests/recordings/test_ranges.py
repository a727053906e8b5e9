"""What the readings of a laser mean."""

import numpy as np
import pytest

from motorspace import UserError
from motorspace.recordings.readers.base import read_log
from motorspace.recordings.readers.ranges import Beams, interpret, kept_beams
from tests.recordings.logs import raw_log, write


def meaning(values, limit=np.inf, max_range=10.0, invalid="max_range"):
    raw = np.array([values], float)
    limits = np.full(1, limit)
    return interpret(raw, limits, max_range=max_range, invalid=invalid, where="here")


@pytest.mark.parametrize("nothing", [0, np.inf, 10, 12, 81.91, 8191, 81.83])
@pytest.mark.parametrize("max_range", [10.0, 100.0, 10_000.0])
def test_no_return_is_the_maximum_range(nothing, max_range):
    if nothing in (10, 12) and max_range > 10:
        return
    reading = meaning([1.0, nothing, 2.0], max_range=max_range)
    assert reading.sensors.tolist() == [[1.0, max_range, 2.0]]
    assert not reading.invalid.any()
    assert "1 of 3 readings are no return" in reading.notes[0]


def test_a_distance_beyond_the_codes_is_a_distance_for_a_laser_that_sees_it():
    assert meaning([81.5, 81.95, 90.0], max_range=100.0).sensors.tolist() == [[81.5, 81.95, 90.0]]


@pytest.mark.parametrize("wrong", [-1, -np.inf, np.nan, -0.001])
def test_invalid_readings_follow_their_rule(wrong):
    reading = meaning([1.0, wrong, 2.0])
    assert reading.sensors.tolist() == [[1.0, 10.0, 2.0]]
    assert reading.invalid.tolist() == [True]
    assert "1 of 3 readings are invalid" in reading.notes[0]
    with pytest.raises(UserError, match="here: 1 readings are invalid, the first is"):
        meaning([1.0, wrong, 2.0], invalid="refuse")


def test_scans_with_invalid_readings_can_be_left_out(tmp_path):
    text = raw_log(num=8)
    path = write(tmp_path / "robot.log", text.replace("1 2 3 4 5 4", "1 2 3 -1 5 4", 1))
    assert read_log(path).usable.all()
    recording = read_log(path, invalid="leave_out")
    assert recording.usable.tolist() == [False, True, True, True, True, True, True]
    assert "1 with values missing" in recording.notes[-1]


def test_readings_that_say_nothing_make_one_ask_for_the_unit(tmp_path):
    path = write(
        tmp_path / "robot.log", raw_log().replace("1 2 3 4 5 4", "110 220 330 440 550 440")
    )
    path.write_text(path.read_text().replace(" 3 2 1 ", " 330 220 110 "))
    assert any("check max_range" in note for note in read_log(path).notes)


@pytest.mark.parametrize("num", [9, 181, 360])
def test_kept_beams_spread_evenly(num):
    beams = Beams(-np.pi / 2, np.pi, np.zeros(num))
    kept = kept_beams(beams, 5, np.pi)
    np.testing.assert_allclose(kept, np.linspace(0, num - 1, 5), atol=0.51)
    assert kept_beams(beams, 5, 100.0).tolist() == kept.tolist()
