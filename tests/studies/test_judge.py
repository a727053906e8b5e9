"""The study of judges: which runs it takes, and what its tables and its picture show of them."""

import pytest

from motorspace.judge.scores import measure_networks, training_seconds
from motorspace.studies.judge import STUDY, jobs, over_compute, related
from motorspace.studies.rows import Row
from motorspace.training.run import train
from motorspace.training.settings import changed

FIRST = {
    "judge.error": 1.5,
    "judge.error.2000": 5.0,
    "judge.error.15000": 1.5,
    "judge.floor": 0.75,
    "judge.motors": 1.2,
    "judge.network": 4.5,
    "judge.network_seconds": 100.0,
    "judge.calibration_seconds": 15.0,
    "judge.seconds.2000": 5.0,
    "judge.seconds.15000": 10.0,
    "judge.seen.guided": 0.6,
    "judge.seen.simulated": 0.5,
    "judge.seen.predictor": 0.1,
    "judge.seen.stay": 0.0,
}
CELL = {"agent": "forward", "rotation": 0.4}
LARGER = {"judge.network": 4.4, "judge.network_seconds": 900.0}


@pytest.fixture
def rows():
    larger = Row("judge", CELL | {"network": "larger"}, 1000, {0: LARGER})
    return related([Row("judge", CELL, 1000, {0: FIRST}), larger])


def test_every_system_is_judged_and_two_act_with_every_seed():
    found = jobs("fifth", 5)
    assert len(found) == 12 + 2 * 4 + 3
    acting = [job for job in found if job.measure == "acting"]
    assert {job.seed for job in acting} == set(range(5)) and len(acting) == 10
    assert len({job.key for job in found}) == len(found)


def test_other_predictors_are_the_same_with_one_change():
    places = {dict(job.cell).get("network"): job.config for job in jobs("fifth", 1)}
    assert places["larger"].model.width_size == 512
    assert places["oracle"].model.encoder == "identity"


def test_errors_stand_over_what_they_cost(rows):
    costs = {line["predictor"]: line["seconds of one core"] for line in over_compute(rows)}
    assert costs == {
        "network": 100.0,
        "judge, 2,000 steps": 120.0,
        "judge, 15,000 steps": 125.0,
        "network, larger": 900.0,
    }


def test_ratios_are_of_the_same_run(rows):
    assert rows[0]["judge.to_floor"].mean == pytest.approx(2.0)
    assert rows[0]["judge.seen_to_simulated"].mean == pytest.approx(1.2)
    assert "judge.to_floor" not in rows[1]


def test_tables_hold_the_cells_that_are_measured(rows):
    (line,) = STUDY.tables["judge_goals"].lines(rows)
    assert line["guided"]["mean"] == 0.6
    assert not STUDY.tables["judge_far"].lines(rows)


def test_the_picture_has_a_curve_for_each_predictor(rows):
    (axes,) = STUDY.figures["judge"](rows).axes
    assert axes.get_xscale() == "log"
    assert {"judge", "network", "network, larger"} <= {line.get_label() for line in axes.lines}


@pytest.mark.slow
def test_ensembles_are_tested_on_what_one_is_tested_on():
    config = changed(jobs("quick", 1)[1].config, {"epochs": 2, "trajectories_per_epoch": 200})
    run = train(config)
    one = measure_networks(run, num=20)
    two = measure_networks(run, num=20, members=2)
    assert one["judge.num"] == two["judge.num"] == 20
    assert one["judge.network"] != two["judge.network"]
    assert training_seconds(config) > 0
