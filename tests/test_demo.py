"""The demo: what it trains, what its page says, and that it goes on where it was."""

import math
import re
import subprocess
import sys

import jax.numpy as jnp
import numpy as np
import pytest

from motorspace import demo
from motorspace._errors import UserError
from motorspace._types import Pose
from motorspace.reports.demo_page import STRUCTURE, Network, demo_page
from motorspace.running.jobs import Job, cell
from motorspace.running.work import Failure, work
from motorspace.training.config import RunConfig
from motorspace.training.data import Derived, Simulated
from motorspace.training.settings import changed
from motorspace.worlds.scenario import Scenario

ERRORS = [f"prediction.{name}" for name in ("error", "mean", "persistence", "num")]

TINY = {
    "hidden_size": 8,
    "width_size": 8,
    "depth": 1,
    "epochs": 2,
    "restarts": 1,
    "trajectories_per_epoch": 64,
    "batch_size": 32,
    "horizon": 2,
    "layout": "empty",
}


class Here:
    """An executor that does one job after another in this process."""

    def __init__(self, count):
        assert count == 2

    def run(self, execute, jobs, folder):
        for job in jobs:
            yield job, work(execute, job, folder)


def test_both_networks_and_the_oracle_learn_the_same_task():
    best, paper, oracle = (job.config for job in demo.demo_jobs(seed=3))
    assert (paper.model.encoder, best.model.encoder) == ("lstm", "matrix_product")
    assert isinstance(oracle.data, Derived) and oracle.data.base == paper.data == best.data
    assert dict(paper.data.agent.options)["max_rotation"] == pytest.approx(0.4 * math.pi)
    assert {c.training.epochs for c in (best, paper, oracle)} == {demo.EPOCHS}
    assert {c.training.seed for c in (best, paper, oracle)} == {3}


@pytest.mark.slow
def test_the_page_of_finished_runs(tmp_path, monkeypatch):
    config = changed(RunConfig(Simulated(), preset="best"), TINY)
    oracle = changed(
        RunConfig(Derived(config.data, "oracle"), config.model), TINY | {"encoder": "identity"}
    )
    configs = {"best": config, "paper": config, "oracle": oracle}
    jobs = [Job("runs", cell(network=n), c, place=n) for n, c in configs.items()]
    monkeypatch.setattr(demo, "demo_jobs", lambda seed: jobs)
    monkeypatch.setattr(demo, "Processes", Here)
    monkeypatch.setattr(demo, "NUM_TEST", 64)
    out, lines = tmp_path / "my demo", []
    page = demo.demo(out, report=lines.append)
    html = page.read_text()
    assert page == out / "report.html" and len(lines) == 4
    assert html.count('class="codes-view"') == 2 and "mean of the sensors" in html
    assert f"motorspace topology &#x27;{out}/runs/best&#x27;" in html, "a command to be pasted"
    written = re.sub("<script.*?</script>", "", html, flags=re.DOTALL)
    assert not re.search(r'(src|href)="(?!data:|#)', written) and "default-src 'none'" in html
    trained_again = lambda *_, **__: pytest.fail("a finished run was trained again")  # noqa: E731
    monkeypatch.setattr("motorspace.training.calls.train_epochs", trained_again)
    assert demo.demo(out) == page, "it is measured again"


def test_the_page_does_without_what_could_not_be_measured():
    """As where the extra `topology` is not installed."""
    rng = np.random.default_rng(0)
    metrics = dict.fromkeys(STRUCTURE[:-1], 0.5) | dict.fromkeys(ERRORS, 2.0)
    codes = {"coordinates": rng.normal(size=(50, 3)), "displacements": rng.normal(size=(50, 3))}
    network = Network(metrics, np.ones(4), explained=np.array([0.5, 0.2, 0.1]), **codes)
    walks = [Pose(*jnp.full((4, 3), place)) for place in (10.0, 20.0)]
    html = demo_page(
        Scenario("empty"), walks, {"paper": network, "best": network}, metrics, best="runs/best"
    )
    assert "equivalence ratio" in html and "intrinsic dimension" not in html
    assert "2 trajectories of 2 commands" in html and "<code>motorspace topology runs/best" in html


def test_a_run_that_fails_ends_the_demo_in_one_sentence(tmp_path, monkeypatch):
    class Failing(Here):
        def run(self, execute, jobs, folder):
            yield jobs[0], Failure("the loss is no longer finite after epoch 3.")

    monkeypatch.setattr(demo, "Processes", Failing)
    with pytest.raises(UserError, match=r"runs/best: the loss is no longer finite"):
        demo.demo(tmp_path)


@pytest.mark.slow
def test_the_demo_as_it_is(tmp_path):
    command = [sys.executable, "-m", "motorspace", "demo", "--out", str(tmp_path)]
    done = subprocess.run(command, capture_output=True, text=True, check=True)
    assert done.stdout.endswith(f"open {tmp_path}/report.html\n")
