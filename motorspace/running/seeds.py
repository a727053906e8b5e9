"""One network per seed, trained side by side."""

from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

from motorspace._errors import UserError
from motorspace.running.executors import Executor
from motorspace.running.jobs import Job
from motorspace.running.work import Failure, forget_outcome
from motorspace.training.config import RunConfig


def train_seeds(
    config: RunConfig,
    out: Path,
    *,
    seeds: int,
    executor: Executor,
    resume: bool,
    report: Callable[[str], None],
) -> None:
    """Train one network per seed, counted from the configuration's own, in `out/seedN`.

    Raises `UserError` for the first one that fails, once the others are done.
    """
    first = config.training.seed
    configs = [
        replace(config, training=replace(config.training, seed=seed))
        for seed in range(first, first + seeds)
    ]
    jobs = [Job(out.name, (), c, place=f"seed{c.training.seed}") for c in configs]
    if not resume:
        for job in jobs:
            _refuse_a_run(out / job.folder)
    failures = []
    for job, found in executor.run(_train, jobs, out.parent):
        if isinstance(found, Failure):
            failures.append(found)
            continue
        forget_outcome(job, out.parent)
        report(f"finished: {out / job.folder}, loss {found.metrics['prediction_loss']:.4g}")
    if failures:
        raise UserError(failures[0].what.rstrip("."))


def _refuse_a_run(folder: Path) -> None:
    if (folder / "config.json").exists():
        raise UserError(
            "the folder already holds a run",
            where=folder,
            remedy="continue it with --resume, or choose another folder",
        )


def _train(job: Job, folder: Path) -> dict[str, float]:
    """Train a job's run. It always resumes, since a killed process is begun again."""
    from motorspace.training.run import train

    assert isinstance(job.config, RunConfig)
    run = train(job.config, folder=folder, resume=True)
    return {"prediction_loss": float(run.log[-1]["prediction_loss"])}
