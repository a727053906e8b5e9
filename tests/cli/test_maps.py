"""A path and a map by codes, from the command line."""

import json
from pathlib import Path

import numpy as np
import pytest

import motorspace
from motorspace.cli.main import main
from motorspace.worlds.layouts import load_layout
from tests.mapping.robots import robot

RUN = str(Path(motorspace.__file__).parent / "pretrained" / "forward-0.4pi")
ERRORS = ["--motor-noise", "0.05", "--motor-bias", "0.02"]
WALK = ["--layout", "rooms:2003", "--steps", "300", *ERRORS]


@pytest.mark.slow
def test_a_page_shows_a_path_that_loops_made_right(tmp_path, capsys):
    main(["map", RUN, *WALK, "--out", str(tmp_path / "a map"), "--json"])
    scores = json.loads(capsys.readouterr().out)
    assert scores["with loops"]["path.ate"] < 0.5 < scores["chained codes"]["path.ate"]
    html = (tmp_path / "a map" / "map.html").read_text()
    assert "<svg" in html or "data:image" in html
    path = np.genfromtxt(tmp_path / "a map" / "path.csv", delimiter=",", names=True)
    assert len(path) == 301 and np.isfinite(path["x"]).all()
    low_x, low_y, high_x, high_y = load_layout(tmp_path / "a map" / "map.yaml").bounds
    assert low_x < path["x"].min() < path["x"].max() < high_x
    assert low_y < path["y"].min() < path["y"].max() < high_y


@pytest.mark.slow
def test_odometry_is_corrected_and_says_how_certain_it_is(tmp_path, capsys):
    main(["odometry", RUN, *WALK, "--out", str(tmp_path / "path.csv"), "--json"])
    scores = json.loads(capsys.readouterr().out)
    assert scores["corrected"]["path.ate"] < scores["chained codes"]["path.ate"]
    path = np.genfromtxt(tmp_path / "path.csv", delimiter=",", names=True)
    assert len(path) == 301 and (path["sd_x"][1:] > 0).all()


@pytest.mark.parametrize("command", ["map", "odometry"])
@pytest.mark.parametrize(
    ("words", "sentence"),
    [
        (["--layout", "no such place"], "no such place"),
        (["no-log.txt"], "no-log.txt"),
        (["--num-beams", "3", "--steps", "50"], "rays"),
    ],
)
def test_what_no_map_can_be_made_of_is_refused_in_a_sentence(
    command, words, sentence, tmp_path, capsys
):
    with pytest.raises(SystemExit) as left:
        main([command, RUN, *words, "--out", str(tmp_path / "out")])
    said = capsys.readouterr().err
    assert left.value.code == 2 and sentence in said and "Traceback" not in said
    assert not list(tmp_path.iterdir())


@pytest.fixture
def nowhere(tmp_path):
    """A world whose walls are out of reach."""
    path = tmp_path / "open.layout"
    path.write_text("title   Open\nbounds  -1000 -1000 1000 1000\n")
    return ["--layout", str(path), "--steps", "20"]


def test_odometry_needs_no_walls_once_it_is_calibrated(nowhere, tmp_path, capsys):
    robot().save(tmp_path / "robot.json")
    again, csv = tmp_path / "again.json", tmp_path / "path.csv"
    files = ["--out", str(csv), "--save-calibration", str(again)]
    main(["odometry", RUN, *nowhere, "--calibration", str(tmp_path / "robot.json"), *files])
    assert "corrected.path.ate" in capsys.readouterr().out
    path = np.genfromtxt(csv, delimiter=",", names=True)
    assert len(path) == 21 and (path["sd_theta"][1:] > 0).all()
    assert again.read_text() == (tmp_path / "robot.json").read_text()


def test_a_log_is_followed_with_what_is_known_of_the_robot(tmp_path, capsys):
    robot().save(tmp_path / "robot.json")
    names = ["time", "motor_turn", "motor_ahead", *(f"sensor_{ray}" for ray in range(61))]
    rows = [",".join(map(str, [step / 2, 0.1, 0.2, *[10.0] * 61])) for step in range(12)]
    (tmp_path / "log.csv").write_text("\n".join([",".join(names), *rows]))
    known = ["--calibration", str(tmp_path / "robot.json")]
    main(["odometry", RUN, *known, str(tmp_path / "log.csv"), "--max-range", "10", "--json"])
    assert json.loads(capsys.readouterr().out)["scans"] == 12


def test_a_map_of_nothing_is_a_path(nowhere, tmp_path, capsys):
    robot().save(tmp_path / "robot.json")
    files = ["--calibration", str(tmp_path / "robot.json"), "--out", str(tmp_path / "map")]
    main(["map", RUN, *nowhere, *files, "--json"])
    assert json.loads(capsys.readouterr().out)["with loops"]["loops.num"] == 0
    written = {path.name for path in (tmp_path / "map").iterdir()}
    assert {"map.html", "map.yaml", "map.pgm", "path.csv", "calibration.json"} <= written


@pytest.mark.parametrize("command", ["map", "odometry"])
def test_where_nothing_is_seen_a_calibration_is_asked_for(command, nowhere, capsys):
    with pytest.raises(SystemExit) as left:
        main([command, RUN, *nowhere])
    said = capsys.readouterr().err
    assert left.value.code == 2 and "--calibration FILE" in said


@pytest.mark.parametrize("command", ["map", "odometry"])
@pytest.mark.parametrize(
    ("content", "sentence"),
    [
        (None, "there is no such file"),
        ("{}", "this is no calibration"),
        ('{"format_version": 7}', "of format version 7"),
    ],
)
def test_a_broken_calibration_is_refused(command, content, sentence, tmp_path, capsys):
    path = tmp_path / "robot.json"
    if content is not None:
        path.write_text(content)
    with pytest.raises(SystemExit) as left:
        main([command, RUN, "--calibration", str(path)])
    said = capsys.readouterr().err
    assert left.value.code == 2 and "robot.json" in said and sentence in said
