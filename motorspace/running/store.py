"""Results: one line of JSON per run, with what made it.

A folder of results holds `STUDY.jsonl` for each study, a line per run, and `configs.jsonl`, a
line per configuration: {hash: everything that determines a run}. Merging two folders is
concatenation; of several lines of one run the first counts.
"""

import errno
import fcntl
import functools
import importlib.metadata
import io
import json
import math
import os
import subprocess
from collections.abc import Iterable, Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass
from datetime import date
from pathlib import Path
from typing import Any

from motorspace._errors import UserError
from motorspace.running.jobs import Cell, Configuration, Job, cell, described

CONFIGS = "configs.jsonl"

Number = int | float


@dataclass(frozen=True)
class Result:
    """What one run was measured at, and what made it."""

    cell: Cell
    """The run's place in its study."""
    seed: int
    """Seed of the run."""
    epochs: int
    """Epochs of its training."""
    config: str
    """Hash of its configuration, which `configs.jsonl` holds."""
    code: str
    """Version of motorspace that measured it: a git commit, or a release."""
    date: str
    """Day of the measurement."""
    metrics: dict[str, Number]
    """Measured values by the key of their measure, six significant digits; NaN: undefined."""

    @property
    def key(self) -> tuple[Cell, int, str]:
        """What identifies the run in its study: cell, seed, configuration."""
        return self.cell, self.seed, self.config

    def as_line(self) -> str:
        """The result as one line of JSON; values that are not finite become null."""
        metrics = {name: _number(value) for name, value in self.metrics.items()}
        values = {**vars(self), "cell": dict(self.cell), "metrics": metrics}
        return json.dumps(values, allow_nan=False)


def result_of(job: Job, metrics: Mapping[str, Number]) -> Result:
    """The result of a job that has just been measured."""
    return Result(
        cell=job.cell,
        seed=job.seed,
        epochs=job.config.training.epochs,
        config=job.config.hash(),
        code=code_version(),
        date=date.today().isoformat(),
        metrics={name: _rounded(value) for name, value in metrics.items()},
    )


def from_line(line: str, *, where: object) -> Result:
    """The result in a line. Raises `UserError` with the place when it is broken."""
    try:
        values = json.loads(line)
        metrics = {
            name: math.nan if value is None else value + 0
            for name, value in values["metrics"].items()
        }
        found = Result(**values | {"cell": cell(values["cell"]), "metrics": metrics})
        hash((found.key, found.seed + found.epochs))
    except (ValueError, KeyError, TypeError, AttributeError):
        raise UserError(
            "this is not the result of a run",
            where=where,
            remedy="delete the line: the run is then measured again, and not trained again",
        ) from None
    return found


def read_lines(path: Path) -> list[Result]:
    """The results in a file, each run once; none where no file is.

    Raises `UserError` with the number of a line that is broken.
    """
    found: dict[tuple[Cell, int, str], Result] = {}
    for number, line in _numbered_lines(path):
        result = from_line(line, where=f"{path}, line {number}")
        found.setdefault(result.key, result)
    return [*found.values()]


def append_line(path: Path, line: str) -> None:
    """Add a line to a file, whole or not at all, while no other process writes there.

    Raises `UserError` when it cannot be written.
    """
    try:
        with _locked_file(path) as handle:
            size = handle.seek(0, os.SEEK_END)
            torn = size > 0 and os.pread(handle.fileno(), 1, size - 1) != b"\n"
            content = b"\n" * torn + line.encode() + b"\n"
            try:
                if handle.write(content) < len(content):
                    raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))
                os.fsync(handle.fileno())
            except OSError:
                handle.truncate(size)
                raise
    except OSError as error:
        raise UserError(
            f"the results cannot be written ({error.strerror})",
            where=path,
            remedy="make room, or choose another folder; finished runs are not trained again",
        ) from None


def append_result(folder: Path, study: str, result: Result, config: Configuration) -> None:
    """Add a run to the results of its study, and its configuration where that is new."""
    if result.config not in read_configs(folder):
        append_line(folder / CONFIGS, json.dumps({result.config: config.as_json()}))
    append_line(folder / f"{study}.jsonl", result.as_line())


def read_configs(folder: Path) -> dict[str, dict[str, Any]]:
    """The configurations of a folder of results by their hash.

    Raises `UserError` with the number of a line that is broken.
    """
    path, found = folder / CONFIGS, dict[str, dict[str, Any]]()
    for number, line in _numbered_lines(path):
        try:
            found |= json.loads(line)
        except (ValueError, TypeError):
            raise UserError(
                "this is not a configuration",
                where=f"{path}, line {number}",
                remedy="delete the line; the results themselves are in the other files",
            ) from None
    return found


def merge(folder: Path, other: Path) -> list[str]:
    """Add the results of another folder to this one.

    Returns:
        A sentence for each run that both have measured, with different values: the first stays.
    """
    known, conflicts = read_configs(folder), []
    for name, config in read_configs(other).items():
        if name not in known:
            append_line(folder / CONFIGS, json.dumps({name: config}))
    for path in sorted(other.glob("*.jsonl")):
        if path.name == CONFIGS:
            continue
        ours = {result.key: result for result in read_lines(folder / path.name)}
        for result in read_lines(path):
            mine = ours.get(result.key)
            if mine is None:
                append_line(folder / path.name, result.as_line())
            elif repr(mine.metrics) != repr(result.metrics):
                conflicts.append(f"{path.stem}: {_named(result)} is measured in both folders")
    return conflicts


def finished(job: Job, results: Iterable[Result]) -> bool:
    """Whether these results of its study hold the job: its cell, seed and configuration."""
    return any(result.key == job.key for result in results)


def current(results: Iterable[Result], jobs: Iterable[Job]) -> list[Result]:
    """The results that these jobs would give today: what may be shown."""
    keys = {job.key for job in jobs}
    return [result for result in results if result.key in keys]


def stale(results: Iterable[Result], jobs: Iterable[Job]) -> list[Result]:
    """The results of a cell and seed of these jobs, but of another configuration.

    Args:
        results: Those of one study.
        jobs: All that the study has, of every budget: a run of fewer epochs is not stale.
    """
    keys = {job.key for job in jobs}
    places = {key[:2] for key in keys}
    return [r for r in results if r.key not in keys and r.key[:2] in places]


def stale_names(results: Iterable[Result], jobs: Iterable[Job]) -> list[str]:
    """A name for each stale result, for people."""
    return [_named(result) for result in stale(results, jobs)]


@functools.cache
def code_version() -> str:
    """The git commit of motorspace, with a + for changes since, else its release."""
    root = Path(__file__).parents[2]
    try:
        if (root / ".git").exists():
            commit = _git(root, "rev-parse", "--short=7", "HEAD")
            return commit + "+" * bool(_git(root, "status", "--porcelain", "--", "motorspace"))
    except (OSError, subprocess.CalledProcessError):
        pass
    try:
        return importlib.metadata.version("motorspace")
    except importlib.metadata.PackageNotFoundError:
        return "unknown"


def _git(root: Path, *arguments: str) -> str:
    done = subprocess.run(["git", "-C", root, *arguments], capture_output=True, check=True)
    return done.stdout.decode().strip()


def _named(result: Result) -> str:
    return f"{described(result.cell)} seed={result.seed} (configuration {result.config})"


@contextmanager
def _locked_file(path: Path) -> Iterator[io.FileIO]:
    path.parent.mkdir(parents=True, exist_ok=True)
    with path.open("ab+", buffering=0) as handle:
        fcntl.flock(handle, fcntl.LOCK_EX)
        yield handle


def _numbered_lines(path: Path) -> Iterator[tuple[int, str]]:
    try:
        lines = path.read_text().split("\n")
    except FileNotFoundError:
        return
    except (OSError, ValueError):
        raise UserError("the results cannot be read", where=path) from None
    yield from ((number, line) for number, line in enumerate(lines, start=1) if line.strip())


def _number(value: Number) -> Number | None:
    return _rounded(value) if math.isfinite(value) else None


def _rounded(value: Number) -> Number:
    """Six significant digits of a float; a count stays as it is."""
    return int(value) if isinstance(value, int) else float(f"{value:.6g}")
