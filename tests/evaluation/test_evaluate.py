"""A run is measured on what it learned from, and never on anything else."""

from dataclasses import replace

import jax
import numpy as np
import pytest

import motorspace as ms
from motorspace._errors import UserError
from motorspace.evaluation.evaluate import evaluate
from motorspace.evaluation.prediction import CHUNK_SIZE
from motorspace.evaluation.sampling import test_trajectories as trajectories_of
from motorspace.evaluation.structure import evaluate_with_structure, run_topology
from motorspace.evaluation.subject import subject_of
from motorspace.models.config import ModelConfig
from motorspace.training import sources
from motorspace.training.config import RunConfig, TrainingConfig
from motorspace.training.data import Derived, Given, Logged, Simulated
from motorspace.training.run import initial_run, train
from motorspace.training.settings import changed
from motorspace.trajectories.sampling import sample
from motorspace.worlds.scenario import Scenario
from tests.tables import write_table
from tests.tiny import TINY

ERRORS = {"prediction.error", "prediction.persistence", "prediction.mean", "prediction.skill"}
PROBES = {f"probe_r2.{name}" for name in ("longitudinal", "lateral", "cos", "sin")}


@pytest.fixture(autouse=True)
def no_simulation_of_runs_that_had_none(request, monkeypatch):
    """Tests of runs on logs and own data fail if anything is simulated."""
    if "log" in request.fixturenames or "given" in request.fixturenames:
        refuse = lambda *_: pytest.fail("a simulation was set up")  # noqa: E731
        monkeypatch.setattr(Scenario, "of", refuse)


@pytest.fixture(scope="module")
def simulated():
    return initial_run(TINY)


def test_a_simulated_run_is_measured_on_fresh_trajectories(simulated):
    found = evaluate(simulated, num=CHUNK_SIZE)
    assert found.keys() == ERRORS | PROBES | {"prediction.num", "code_variance"}
    assert found["prediction.num"] == CHUNK_SIZE
    assert all(np.isfinite(value) for value in found.values())
    assert found["prediction.error"] > found["prediction.mean"] > 0
    skill = 1 - found["prediction.error"] / found["prediction.persistence"]
    assert found["prediction.skill"] == pytest.approx(skill)
    for key in found:
        assert ms.measure(key).label
    assert str(found).count("\n") == len(found) - 1


def test_the_same_run_is_measured_at_the_same_numbers(simulated):
    once, twice = (evaluate(simulated, num=CHUNK_SIZE) for _ in range(2))
    assert dict(once) == dict(twice)


def test_a_baseline_is_measured_on_what_its_network_is_given(simulated):
    derived = {
        change: replace(TINY, data=Derived(TINY.data, change))
        for change in ("oracle", "shuffled", "supervised")
    }
    derived["oracle"] = changed(derived["oracle"], {"encoder": "identity"})
    plain = evaluate(simulated, num=CHUNK_SIZE)
    found = {
        change: evaluate(initial_run(config), num=CHUNK_SIZE) for change, config in derived.items()
    }
    # What is sensed before and after is the same for the oracle; its codes are displacements.
    assert found["oracle"]["prediction.persistence"] == plain["prediction.persistence"]
    assert all(found["oracle"][probe] > 0.999 for probe in PROBES)
    assert found["shuffled"]["prediction.persistence"] > plain["prediction.persistence"]
    assert found["supervised"]["prediction.persistence"] < 4


def test_the_oracle_has_the_structure_of_displacements():
    config = replace(TINY, data=Derived(TINY.data, "scaled_rotations"))
    run = initial_run(changed(config, {"encoder": "identity"}))
    subject = subject_of(run)
    assert subject.longest == TINY.data.horizon
    motors = np.random.default_rng(0).uniform(-0.5, 0.5, (50, 2, 2)).astype(np.float32)
    codes = subject.encode(motors)
    turns = motors[:, :, 0].sum(axis=1)
    expected = np.stack([np.cos(turns), np.sin(turns)], axis=1)
    np.testing.assert_allclose(codes[:, 2:], expected, atol=1e-5)


@pytest.mark.parametrize("num", [0, -1])
def test_nothing_cannot_be_measured(simulated, num):
    with pytest.raises(UserError, match=f"num must be at least 1, got {num}"):
        evaluate(simulated, num=num)


def test_a_run_is_measured_on_its_own_data_only(simulated, tmp_path):
    table = write_table(tmp_path / "t.csv")
    for other in (replace(TINY.data, horizon=3), Logged(table), Given()):
        with pytest.raises(UserError, match="not the data that the run has learned from"):
            evaluate(simulated, data=other)
        with pytest.raises(UserError, match="not the data that the run has learned from"):
            run_topology(simulated, data=other)


NETWORK = ModelConfig(hidden_size=8, code_size=4, width_size=8, depth=1, initial_weights="scaled")
BRIEF = TrainingConfig(epochs=2, trajectories_per_epoch=64, batch_size=32)


@pytest.fixture(scope="module")
def table(tmp_path_factory):
    return write_table(tmp_path_factory.mktemp("log") / "robot.csv")


@pytest.fixture(scope="module")
def log(table):
    """A run on a log."""
    return train(RunConfig(Logged(table, horizon=3), NETWORK, BRIEF))


def test_a_run_on_a_log_is_measured_on_its_test_blocks(log):
    found = evaluate(log)
    assert found.keys() == ERRORS | PROBES | {"prediction.num", "code_variance"}
    assert 100 < found["prediction.num"] < 200
    assert found["prediction.error"] < 100 * found["prediction.mean"]
    assert dict(evaluate(log, num=7)) == dict(found)


def test_the_structure_of_a_run_on_a_log_is_that_of_its_test_blocks(log):
    found = run_topology(log)
    tested = trajectories_of(log.config.data, 10**6, key=jax.random.key(0))
    assert found.codes.shape == (len(tested), 4)
    assert -1 < found.topology["rank_correlation"] < 1
    measured = evaluate_with_structure(log)
    assert measured["rank_correlation"] == float(found.topology["rank_correlation"])
    with pytest.raises(UserError, match="codes of the encoder 'lstm' have no standard form"):
        run_topology(log, standard=True)


def test_codes_of_a_log_have_a_standard_form_where_they_are_matrices(table):
    network = replace(NETWORK, encoder="matrix_product", code_size=6)
    run = initial_run(RunConfig(Logged(table, horizon=3), network, BRIEF))
    plain, standard = (run_topology(run, standard=standard).codes for standard in (False, True))
    assert plain.shape == standard.shape == (len(plain), 6)
    assert np.abs(plain - standard).max() > 1e-3


def test_the_oracle_of_a_log_is_given_its_displacements(table):
    network = replace(NETWORK, encoder="identity")
    run = initial_run(RunConfig(Derived(Logged(table, horizon=3), "oracle"), network, BRIEF))
    found = evaluate(run)
    assert all(found[probe] > 0.99 for probe in PROBES)


def test_a_log_that_was_moved_is_found_where_one_says(log, table, tmp_path):
    here = evaluate(log)
    moved = tmp_path / "elsewhere.csv"
    moved.write_bytes(table.read_bytes())
    data = log.config.data.at(moved)
    assert dict(evaluate(log, data=data)) == dict(here)
    assert run_topology(log, data=data).topology == run_topology(log).topology


def test_a_log_that_is_gone_or_has_changed_is_not_measured(table, tmp_path):
    path = tmp_path / "robot.csv"
    path.write_bytes(table.read_bytes())
    data = Logged(path, horizon=3, num_blocks=19)
    run = initial_run(RunConfig(data, NETWORK, BRIEF))
    sources._logged_data.cache_clear()
    for spoil, message in (
        (lambda: write_table(path, rows=300), "its content differs"),
        (path.unlink, "cannot be read"),
    ):
        spoil()
        for measure in (evaluate, run_topology):
            with pytest.raises(UserError, match=message):
                measure(run)


def test_displacements_of_a_log_without_poses_are_not_known(tmp_path):
    table = write_table(tmp_path / "blind.csv", poses=False)
    run = initial_run(RunConfig(Logged(table, horizon=3), NETWORK, BRIEF))
    assert evaluate(run).keys() == ERRORS | {"prediction.num", "code_variance"}
    with pytest.raises(UserError, match=r"blind\.csv: the log holds no true poses"):
        run_topology(run)


@pytest.fixture(scope="module")
def own():
    return sample("empty", num=256, horizon=2, key=jax.random.key(1))


@pytest.fixture(scope="module")
def given(own):
    """A run on data of one's own."""
    return train(RunConfig(Given("my robot"), NETWORK, BRIEF), own.experience)


def test_a_run_on_data_of_ones_own_needs_some_to_be_measured_on(given, own):
    for measure in (evaluate, run_topology):
        with pytest.raises(UserError, match=r"my robot|only you have; pass trajectories"):
            measure(given)
    found = evaluate(given, test=own)
    assert found["prediction.num"] == 256
    assert found.keys() > PROBES


def test_a_run_on_data_of_ones_own_is_never_said_to_be_a_simulation(own):
    run = train(RunConfig(Simulated(), NETWORK, BRIEF), own.experience)
    assert run.config.data == Given()
