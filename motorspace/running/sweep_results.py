"""What a sweep has come to: the state of its runs, a table, the best cell."""

import math
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

from motorspace._errors import UserError
from motorspace.running.jobs import Cell, Job, described, shown
from motorspace.running.store import Result, current, read_lines, stale_names
from motorspace.running.sweep import nearest
from motorspace.running.work import OUTCOME

SHOWN = 5
"""Measures that a table shows where nobody says which."""


@dataclass(frozen=True)
class State:
    """How far a run has come."""

    job: Job
    state: str
    """finished, failed, begun or waiting."""
    reason: str = ""
    """Why it has failed."""


@dataclass(frozen=True)
class Row:
    """What the finished runs of a cell were measured at, over its seeds."""

    cell: Cell
    """The cell."""
    values: dict[str, tuple[float, ...]]
    """A value for each seed, by measure."""

    @property
    def num_seeds(self) -> int:
        """Finished seeds."""
        return max((len(values) for values in self.values.values()), default=0)

    def mean(self, metric: str) -> float:
        """Mean over the seeds; NaN where a seed has no such value."""
        values = self.values.get(metric, (math.nan,))
        return sum(values) / len(values)

    def half_width(self, metric: str) -> float:
        """Half of the mean's 95 % confidence interval (Student's t); NaN for fewer than 2 seeds."""
        values = self.values.get(metric, ())
        if len(values) < 2:
            return math.nan
        from scipy.special import stdtrit

        mean, degrees = self.mean(metric), len(values) - 1
        variance = sum((value - mean) ** 2 for value in values) / degrees
        return float(stdtrit(degrees, 0.975)) * math.sqrt(variance / len(values))


def states(jobs: Sequence[Job], folder: Path) -> list[State]:
    """How far every run of a sweep has come.

    Args:
        jobs: The sweep's (`jobs_of`).
        folder: Where it ran.
    """
    finished = {result.key for job in jobs[:1] for result in _results(job.study, folder)}
    return [
        State(job, "finished") if job.key in finished else _unfinished(job, folder) for job in jobs
    ]


def status(jobs: Sequence[Job], folder: Path) -> str:
    """The state of each cell and the reasons of failures, as text; stale results by name."""
    by_cell: dict[Cell, list[State]] = {}
    for state in states(jobs, folder):
        by_cell.setdefault(state.job.cell, []).append(state)
    lines = [f"{described(cell)}: {_counts(found)}" for cell, found in by_cell.items()]
    every = [state for found in by_cell.values() for state in found]
    lines += [f"failed: {s.job}: {s.reason}" for s in every if s.state == "failed"]
    for job in jobs[:1]:
        names = stale_names(_results(job.study, folder), jobs)
        lines += [f"stale, of another configuration: {name}" for name in names]
    return "\n".join([*lines, f"all: {_counts(every)}"])


def rows(jobs: Sequence[Job], folder: Path) -> list[Row]:
    """The measured values of every cell with finished runs, in the order of the jobs."""
    by_cell: dict[Cell, dict[str, list[float]]] = {job.cell: {} for job in jobs}
    for job in jobs[:1]:
        results = current(_results(job.study, folder), jobs)
        for result in sorted(results, key=lambda result: result.seed):
            for metric, value in result.metrics.items():
                by_cell[result.cell].setdefault(metric, []).append(value)
    return [
        Row(cell, {metric: tuple(v) for metric, v in values.items()})
        for cell, values in by_cell.items()
        if values
    ]


def table(found: Sequence[Row], metrics: Sequence[str] = ()) -> str:
    """Mean and 95 % interval of measures in every cell, as a table in Markdown.

    Args:
        found: The rows.
        metrics: Measures to show; the first ones when left out.

    Raises:
        UserError: When nothing has such a measure.
    """
    _check_metrics(found, metrics)
    chosen = metrics or _metrics(found)[:SHOWN]
    settings = [*dict.fromkeys(name for row in found for name, _ in row.cell)]
    lines = [[*settings, "seeds", *chosen]]
    for row in found:
        place = {name: shown(value) for name, value in row.cell}
        values = [_estimate(row, metric) for metric in chosen]
        lines.append([*(place.get(s, "") for s in settings), str(row.num_seeds), *values])
    widths = [max(map(len, column)) for column in zip(*lines, strict=True)]
    lines.insert(1, ["-" * width for width in widths])
    text = "\n".join(
        f"| {' | '.join(w.ljust(n) for w, n in zip(words, widths, strict=True))} |"
        for words in lines
    )
    left_out = len(_metrics(found)) - len(chosen)
    return text + f"\n{left_out} more measures: name them with --metrics" * (left_out > 0)


def best(found: Sequence[Row], metric: str, *, perfect: float = 0.0) -> Row:
    """The cell whose mean is nearest to the perfect value of a measure.

    Args:
        found: The rows.
        metric: Key of the measure.
        perfect: Its perfect value: 0 for errors, 1 for R²; infinity: the higher the better.

    Raises:
        UserError: When nothing has such a measure.
    """
    _check_metrics(found, [metric])

    def distance(row: Row) -> float:
        mean = row.mean(metric)
        far = abs(mean - perfect) if math.isfinite(perfect) else -mean * math.copysign(1, perfect)
        return math.inf if math.isnan(far) else far

    return min(found, key=distance)


def _results(study: str, folder: Path) -> list[Result]:
    return read_lines(folder / f"{study}.jsonl")


def _unfinished(job: Job, folder: Path) -> State:
    place = folder / job.study / job.folder
    try:
        reason = (place / OUTCOME / "failure.txt").read_text().partition("\n")[0]
        return State(job, "failed", reason)
    except OSError:
        return State(job, "begun" if place.exists() else "waiting")


def _counts(found: Sequence[State]) -> str:
    names = [state.state for state in found]
    present = [n for n in ("finished", "begun", "failed", "waiting") if n in names]
    return ", ".join(f"{names.count(name)} {name}" for name in present)


def _metrics(found: Sequence[Row]) -> list[str]:
    return [*dict.fromkeys(metric for row in found for metric in row.values)]


def _check_metrics(found: Sequence[Row], metrics: Sequence[str]) -> None:
    if not found:
        raise UserError(
            "no run of this sweep is finished", remedy="run it with: motorspace sweep SPEC"
        )
    known = _metrics(found)
    for metric in metrics:
        if metric not in known:
            raise UserError(
                f"no run has measured {metric!r}{nearest(metric, known)}",
                where="metrics",
                remedy=f"choose from {', '.join(known)}",
            )


def _estimate(row: Row, metric: str) -> str:
    mean, half = row.mean(metric), row.half_width(metric)
    if math.isnan(mean):
        return "undefined"
    return f"{mean:.4g}" + (f" ± {half:.2g}" if math.isfinite(half) else "")
