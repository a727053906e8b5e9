"""Runs side by side: what differs, what they were measured at, and when."""

import json
import os
import shutil
from pathlib import Path

import pytest

from motorspace._errors import UserError
from motorspace.export.compare import Measured, compare, compared
from motorspace.training.run import train
from tests.tiny import TINY

ERRORS = {"prediction.error": 0.5}


@pytest.fixture(scope="module")
def trained(tmp_path_factory):
    folder = tmp_path_factory.mktemp("runs") / "trained"
    train(TINY, folder=folder)
    return folder


@pytest.fixture
def runs(trained, tmp_path):
    """Two runs' folders that differ by the seed alone."""
    for seed, name in enumerate("ab"):
        shutil.copytree(trained, tmp_path / name)
        path = tmp_path / name / "config.json"
        described = json.loads(path.read_text())
        described["config"]["training"]["seed"] = seed
        path.write_text(json.dumps(described))
    return [tmp_path / "a", tmp_path / "b"]


def measure(run):
    return {"prediction": {"error": 1.5 + run.config.training.seed}}


def refuse(run):
    raise AssertionError("nothing is to be measured")


def evaluated(folder: Path, content: str, *, age: float = 0.0) -> None:
    """An evaluation written `age` seconds after the weights."""
    path = folder / "evaluation.json"
    path.write_text(content)
    time = (folder / "weights.safetensors").stat().st_mtime + age
    os.utime(path, (time, time))


def test_runs_are_measured_where_there_is_no_evaluation(runs):
    found = compare(runs, measure=measure)
    assert found.names == tuple(map(str, runs))
    assert found.measured == ("now", "now")
    assert found.config == {"training.seed": (0, 1)}
    assert found.measures == {"prediction.error": (1.5, 2.5)}


def test_an_evaluation_is_used_and_dated(runs):
    evaluated(runs[0], json.dumps(ERRORS))
    evaluated(runs[1], json.dumps({"prediction": {"error": 0.25}}), age=86400.0)
    os.utime(runs[0] / "evaluation.json", (1.9e9, 1.9e9))
    found = compare(runs, measure=refuse)
    assert found.measures == {"prediction.error": (0.5, 0.25)}
    assert found.measured[0] == "2030-03-17"


def test_an_evaluation_older_than_the_weights_is_measured_again(runs):
    evaluated(runs[0], json.dumps(ERRORS), age=-1.0)
    assert compare(runs, measure=measure).measures == {"prediction.error": (1.5, 2.5)}


@pytest.mark.parametrize("content", ["{", "3", "[1, 2]", ""])
def test_a_damaged_evaluation_is_named(runs, content):
    evaluated(runs[1], content)
    with pytest.raises(UserError, match=r"b/evaluation\.json: the evaluation cannot be read"):
        compare(runs, measure=measure)


def test_one_run_alone_is_not_compared(runs):
    with pytest.raises(UserError, match="compare needs at least two runs, got 1"):
        compare(runs[:1], measure=measure)


def test_a_folder_without_a_run_is_refused(runs, tmp_path):
    with pytest.raises(UserError, match="there is no run here"):
        compare([*runs, tmp_path], measure=measure)


def test_what_only_one_run_has_is_shown_as_missing():
    a = Measured("a", {"model": {"sizes": [1, 2]}}, {"error": 1.0}, "2030-03-17")
    b = Measured("b", {"model": {"sizes": [1, 3], "depth": 2}}, {"trust": float("nan")}, "now")
    found = compared([a, b])
    assert found.as_json() == {
        "runs": ["a", "b"],
        "measured": ["2030-03-17", "now"],
        "config": {"model.sizes": ["[1, 2]", "[1, 3]"], "model.depth": [None, 2]},
        "measures": {"error": [1.0, None], "trust": [None, None]},
    }
    assert json.loads(json.dumps(found.as_json(), allow_nan=False)) == found.as_json()
    assert str(found).splitlines() == [
        "               a           b",
        "configuration",
        "  model.sizes  [1, 2]      [1, 3]",
        "  model.depth  -           2",
        "measured       2030-03-17  now",
        "  error        1           -",
        "  trust        -           nan",
    ]


def test_equal_configurations_are_said_to_be_equal():
    a = Measured("a", {"depth": 1}, {"error": 1.0}, "now")
    assert "configurations are equal" in str(compared([a, a]))
