"""Where jobs run: in processes of this machine, or as one program for many runs.

A third executor, for a Ray cluster, is in `motorspace.running.ray_cluster`.
"""

from collections.abc import Callable, Generator, Sequence
from contextlib import ExitStack, closing, suppress
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import Any, Protocol, runtime_checkable

from motorspace._errors import UserError
from motorspace._files import locked
from motorspace.running.jobs import Cell, Job
from motorspace.running.store import Result, append_result, read_lines
from motorspace.running.work import (
    Execute,
    Failure,
    attempt,
    forget_outcome,
    held,
    import_modules,
    outcome,
)

Report = Callable[[str], None]
Outcome = tuple[Job, Result | Failure]


@runtime_checkable
class Executor(Protocol):
    """A place where jobs run."""

    def run(
        self, execute: Execute, jobs: Sequence[Job], folder: Path
    ) -> Generator[Outcome, None, None]:
        """Every job with its outcome, as they end. Closing the iterator stops all of them."""


def run_jobs(
    jobs: Sequence[Job],
    folder: Path,
    execute: Execute,
    *,
    executor: Executor,
    report: Report = lambda sentence: None,
) -> None:
    """Do every job that is not finished, once, and add its result to `folder`.

    What is stopped, by Ctrl-C or by a lost machine, goes on from its checkpoints when the jobs
    are run again.

    Args:
        jobs: Of one or several studies.
        folder: Results are STUDY.jsonl in it, runs STUDY/CELL.
        execute: Trains and measures one job.
        executor: Where the jobs run.
        report: Receives a sentence for every job that ends.

    Raises:
        UserError: When jobs have failed, after all others are done; or when another command is
            running jobs of the same study in this folder.
    """
    folder = folder.resolve()
    with ExitStack() as stack:
        for study in sorted({job.study for job in jobs}):
            stack.enter_context(locked(folder / study))
        waiting = unfinished(jobs, folder)
        num = len({(job.study, job.key) for job in jobs})
        if len(waiting) < num:
            report(f"{num - len(waiting)} of {num} runs are finished already")
        failures = dict[Job, Failure]()
        outcomes = stack.enter_context(closing(executor.run(execute, waiting, folder)))
        for number, (job, found) in enumerate(outcomes, start=1):
            report(f"[{number}/{len(waiting)}] {job}: {_in_short(found)}")
            if isinstance(found, Failure):
                failures[job] = found
                if found.details:
                    report(found.details.rstrip())
                continue
            append_result(folder, job.study, found, job.config)
            forget_outcome(job, folder)
    _refuse(failures, len(waiting))


def unfinished(jobs: Sequence[Job], folder: Path) -> list[Job]:
    """The jobs that the results in a folder do not hold, each once.

    Raises `UserError` when two of them would share a folder.
    """
    known: dict[str, set[tuple[Cell, int, str]]] = {
        study: {result.key for result in read_lines(folder / f"{study}.jsonl")}
        for study in {job.study for job in jobs}
    }
    wanted = {(job.study, *job.key): job for job in jobs if job.key not in known[job.study]}
    places: dict[tuple[str, str], Job] = {}
    for job in wanted.values():
        other = places.setdefault((job.study, job.folder), job)
        if other is not job:
            raise UserError(
                f"the cells «{job}» and «{other}» would share the folder {job.folder}",
                remedy="give them names that differ in their letters and digits",
            )
    return [*wanted.values()]


@dataclass(frozen=True)
class OneProgram:
    """In this process; jobs that differ by their seeds and by numbers train as one program.

    For accelerators, which a single small network leaves idle.
    """

    train: Callable[[Sequence[Job], Sequence[Path]], None] | None = None
    """Trains several jobs into their folders, from their checkpoints; None: one after another."""
    modules: tuple[str, ...] = ()
    """Modules that register classes of the user's own."""

    def run(
        self, execute: Execute, jobs: Sequence[Job], folder: Path
    ) -> Generator[Outcome, None, None]:
        """Every job with its outcome."""
        import_modules(self.modules)
        for team in _teams(jobs):
            places = [folder / job.study / job.folder for job in team]
            with ExitStack() as stack:
                for place in places:
                    stack.enter_context(held(place))
                if self.train is not None and len(team) > 1:
                    # The others are trained by then, and the one that failed says so again alone.
                    with suppress(UserError):
                        self.train(team, places)
                for job, place in zip(team, places, strict=True):
                    yield job, attempt(place, partial(outcome, execute, job, place))


def _teams(jobs: Sequence[Job]) -> list[list[Job]]:
    """Jobs that one program may train; one that does not train is a team of its own."""
    teams: dict[Any, list[Job]] = {}
    for job in jobs:
        team = (job.study, job.config.program()) if job.trains else job
        teams.setdefault(team, []).append(job)
    return [*teams.values()]


def _in_short(found: Result | Failure) -> str:
    if isinstance(found, Failure):
        return f"failed: {found.what}"
    name, value = next(iter(found.metrics.items()), ("", None))
    return "finished" if value is None else f"{name} {value:.4g}"


def _refuse(failures: dict[Job, Failure], num: int) -> None:
    if not failures:
        return
    (job, failure), *_ = failures.items()
    raise UserError(
        f"{len(failures)} of {num} runs have failed, {job} for instance: "
        + failure.what.rstrip("."),
        remedy="the same command tries them again, from their checkpoints",
    )
