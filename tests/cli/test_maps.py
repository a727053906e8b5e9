"""A path and a map by codes, from the command line."""

import json
from pathlib import Path

import numpy as np
import pytest

import motorspace
from motorspace.cli.main import main

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
