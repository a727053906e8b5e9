"""The first look: two networks and an oracle are trained and measured, and one page shows them."""

import math
import shlex
from collections.abc import Callable, Mapping, Sequence
from contextlib import closing
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from motorspace._errors import UserError
from motorspace._files import write_atomically
from motorspace.running.jobs import Job, cell
from motorspace.running.processes import Processes
from motorspace.running.work import Failure, forget_outcome
from motorspace.studies.cells import oracle
from motorspace.training import folder as run_folder
from motorspace.training.config import RunConfig
from motorspace.training.data import Derived, Simulated
from motorspace.training.presets import PresetName
from motorspace.training.settings import changed
from motorspace.worlds.catalog import AGENTS

if TYPE_CHECKING:
    from motorspace._types import Key, Pose
    from motorspace.reports.demo_page import Network
    from motorspace.worlds.scenario import Scenario

ROTATION = 0.4
"""The agent's largest rotation in one step, in units of pi."""
EPOCHS = 400
"""Of the paper's 5,000: a first look, not the result."""
NUM_TEST = 24_000
NUM_WALKS, WALK_STEPS = 8, 12
CODES = "codes.npz"

Report = Callable[[str], None]
Metrics = Mapping[str, float]


def demo(out: Path, *, seed: int = 0, report: Report = lambda line: None) -> Path:
    """Train, measure, and write a page.

    A demo that was stopped goes on where it was; finished runs are only measured again.

    Args:
        out: The folder of the page, `report.html`, and of the runs.
        seed: Seed of the runs.
        report: Receives a sentence now and then.

    Returns:
        The page.

    Raises:
        UserError: When the folder holds runs of another configuration, or training fails.
    """
    jobs = demo_jobs(seed)
    report(f"training {len(jobs)} networks, two at a time, for {EPOCHS} epochs each")
    measured = {}
    with closing(Processes(2).run(train_and_measure, jobs, out)) as outcomes:
        for job, found in outcomes:
            if isinstance(found, Failure):
                raise UserError(found.what.rstrip("."), where=out / job.study / job.folder)
            forget_outcome(job, out)
            measured[job.folder] = found.metrics
            report(f"{job.folder}: prediction error {found.metrics['prediction.error']:.3g}")
    page = out / "report.html"
    write_atomically(page, _page(jobs, out, measured).encode())
    return page


def demo_jobs(seed: int) -> list[Job]:
    """The runs of the demo: the presets `paper` and `best`, and the oracle."""
    paper, best = (_config(preset, seed) for preset in ("paper", "best"))
    configs = {"best": best, "paper": paper, "oracle": oracle(paper)}
    return [Job("runs", cell(network=name), config, place=name) for name, config in configs.items()]


def _config(preset: PresetName, seed: int) -> RunConfig:
    agent = AGENTS.part("forward", {"max_rotation": ROTATION * math.pi})
    return changed(RunConfig(Simulated(agent), preset=preset), {"epochs": EPOCHS, "seed": seed})


def train_and_measure(job: Job, folder: Path) -> Metrics:
    """Train a run of the demo, measure it, and keep its codes beside it."""
    import jax

    from motorspace.analysis.projections import pca
    from motorspace.evaluation.evaluate import evaluate
    from motorspace.evaluation.structure import equivalence, sampled, values
    from motorspace.evaluation.subject import subject_of
    from motorspace.training.run import train

    assert isinstance(job.config, RunConfig)
    run = train(job.config, folder=folder, resume=True)
    metrics = dict(evaluate(run, num=NUM_TEST))
    if isinstance(run.config.data, Derived):
        return metrics
    subject, seed = subject_of(run), run.config.training.seed
    found = sampled(subject, seed=seed, subsets=1)
    projected = pca(found.codes)
    np.savez(
        folder / CODES,
        coordinates=projected.coordinates,
        explained=projected.explained_variance_ratio,
        displacements=found.displacements,
    )
    return metrics | values(found.topology) | equivalence(subject, key=jax.random.key(seed))


def _page(jobs: Sequence[Job], out: Path, measured: Mapping[str, Metrics]) -> str:
    import jax

    from motorspace.reports.demo_page import demo_page
    from motorspace.training.data import simulated

    assert isinstance(jobs[0].config, RunConfig)
    scenario = simulated(jobs[0].config.data).scenario()
    walks = [_walk(scenario, key=key) for key in jax.random.split(jax.random.key(3), NUM_WALKS)]
    runs = out / jobs[0].study
    networks = {name: _network(runs / name, measured[name]) for name in ("paper", "best")}
    best = shlex.quote(str(runs / "best"))
    return demo_page(scenario, walks, networks, measured["oracle"], best=best)


def _walk(scenario: "Scenario", *, key: "Key") -> "Pose":
    import jax.numpy as jnp

    from motorspace._types import Pose
    from motorspace.recordings.record import record

    walked = record(scenario, num_steps=WALK_STEPS, key=key)
    return Pose(*jnp.asarray(walked.poses.T, jnp.float32))


def _network(folder: Path, metrics: Metrics) -> "Network":
    from motorspace.reports.demo_page import Network

    codes = np.load(folder / CODES)
    unit = run_folder.read_description(folder).sensor_scale[0] ** 2
    losses = [record["prediction_loss"] for record in run_folder.read_log(folder)]
    return Network(metrics, unit * np.array(losses), **codes)
