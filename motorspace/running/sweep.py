"""Sweeps: a grid or random search over the flags of `motorspace train`, times seeds, as jobs."""

import itertools
import math
import random
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from difflib import get_close_matches
from pathlib import Path
from typing import Any

from motorspace._errors import UserError
from motorspace._files import locked, write_json
from motorspace.running.executors import Executor, Report, run_jobs
from motorspace.running.jobs import Configuration, Job, Value, cell, described
from motorspace.running.work import Execute

SAVED = "sweep.json"
"""File in the folder of a sweep's runs that says what the sweep is."""


@dataclass(frozen=True)
class Trainer:
    """What a sweep has to know about `motorspace train`."""

    configured: Callable[[str, Mapping[str, Any]], Configuration]
    """The configuration of an agent and settings of flags; raises `UserError`."""
    flags: Callable[[str], Mapping[str, Any]]
    """Every flag of an agent (with _ for -), preset among them, and its default; raises
    `UserError` for an unknown agent."""
    measures: Mapping[str, str]
    """Functions that measure a run, by short name; the first is the default."""


@dataclass(frozen=True)
class Distribution:
    """Where the random values of a flag come from."""

    kind: str
    """uniform, log-uniform or choice."""
    values: tuple[Value, ...]
    """Lowest and highest value, or the choices."""

    def at(self, share: float, *, integer: bool) -> Value:
        """The value at a share in [0, 1) of the distribution.

        Args:
            share: Uniformly distributed.
            integer: Round to whole numbers.

        >>> Distribution("log-uniform", (1e-4, 1e-2)).at(0.5, integer=False)
        0.001
        >>> Distribution("uniform", (1, 6)).at(0.99, integer=True)
        6
        """
        if self.kind == "choice":
            return self.values[int(share * len(self.values))]
        low, high = (float(value) for value in self.values)
        if self.kind == "log-uniform":
            value = math.exp(math.log(low) + share * (math.log(high) - math.log(low)))
            return round(value) if integer else float(f"{value:.6g}")
        if integer:
            return int(low + share * (high - low + 1))
        return float(f"{low + share * (high - low):.6g}")


@dataclass(frozen=True)
class Sweep:
    """A search over flags of `motorspace train`. Flags are written with _ for -."""

    name: str
    """Name of the results' file and of the folder of all runs."""
    agents: tuple[str, ...]
    """Agents to train."""
    seeds: tuple[int, ...]
    """Seeds of every cell."""
    fixed: Mapping[str, Value] = field(default_factory=dict)
    """Flags that are the same for all runs, preset among them."""
    grid: Mapping[str, tuple[Value, ...]] = field(default_factory=dict)
    """Flags and their values, of which all combinations are trained."""
    random: Mapping[str, Distribution] = field(default_factory=dict)
    """Flags whose values are drawn."""
    samples: int = 1
    """Random values of each flag; every one is combined with the whole grid."""
    random_seed: int = 0
    """Seed of the random values."""
    measure: str = ""
    """Short name of the function that measures each run; the trainer's first when empty."""
    metrics: tuple[str, ...] = ()
    """Measures to show in tables; the first ones when empty."""
    where: str = "sweep"
    """The file, or the flags, that say so: for messages."""

    def as_json(self) -> dict[str, Any]:
        """The sweep as its file would say it."""
        return {
            "name": self.name,
            "agent": self.agents,
            "seeds": self.seeds,
            "measure": self.measure,
            "metrics": self.metrics,
            "fixed": self.fixed,
            "grid": self.grid,
            "random": {flag: {drawn.kind: drawn.values} for flag, drawn in self.random.items()},
            "samples": self.samples,
            "random-seed": self.random_seed,
        }


def run_sweep(
    sweep: Sweep,
    trainer: Trainer,
    folder: Path,
    execute: Execute,
    *,
    executor: Executor,
    report: Report = lambda sentence: None,
) -> None:
    """Train and measure every run of a sweep that is not finished.

    Results are NAME.jsonl in the folder, runs NAME/CELL; see `run_jobs` for the rest.
    """
    jobs = jobs_of(sweep, trainer)
    place = folder / sweep.name
    with locked(place):
        write_json(place / SAVED, sweep.as_json())
    run_jobs(jobs, folder, execute, executor=executor, report=report)


def jobs_of(sweep: Sweep, trainer: Trainer) -> list[Job]:
    """The runs of a sweep, one seed of every cell before the next seed.

    Raises `UserError` naming file and key for a flag or a value that `motorspace train` refuses.
    """
    measure = _measure(sweep, trainer)
    known = {agent: _known_flags(sweep, trainer, agent) for agent in sweep.agents}
    return [
        _job(sweep, trainer, agent, {**settings, "seed": seed}, measure)
        for seed, agent in itertools.product(sweep.seeds, sweep.agents)
        for settings in _combinations(sweep, known[agent])
    ]


def _job(
    sweep: Sweep, trainer: Trainer, agent: str, settings: dict[str, Value], measure: str
) -> Job:
    named = {name.replace("_", "-"): v for name, v in settings.items() if name != "seed"}
    place = cell(named, agent=agent)
    try:
        config = trainer.configured(agent, {**sweep.fixed, **settings})
    except UserError as error:
        where = f"{sweep.where}, {described(place)}"
        raise UserError(error.what, where=where, remedy=error.remedy) from None
    return Job(sweep.name, place, config, measure)


def _measure(sweep: Sweep, trainer: Trainer) -> str:
    names = [*trainer.measures]
    if sweep.measure and sweep.measure not in names:
        raise UserError(
            f"there is no measure {sweep.measure!r}{nearest(sweep.measure, names)}",
            where=f"{sweep.where}, measure",
            remedy=f"choose one of {', '.join(names)}",
        )
    return trainer.measures[sweep.measure or names[0]]


def _known_flags(sweep: Sweep, trainer: Trainer, agent: str) -> Mapping[str, Any]:
    """The flags of an agent. Raises `UserError` unless those of the sweep are among them."""
    try:
        known = trainer.flags(agent)
    except UserError as error:
        where = f"{sweep.where}, agent"
        raise UserError(error.what, where=where, remedy=error.remedy) from None
    for part in ("fixed", "grid", "random"):
        for flag in getattr(sweep, part).keys() - known.keys():
            written = flag.replace("_", "-")
            raise UserError(
                f"the agent {agent!r} has no flag --{written}{nearest(flag, [*known])}",
                where=f"{sweep.where}, {part}.{written}",
                remedy=f"see motorspace train {agent} --help",
            )
    return known


def nearest(word: str, known: Sequence[str]) -> str:
    """What was meant perhaps, for an error."""
    near = get_close_matches(word, known, 1)
    return f" (perhaps {near[0].replace('_', '-')})" if near else ""


def _combinations(sweep: Sweep, known: Mapping[str, Any]) -> Iterator[dict[str, Value]]:
    """Settings of all cells: every combination of the grid, with every random sample."""
    for values in itertools.product(*sweep.grid.values()):
        for sample in range(sweep.samples):
            drawn = {flag: _draw(sweep, sample, flag, known[flag]) for flag in sweep.random}
            yield dict(zip(sweep.grid, values, strict=True)) | drawn


def _draw(sweep: Sweep, sample: int, flag: str, default: Any) -> Value:
    """A random value, which depends on nothing but the seed, its number and its flag.

    So a sweep with more samples, or with another flag, keeps the runs that are trained already.
    """
    drawn = sweep.random[flag]
    share = random.Random(f"{sweep.random_seed} {sample} {flag}").random()
    whole = all(isinstance(value, int) for value in drawn.values)
    return drawn.at(share, integer=whole and not isinstance(default, float))
