"""Rows: the runs of a cell together, their intervals, and targets."""

import math

import numpy as np
import pytest
from scipy.stats import bootstrap

from motorspace.running.store import Result
from motorspace.studies.rows import COMPONENTS, Row, Spread, chosen, rows_of, with_worst
from motorspace.studies.study import Study, Target
from motorspace.studies.tables import columns
from motorspace.studies.targets import Reason, claims, complaints, missed_lines, reached_lines


def result(seed, **metrics):
    named = {name.replace("__", "."): value for name, value in metrics.items()}
    cell = (("agent", "forward"), ("rotation", 0.4))
    return Result(cell, seed, 1000, "0" * 12, "abc", "2026-01-01", named)


@pytest.fixture
def row():
    (found,) = rows_of(
        "mine",
        [
            result(0, prediction__error=4.0, winding_number=-1.0, partial_motors=-0.02, x=1.0),
            result(1, prediction__error=5.0, winding_number=1.0, partial_motors=0.04, x=math.nan),
        ],
    )
    return found


def test_a_row_holds_what_every_run_was_measured_at(row):
    assert row["prediction.error"].values == (4.0, 5.0)
    assert row["prediction.error"].mean == 4.5 and row["prediction.error"].range == (4.0, 5.0)
    assert "x" not in row and row.get("nothing") is None
    assert row["winding_number"].values == (1.0, 1.0), "its sign is a convention"
    assert (row.name, row.epochs, len(row.runs)) == ("forward, r = 0.4 π", 1000, 2)


def test_the_interval_of_the_mean_is_that_of_scipy():
    values = (1.0, 2.0, 3.0, 4.5)
    theirs = bootstrap((values,), np.mean, method="percentile", rng=0).confidence_interval
    assert Spread(values).interval == (theirs.low, theirs.high)
    assert Spread((3.0,)).interval == (3.0, 3.0)


def test_the_worst_component_is_that_of_each_run():
    keys = [f"linear_r2.{component}" for component in COMPONENTS]
    of_runs = ((0.9, 0.8, 1.0, 1.0), (0.7, 0.8, 1.0, 1.0))
    runs = {seed: dict(zip(keys, r2, strict=True)) for seed, r2 in enumerate(of_runs)}
    row = Row("mine", {}, 1, runs)
    assert with_worst(row, "linear_r2", "probe_r2")["linear_r2.worst"].values == (0.8, 0.7)


def test_rows_are_chosen_by_their_settings(row):
    assert chosen([row], "mine", agent=("forward", "holonomic")) == [row]
    assert chosen([row], "other") == chosen([row], rotation=0.2) == []


def test_columns_are_settings_and_measures(row):
    (line,) = columns("agent", "rotation", "prediction.error", "seeds", heads={"agent": "who"})(
        [row]
    )
    assert [*line] == ["who", "r", "prediction error", "seeds"]
    assert (line["who"], line["r"], line["seeds"]) == ("forward", "0.4 π", 2)
    assert line["prediction error"]["mean"] == 4.5


def study(*targets):
    return Study("mine", "Which?", lambda budget, seeds: [], {}, targets=targets)


@pytest.mark.parametrize(
    ("target", "met"),
    [
        (Target("low", "prediction.error", at_most=5.0), True),
        (Target("low", "prediction.error", at_most=4.9), False),
        (Target("low", "prediction.error", at_most=4.5, every_seed=True), False),
        (Target("near", "partial_motors", at_most=0.04, magnitude=True), True),
        (Target("near", "partial_motors", at_most=0.03, magnitude=True), False),
        (Target("round", "winding_number", at_least=1.0), True),
    ],
)
def test_a_target_is_met_only_by_the_whole_interval(row, target, met):
    (claim,) = claims(study(target), [row])
    assert claim.met is met
    assert [line["reached in"] for line in reached_lines([claim])] == [int(met)]


def test_a_target_is_for_its_cells_and_measures(row):
    elsewhere = Target("low", "prediction.error", at_most=5.0, cells={"agent": "holonomic"})
    assert claims(study(elsewhere, Target("x", "x", at_most=1.0)), [row]) == []


def test_missed_targets_have_reasons_and_reasons_have_missed_targets(row):
    target = Target("low", "prediction.error", at_most=4.0)
    known = Reason("mine", "low", "prediction.error", "at most 4", "hard", {"rotation": [0.2, 0.4]})
    other = Reason("mine", "low", "prediction.error", "at most 4", "harder", {"rotation": 1.2})
    found = claims(study(target), [row], [other, known])
    assert [line["reason"] for line in missed_lines(found)] == ["hard"]
    assert complaints(found, [known]) == []
    assert "nothing is missed" in complaints(found, [known, other])[0]
    unexplained = claims(study(target), [row])
    assert "no reason why low is missed" in complaints(unexplained, [])[0]
