"""Our own studies: what they change, what they measure, what they show."""

import math
from dataclasses import fields, replace
from pathlib import Path

import equinox as eqx
import pytest

from motorspace.models.encoders.baselines import ConstantEncoder
from motorspace.running.store import Result, read_lines
from motorspace.running.sweep import jobs_of
from motorspace.running.sweep_spec import read_sweep
from motorspace.running.trainer import trainer
from motorspace.studies import (
    ablation,
    angle_scale,
    lattice,
    mixed_lengths,
    open_points,
    robots,
    structure,
    structure_figures,
    table1,
)
from motorspace.studies.cells import system
from motorspace.studies.figures import write_figures
from motorspace.studies.reproduce import execute
from motorspace.studies.rows import Row, known_measure, rows_of
from motorspace.studies.study import studies
from motorspace.training.config import RunConfig
from motorspace.training.data import Derived, Logged
from motorspace.training.run import initial_run, train
from motorspace.training.settings import changed
from tests.recordings.logs import corrected_log
from tests.tiny import TINY

RESULTS = Path(__file__).parents[2] / "results"


def row(study, runs=({},), **cell):
    return Row(study, cell, 1000, dict(enumerate(runs)))


def test_the_table_has_twelve_cells_beside_their_baselines():
    jobs = table1.jobs("fifth", 3)
    assert len(jobs) == 12 * 3 * 3
    assert {job.config.training.epochs for job in jobs} == {1000}
    assert {job.seed for job in jobs[:36]} == {0}
    oracles = [job.config for job in jobs if dict(job.cell)["variant"] == "oracle"]
    assert {config.model.encoder for config in oracles} == {"identity"}
    assert all(isinstance(config.data, Derived) for config in oracles)
    config = system("forward", 0.2, "paper", 0)
    assert dict(config.data.agent.options)["max_rotation"] == 0.2 * math.pi
    assert config == RunConfig(replace(config.data))


def test_every_open_point_changes_what_it_names_and_nothing_else():
    base, *others = (job.config for job in open_points.jobs("quick", 1))
    assert len({base, *others}) == len(open_points.CHANGES)
    for config, change in zip(others, [*open_points.CHANGES.values()][1:], strict=True):
        found = {**differing(base.model, config.model), **differing(base.training, config.training)}
        for part in ("agent", "sensor"):
            options = dict(getattr(base.data, part).options)
            theirs = dict(getattr(config.data, part).options)
            found |= {name: value for name, value in theirs.items() if options[name] != value}
        for name in ("layout", "collision"):
            if getattr(base.data, name) != getattr(config.data, name):
                found[name] = getattr(config.data, name)
        assert found == dict(change.settings)


def differing(one, other):
    pairs = {f.name: (getattr(one, f.name), getattr(other, f.name)) for f in fields(one)}
    return {name: new for name, (old, new) in pairs.items() if old != new}


def test_a_cell_stands_beside_its_baselines():
    errors = [{"prediction.error": e, "prediction.mean": 10.0} for e in (4.0, 5.0)]
    place = {"agent": "forward", "rotation": 0.4}
    found = [
        row("table1", errors, variant="paper", **place),
        row("table1", [{"prediction.error": 3.0}], variant="oracle", **place),
        row("floor", [{"floor.error": 0.8}], **place),
    ]
    (cell,) = table1.rows(found)
    assert cell["table1.to_oracle"].values == (4 / 3, 5 / 3)
    assert cell["table1.to_mean"].values == (0.4, 0.5)
    assert cell["table1.published"].values == (2.41,) and cell["floor.error"].mean == 0.8
    assert "table1.untrained" not in cell


def test_wrong_cases_are_counted_over_all_lengths():
    runs = [
        {
            "lattice.valid.1": 10,
            "lattice.correct.1": 9,
            "lattice.valid.2": 5,
            "lattice.correct.2": 3,
        }
    ]
    (found,) = lattice.rows([row("lattice", runs, variant="with-inverse")])
    assert found["lattice.wrong"].values == (3.0,)


def test_changes_stand_between_the_presets():
    place = {"agent": "holonomic", "rotation": 0.8}
    found = [row("structure", variant=name, **place) for name in ("best", "paper", "shuffled")]
    found.append(row("ablation", change="gru"))
    assert [ablation._name(line) for line in ablation.rows(found)] == ["paper", "GRU", "best"]


def test_lengths_trained_at_stand_side_by_side():
    found = [row("structure", agent="forward", rotation=r, variant="best") for r in (0.2, 0.6)]
    found.append(row("mixed_lengths", rotation=0.2))
    rows = mixed_lengths.rows(found)
    assert [
        line["trained at"] for line in mixed_lengths.STUDY.tables["mixed_lengths"].lines(rows)
    ] == ["T = 6", "T = 1 to 12"]


def test_errors_of_scaled_angles_are_compared_within_a_seed():
    runs = {
        angle: [{"prediction.error": f * (1 + s)} for s in range(2)]
        for angle, f in ((0.9, 1.5), (1.0, 1.0))
    }
    found = [row("angle_scale", of, rotation=0.2, angle=angle) for angle, of in runs.items()]
    wrong, right = angle_scale.rows(found)
    assert wrong["angle_scale.ratio"].values == (1.5, 1.5)
    assert right["angle_scale.ratio"].values == (1.0, 1.0)


def test_a_run_of_many_lengths_is_measured_at_one(monkeypatch):
    (job, *_) = mixed_lengths.jobs("quick", 1)
    assert (job.config.data.min_horizon, job.config.data.horizon) == (1, 12)
    measured = []
    monkeypatch.setattr(structure, "measured", lambda run, num: measured.append(run.config) or {})
    mixed_lengths.STUDY.measures[job.measure](initial_run(job.config), 10)
    assert measured == [system("forward", 0.2, "quick", 0, "best")]


@pytest.fixture(scope="module")
def tiny():
    return initial_run(TINY)


def test_codes_that_have_collapsed_are_said_to_have(tiny):
    model = eqx.tree_at(lambda m: m.encoder, tiny.model, ConstantEncoder(4))
    assert structure.measured_codes(replace(tiny, model=model), 0) == {"collapsed": 1.0}
    cell = (("agent", "forward"), ("rotation", 0.8), ("variant", "best"))
    results = [
        Result(
            cell, seed, 10, "0" * 12, "", "", {"prediction.error": 9.0, "collapsed": value} | more
        )
        for seed, value, more in ((0, 1.0, {}), (1, 0.0, {"linear_r2.worst": 1.0}))
    ]
    (found,) = structure.rows(rows_of("structure", results))
    assert "linear_r2.worst" not in found and found["collapsed"].mean == 0.5


def test_the_share_of_turns_is_that_of_random_commands():
    import numpy as np

    sampled = np.random.default_rng(0).uniform(-0.8, 0.8, (100_000, 6))
    turns = np.abs(np.round(sampled.sum(axis=1) / 2))
    for count in (1, 2):
        share = structure_figures.share_of_turns(0.8, count)
        assert share == pytest.approx(np.mean(turns == count), abs=0.005)


def test_robots_learn_without_their_motors_from_one_length():
    by_variant = {dict(job.cell)["variant"]: job.config for job in robots.jobs("paper", 1)[:4]}
    assert by_variant["paper"].data.min_horizon == 1
    assert by_variant["no-motors"].data.min_horizon == by_variant["no-motors"].data.horizon == 6
    assert by_variant["oracle"].data.change == "oracle"
    assert not by_variant["untrained"].training.train_encoder


ELSEWHERE = ("robots", "logs", "odometry")
"""Studies that need a log, or a network that has learned."""
MEASURES = [(s.name, m) for s in studies().values() for m in s.measures if s.name not in ELSEWHERE]


@pytest.mark.slow
@pytest.mark.parametrize(("name", "measure"), MEASURES)
def test_every_study_measures_a_short_run(tmp_path, name, measure):
    job = next(j for j in studies()[name].jobs("quick", 1) if j.measure == measure)
    short = {"epochs": 2, "trajectories_per_epoch": 200, "hidden_size": 8, "width_size": 8}
    metrics = execute(replace(job, config=changed(job.config, short)), tmp_path, num=8000)
    assert metrics and all(known_measure(key) for key in metrics)
    if measure != "course":
        assert {*shown_keys(name)} & {*metrics}


def shown_keys(name):
    """The measures that the results of a study have."""
    return read_lines(RESULTS / f"{name}.jsonl")[0].metrics


@pytest.mark.slow
def test_a_robot_of_a_small_log_is_measured(tmp_path):
    log = tmp_path / "robot.log"
    log.write_text(corrected_log(200, claimed=1.0))
    (job, *_) = robots.jobs("quick", 1)
    config = changed(job.config, {"epochs": 2, "horizon": 2, "min_horizon": 1})
    config = replace(config, data=Logged(log, "carmen", horizon=2, min_horizon=1))
    metrics = execute(replace(job, config=config), tmp_path / "run", num=100)
    assert metrics.keys() | {"prediction.skill"} == shown_keys("robots").keys() | {"code_variance"}
    assert "prediction.skill" not in metrics, "the sensors of this log never change"


def test_the_papers_table_is_a_sweep_of_a_few_lines():
    sweep = read_sweep(Path(__file__).parents[2] / "examples" / "sweeps" / "table1.toml")
    jobs = [j for j in table1.jobs("paper", 3) if dict(j.cell)["variant"] == "paper"]
    assert {job.config.hash() for job in jobs_of(sweep, trainer())} == {
        j.config.hash() for j in jobs
    }


@pytest.mark.slow
def test_the_papers_figures_are_drawn_of_the_runs_that_are_finished(tmp_path):
    job = next(j for j in table1.jobs("quick", 1) if dict(j.cell)["rotation"] == 0.8)
    train(TINY, folder=tmp_path / "table1" / job.folder)
    written = write_figures(tmp_path, "quick")
    names = ["ica-forward.png", "codes-forward.png", "codes-forward-uniform.png"]
    assert [path.name for path in written] == names
    assert all(path.read_bytes().startswith(b"\x89PNG") for path in written)
