"""Run studies: train and measure what is not finished yet, wherever jobs run."""

from collections.abc import Sequence
from dataclasses import replace
from functools import partial
from pathlib import Path

from motorspace._errors import UserError
from motorspace.running.executors import Executor, Report, run_jobs
from motorspace.running.jobs import Job
from motorspace.studies.cells import TEST_TRAJECTORIES
from motorspace.studies.rows import Numbers
from motorspace.studies.study import Budget, studies, study_named
from motorspace.training.config import RunConfig
from motorspace.training.data import Derived, Logged, base_of

ALL = "all"


def reproduce(
    names: Sequence[str],
    out: Path,
    *,
    budget: Budget,
    seeds: int,
    executor: Executor,
    logs: Path | None = None,
    report: Report = lambda sentence: None,
) -> None:
    """Train and measure every run of some studies that the results do not hold yet.

    Args:
        names: The studies; `"all"` stands for every one, without those on logs unless `logs` is
            given.
        out: The results are STUDY.jsonl in it, the runs are in STUDY/CELL.
        budget: The share of the paper's epochs.
        seeds: Seeds of every cell, from 0.
        executor: Where the jobs run.
        logs: The folder of the robots' logs.
        report: Receives a sentence for every run.

    Raises:
        UserError: For a study that does not exist, logs that are not there, and runs that have
            failed, after the others are done.
    """
    if seeds < 1:
        raise UserError(f"seeds must be at least 1, got {seeds}")
    wanted = [*studies()] if ALL in names else names
    jobs = [job for name in wanted for job in study_named(name).jobs(budget, seeds)]
    if ALL in names and logs is None:
        jobs = [job for job in jobs if not isinstance(base_of(_config(job).data), Logged)]
    jobs = [replace(job, config=with_log(_config(job), logs)) for job in jobs]
    measure = partial(execute, num=TEST_TRAJECTORIES[budget])
    run_jobs(jobs, out, measure, executor=executor, report=report)


def execute(job: Job, folder: Path, num: int) -> Numbers:
    """Train a job's run in a folder, from its checkpoint if there is one, and measure it.

    Args:
        job: One run of a registered study.
        folder: The run's own.
        num: Trajectories to test it on.

    Returns:
        {key of a measure: value}.
    """
    from motorspace.training.run import initial_run, train

    measure = study_named(job.study).measures[job.measure]
    config = _config(job)
    run = train(config, folder=folder, resume=True) if job.trains else initial_run(config)
    return measure(run, num)


def _config(job: Job) -> RunConfig:
    assert isinstance(job.config, RunConfig)
    return job.config


def with_log(config: RunConfig, logs: Path | None) -> RunConfig:
    """The configuration with its log in the folder `logs`, if it learns from one."""
    source = base_of(config.data)
    if not isinstance(source, Logged):
        return config
    if logs is None:
        raise UserError(
            "the robots' logs are no part of motorspace",
            remedy="give the folder that holds them with --logs",
        )
    moved = source.at(logs / source.path)
    data = replace(config.data, base=moved) if isinstance(config.data, Derived) else moved
    return replace(config, data=data)
