"""The results in the repository: none is stale, and the documentation shows what they say."""

import json
import subprocess
import sys
from dataclasses import replace
from pathlib import Path

import pytest

from motorspace._errors import UserError
from motorspace.running.store import read_configs, read_lines
from motorspace.studies.rehash import rehash
from motorspace.studies.study import studies
from motorspace.studies.tables import EMPTY, NONE_MISSED, Results

ROOT = Path(__file__).parents[2]
FOLDER = ROOT / "results"


def test_the_documentation_shows_what_the_results_say():
    command = [sys.executable, "-m", "docs.tables", "--check"]
    done = subprocess.run(command, cwd=ROOT, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr


def test_every_line_has_its_configuration():
    configs = read_configs(FOLDER)
    lines = [line for name in studies() for line in read_lines(FOLDER / f"{name}.jsonl")]
    assert len(lines) > 500
    assert {line.config for line in lines} == {*configs}
    assert {name for name in configs if configs[name]["training"]["epochs"] < 1} == set()


def test_a_line_of_another_configuration_is_named_and_never_shown(tmp_path):
    lines = (FOLDER / "closing.jsonl").read_text().splitlines()
    stale = json.loads(lines[0]) | {"config": "0123456789ab"}
    (tmp_path / "closing.jsonl").write_text("\n".join([json.dumps(stale), *lines[1:]]))
    results = Results(tmp_path)
    (name,) = results.stale()
    assert name == "closing: horizon=1 rotation=1 seed=0 (0123456789ab)"
    seeds = [len(row.runs) for row in results.rows(studies()["closing"])]
    assert sorted(seeds) == [4, 5, 5, 5]


def test_a_new_setting_gives_results_new_hashes_and_nothing_else(tmp_path):
    line, *_ = read_lines(FOLDER / "closing.jsonl")
    old = "f" * 12
    (tmp_path / "closing.jsonl").write_text(replace(line, config=old).as_line() + "\n")
    config = read_configs(FOLDER)[line.config]
    del config["model"]["depth"]
    (tmp_path / "configs.jsonl").write_text(json.dumps({old: config}) + "\n")
    assert rehash(tmp_path) == 1 and rehash(tmp_path) == 0
    assert (tmp_path / "closing.jsonl").read_text() == line.as_line() + "\n"
    assert read_configs(tmp_path) == {line.config: read_configs(FOLDER)[line.config]}


def test_the_numbers_that_were_carried_over():
    """Some of each kind, by hand from the files that were before."""
    found = Results(FOLDER)

    def values(study, name, key):
        (row,) = (row for row in found.rows(studies()[study]) if row.name == name)
        return row[key].values

    errors = values("table1", "forward, r = 0.2 π, paper", "prediction.error")
    assert errors == (3.65397, 3.64999, 3.63307)
    assert values("lattice", "with-inverse", "lattice.wrong") == (0, 2, 534, 0, 219)
    assert values("floor", "forward, r = 0.2 π", "floor.error") == (0.550099,)
    assert min(values("structure", "holonomic, r = 0.8 π, best", "linear_r2.worst")) > 0.998


def test_broken_reasons_are_named(tmp_path):
    (tmp_path / "targets.toml").write_text("[[missed]]\nstudy = 1\n")
    with pytest.raises(UserError, match=r"targets\.toml: the reasons cannot be read"):
        Results(tmp_path).reasons()


def test_a_study_without_a_missed_target_says_so(monkeypatch):
    few = {name: studies()[name] for name in ("navigation", "lattice")}
    monkeypatch.setattr("motorspace.studies.tables.studies", lambda: few)
    tables = Results(FOLDER).tables()
    assert tables["navigation_missed"] == NONE_MISSED
    assert tables["lattice_missed"].startswith("|")
    assert Results(FOLDER / "nothing").tables()["navigation_missed"] == EMPTY
