"""Results become rows, rows become claims that hold or not; the docs show these alone."""

import subprocess
import sys
from pathlib import Path

import pytest

from motorspace.experiments import summary

ROOT = Path(__file__).parents[2]


def run(seed, error, *, part="model", name="table/forward-0.4"):
    errors = {"model": error, "persistence": 20.0, "mean": 10.0, "skill": 1 - error / 20}
    return {
        "name": name,
        "part": part,
        "date": f"2026-01-0{1 + seed}",
        "seed": seed,
        "epochs": 7,
        "recipe": "wide, 0.006",
        "errors": errors | {"num_trajectories": 100},
        "probe_r2": {"longitudinal": 0.9 + seed / 100},
    }


@pytest.fixture
def rows():
    runs = [run(0, 4.0), run(1, 5.0), run(0, 4.5, part="oracle"), run(0, 1.0, name="points/x")]
    return summary.table_rows(runs)


def test_a_cell_is_the_mean_and_range_of_its_seeds(rows):
    (row,) = rows
    assert (row["agent"], row["rotation"], row["paper"]) == ("forward", 0.4, 2.41)
    assert row["model"] == {"mean": 4.5, "low": 4.0, "high": 5.0, "seeds": 2}
    assert row["to_oracle"]["mean"] == pytest.approx(1.0)
    assert row["untrained"] is None
    assert row["probe_r2"]["longitudinal"]["high"] == pytest.approx(0.91)


def test_an_experiment_tells_the_command_and_day_of_its_newest_run():
    runs = [run(0, 4.0), run(1, 5.0), run(0, 1.0, name="points/every default")]
    shown = summary.gathered(runs, "half")
    assert shown["table"]["command"] == "motorspace reproduce table --budget half --seeds 2"
    assert shown["table"]["date"] == "2026-01-02"
    assert [row["point"] for row in shown["points"]["rows"]] == ["every default"]
    assert shown.keys() == {"table", "points"}


def test_a_claim_holds_only_when_its_whole_interval_does(rows):
    file = {"command": "c", "date": "d", "rows": rows}
    to_oracle, plateau = summary.claims({"table": file}, {})
    assert to_oracle["interval"] == pytest.approx([4 / 4.5, 5 / 4.5])
    assert not to_oracle["holds"] and to_oracle["reason"] == "not known"
    assert plateau["measured"] == 0.5 and plateau["holds"] and "reason" not in plateau


@pytest.mark.parametrize(
    "known",
    [
        "error over its oracle's",
        "forward, r = 0.4 pi",
        "forward, r = 0.4 pi: error over its oracle's",
    ],
)
def test_a_reason_is_given_for_one_cell_or_for_all(rows, known):
    file = {"command": "c", "date": "d", "rows": rows}
    to_oracle, _ = summary.claims({"table": file}, {known: "too few epochs", "other": "no"})
    assert to_oracle["reason"] == "too few epochs"


def test_the_documents_show_what_the_results_say():
    done = subprocess.run(
        [sys.executable, "-m", "docs.tables", "--check"],
        cwd=ROOT,
        capture_output=True,
        text=True,
        check=False,
    )
    assert done.returncode == 0, done.stderr
