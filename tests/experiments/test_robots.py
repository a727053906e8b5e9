"""The experiments on recorded robots, on a small synthetic log."""

from dataclasses import replace

import numpy as np
import pytest

from motorspace.experiments import robots
from motorspace.recordings.readers.base import read_log
from motorspace.training.config import SimulationConfig
from tests.recordings.logs import corrected_log

EXPERIMENT = robots.RobotExperiment(horizon_scans=3, shortest_scans=1, per_scan=True)


@pytest.fixture
def log(tmp_path):
    path = tmp_path / "robot.log"
    path.write_text(corrected_log(200))
    return path


def test_training_sees_shorter_transitions_and_the_test_does_not(log):
    data = robots.robot_data(read_log(log), EXPERIMENT)
    assert sorted(set(data.train.experience.num_steps.tolist())) == [1, 2, 3]
    assert set(data.test.experience.num_steps.tolist()) == {3}
    short = np.asarray(data.train.experience.num_steps) == 1
    assert (np.asarray(data.train.experience.motors)[short, 1:] == 0).all()
    told = data.told_displacements()
    assert told.test.experience.motors.shape == (len(data.test), 1, 4)


def test_every_row_is_trained_once_and_then_read(log, tmp_path, monkeypatch):
    short = replace(robots.TRAINING, epochs=2, trajectories_per_epoch=64, batch_size=32)
    monkeypatch.setattr(robots, "TRAINING", short)
    out = tmp_path / "out"
    results = robots.robot_results(log, EXPERIMENT, out, seeds=1)
    for name in robots.MODELS:
        row = results[name]
        assert 0 < row["low"] <= row["mean"] <= row["high"]
    assert results["untrained"] != results["model"]

    def fail(*_, **__):
        raise AssertionError("a finished run was trained again")

    monkeypatch.setattr(robots, "train", fail)
    assert robots.robot_results(log, EXPERIMENT, out, seeds=1) == results
    codes, displacements = robots.codes_on_test(log, EXPERIMENT, out)
    assert codes.shape == (len(displacements), 50)


def test_data_for_a_run_follows_its_horizons(log):
    data = robots.data_for(log, SimulationConfig(horizon=2, min_horizon=1))
    assert sorted(set(data.train.experience.num_steps.tolist())) == [1, 2]
