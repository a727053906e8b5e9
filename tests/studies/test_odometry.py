"""The studies of odometry and of robots' logs, on short walks and a small log."""

from dataclasses import replace

import numpy as np
import pytest

import motorspace as ms
from motorspace.mapping import trials
from motorspace.studies import logs, odometry
from motorspace.studies.rows import Row, known_measure
from motorspace.training.data import Logged
from motorspace.training.settings import changed
from tests.mapping.rooms import mounting, ranges, walk
from tests.recordings.logs import flaser, odom


@pytest.mark.slow
def test_walks_are_measured_with_and_without_loops(monkeypatch):
    monkeypatch.setattr(odometry, "NUM_WALKS", 1)
    monkeypatch.setattr(odometry, "MAPPED", ("rooms",))
    monkeypatch.setattr(trials, "NUM_STEPS", 200)
    run = ms.load_pretrained("forward-0.4pi").run
    found = dict(odometry.measured(run, 0)) | dict(odometry.measured_open(run, 0))
    assert all(known_measure(key) for key in found)
    assert found["odometry.ate.corrected"] < found["odometry.ate.still"]
    assert found["mapping.ate.rooms"] < found["mapping.raw.rooms"]
    assert 0 <= found["mapping.within_68.open"] <= found["mapping.within_95.open"] <= 1


@pytest.fixture
def log(tmp_path):
    """A corrected CARMEN log of a walk through a room: odometry restarts at every scan."""
    poses = walk(400)
    lines = []
    for index, (place, readings) in enumerate(
        zip(poses.T, ranges(poses, mounting(121).angles), strict=True)
    ):
        lines.append(odom(*place, time=index))
        shown = " ".join(f"{reading:.4f}" for reading in readings)
        lines.append(flaser(*place, time=index + 0.1, ranges=shown))
    path = tmp_path / "room.log"
    path.write_text("\n".join(lines) + "\n")
    return path


@pytest.mark.slow
@pytest.mark.parametrize("variant", ["codes", "references", "pretrained", "frozen"])
def test_a_small_log_is_measured(variant, log, monkeypatch):
    monkeypatch.setattr(logs, "PRETRAINING", "quick")
    job = next(j for j in logs.jobs("paper", 1) if j.measure == variant)
    data = Logged(log, "carmen", horizon=3, min_horizon=1, num_rays=30, odometry="raw")
    run = ms.train(changed(replace(job.config, data=data), {"epochs": 20}))
    found = logs.STUDY.measures[variant](run, 100)
    assert all(known_measure(key) for key in found)
    assert all(np.isfinite(value) for value in found.values())


def test_a_row_of_codes_has_the_references_beside_it():
    def row(variant, **measures):
        found = {f"logs.ate.{way}": value for way, value in measures.items()}
        return Row("logs", {"recording": "hall", "variant": variant}, 150, {0: found})

    codes, frozen = logs.rows(
        [row("codes", loops=1.0), row("references", still=10.0, matcher_loops=0.5), row("frozen")]
    )
    assert codes["logs.ate.still"].mean == 10.0
    assert codes["logs.to_still"].mean == pytest.approx(0.1)
    assert codes["logs.to_matcher"].mean == pytest.approx(2.0)
    assert frozen.cell["variant"] == "frozen"
