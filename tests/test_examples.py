"""The examples run, and the classes in them are at home on the command line."""

import importlib
import json
import re
import sys
from pathlib import Path

import pytest

from motorspace._errors import UserError
from motorspace.cli.main import main
from motorspace.evaluation.prediction import CHUNK_SIZE
from motorspace.models.config import ENCODERS
from motorspace.recordings.catalog import READERS
from motorspace.training.run import load_run
from motorspace.worlds.catalog import AGENTS, SENSORS
from tests.tiny import flags

EXAMPLES = Path(__file__).parents[1] / "examples"


@pytest.fixture(autouse=True)
def folder_of_examples(monkeypatch):
    """The folder of the examples, with none of their classes known yet."""
    monkeypatch.chdir(EXAMPLES)
    monkeypatch.syspath_prepend(EXAMPLES)
    monkeypatch.delitem(sys.modules, "my_robot", raising=False)
    for registry in (AGENTS, SENSORS, ENCODERS, READERS):
        monkeypatch.setattr(registry, "_added", {})


SCRIPTS = [
    pytest.param(path, marks=pytest.mark.slow if path.stem == "own_classes" else (), id=path.stem)
    for path in sorted(EXAMPLES.glob("*.py"))
    if path.stem != "my_robot"
]


@pytest.mark.parametrize("path", SCRIPTS)
def test_an_example_runs(path, capsys):
    brief = re.sub(r"epochs=(\d)\d+", r"epochs=\1", path.read_text())
    exec(compile(brief, str(path), "exec"), {"__name__": "__main__"})
    assert capsys.readouterr().out


def test_classes_of_ones_own_train_evaluate_and_resume_by_import(tmp_path, capsys, monkeypatch):
    folder, own = tmp_path / "run", ["--import", "my_robot"]
    train = ["train", "two_wheels", *own, "--wheel-base", "0.4", "--sensor", "compass_and_sonar"]
    train += ["--num-sonars", "3", "--encoder", "odometer", *flags(), "--out", str(folder)]
    main(train)
    config = json.loads((folder / "config.json").read_text())["config"]
    assert config["data"]["agent"] == {"kind": "two_wheels", "wheel_base": 0.4}
    assert config["data"]["sensor"]["num_sonars"] == 3
    main(["evaluate", str(folder), *own, "--num", str(CHUNK_SIZE), "--json"])
    assert json.loads(capsys.readouterr().out.splitlines()[-1])["prediction.error"] > 0
    main([*train, "--resume"])
    for registry in (AGENTS, SENSORS, ENCODERS, READERS):
        monkeypatch.setattr(registry, "_added", {})
    with pytest.raises(
        UserError, match=r"no encoder named 'odometer'.*\(on the command line: --im"
    ):
        load_run(folder)
    assert importlib.util.find_spec("my_robot"), "it could be imported, and was not"
