"""Many runs: each is done once, and none outlives the command that started it."""

import json
import multiprocessing
import os
import subprocess
import sys
import time
from dataclasses import replace

import pytest

from motorspace import UserError
from motorspace._files import locked
from motorspace.analysis.errors import CHUNK_SIZE
from motorspace.experiments import paper, reproduction
from tests.tiny import TINY


def test_the_table_has_twelve_cells_and_a_budget_is_a_share_of_the_epochs():
    jobs = paper.table_jobs("fifth", seeds=3, parts=("model", "oracle"))
    assert len(jobs) == 12 * 3 * 2
    assert len({job.folder for job in jobs}) == len(jobs)
    assert {job.config.training.epochs for job in jobs} == {1000}
    assert {job.config.training.seed for job in jobs[:24]} == {0}
    oracles = [job.config for job in jobs if job.part == "oracle"]
    assert {c.model.encoder for c in oracles} == {"identity"}


def test_every_open_point_changes_what_it_names_and_nothing_else():
    jobs = paper.point_jobs("quick", seeds=1)
    base = jobs[0].config
    assert len({job.config for job in jobs}) == len(paper.POINTS)
    for job in jobs:
        change = paper.POINTS[job.name.partition("/")[2]]
        for part in ("simulation", "model", "training"):
            undone = {field: getattr(getattr(base, part), field) for field in change.get(part, {})}
            assert replace(getattr(job.config, part), **undone) == getattr(base, part)


@pytest.mark.parametrize("part", ["model", "oracle"])
def test_a_finished_job_is_read_not_repeated(tmp_path, monkeypatch, part):
    config = TINY
    if part == "oracle":
        config = replace(config, model=replace(config.model, encoder="identity"))
    job = paper.Job("table/forward-0.8", config, part)
    first = paper.run_job(job, tmp_path, num_test=CHUNK_SIZE)
    assert first["errors"]["model"] > 0 and first["part"] == part
    assert list(paper.finished(tmp_path)) == [first]

    def fail(*_, **__):
        raise AssertionError("a finished run was trained again")

    monkeypatch.setattr(paper, "train", fail)
    assert paper.run_job(job, tmp_path, num_test=CHUNK_SIZE) == first


@pytest.mark.parametrize("written", ['{"name": "table/forward-0.8"}', "[1]", '{"name": "tab'])
def test_results_that_are_broken_or_of_another_version_are_named(tmp_path, written):
    path = tmp_path / "table" / "forward-0.8" / "model" / "seed0" / "results.json"
    path.parent.mkdir(parents=True)
    path.write_text(written)
    with pytest.raises(
        UserError, match=r"results\.json: the results lack .*recipe.*; delete this file"
    ):
        list(paper.finished(tmp_path))


def test_workers_end_with_the_command_that_started_them(tmp_path):
    arguments = ["train", "forward", "--layout", "empty", "--epochs", "1000000", "--seeds", "2"]
    command = [sys.executable, "-m", "motorspace", *arguments, "--out", str(tmp_path)]
    started = subprocess.Popen(command, stderr=subprocess.DEVNULL)
    try:
        wait_until(lambda: (tmp_path / "seed0" / "config.json").exists(), seconds=120)
    finally:
        started.kill()
        started.wait()
    wait_until(lambda: is_free(tmp_path / "seed0"), seconds=20)
    assert json.loads((tmp_path / "seed0" / "config.json").read_text())["format_version"] == 1


def is_free(folder):
    try:
        with locked(folder):
            return True
    except UserError:
        return False


def wait_until(condition, *, seconds):
    end = time.monotonic() + seconds
    while not condition():
        assert time.monotonic() < end, "it never came true"
        time.sleep(0.2)


@pytest.mark.skipif(not hasattr(os, "sched_setaffinity"), reason="cores cannot be chosen here")
def test_a_worker_stays_on_a_core_that_no_other_has_taken():
    before = os.sched_getaffinity(0)
    core, context = min(before), multiprocessing.get_context("spawn")
    taken, free = context.Lock(), context.Lock()
    taken.acquire()
    try:
        reproduction._take_a_core([(core + 1, taken), (core, free)])
        assert os.sched_getaffinity(0) == {core}
        assert not free.acquire(block=False)
        reproduction._take_a_core([(core + 1, taken)])
        assert os.sched_getaffinity(0) == {core}, "where every core is taken, nothing changes"
    finally:
        os.sched_setaffinity(0, before)
