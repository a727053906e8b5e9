"""A study is a question that many runs answer; all it needs stands in one file.

A study outside of motorspace is made known by `register_study`, and is then one of those that
`motorspace reproduce` runs:

    def jobs(budget, seeds):
        return [
            Job("sizes", cell(units=units), changed(base(budget, seed), {"code_size": units}))
            for seed in range(seeds)
            for units in (3, 12, 50)
        ]

    register_study(
        Study(
            name="sizes",
            question="How many units does a code need?",
            jobs=jobs,
            measures={"": lambda run, num: evaluate(run, num=num)},
            tables={"sizes": Table(columns("units", "prediction.error"))},
        )
    )
"""

import importlib
import pkgutil
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING, Any, Literal

from motorspace._errors import UserError
from motorspace.running.jobs import Job
from motorspace.studies.rows import Numbers, Row, Settings, Spread

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from motorspace.training.run import Run

Budget = Literal["quick", "fifth", "half", "paper"]
BUDGETS: tuple[Budget, ...] = ("quick", "fifth", "half", "paper")

Measuring = Callable[["Run", int], Numbers]
"""From a run, and how many trajectories to test it on, to {key of a measure: value}."""

Line = Mapping[str, Any]
"""A row of a table: {head of the column: what stands there}."""


@dataclass(frozen=True)
class Table:
    """A table of the documentation."""

    lines: Callable[[Sequence[Row]], Sequence[Line]]
    budget: Budget | None = None
    """The budget of its runs; by default that of the study."""


@dataclass(frozen=True)
class Target:
    """What the cells of a study are to reach.

    It is judged by the confidence interval of the mean, all of which has to meet the bound; or
    by `every_seed`.
    """

    claim: str
    measure: str
    at_least: float | None = None
    at_most: float | None = None
    cells: Settings = field(default_factory=dict)
    """The cells that it is for; by default all."""
    every_seed: bool = False
    magnitude: bool = False
    """Whether it is about the magnitude of the measure."""

    @property
    def bound(self) -> str:
        """The bound, for people."""
        if self.at_least is not None:
            return f"at least {self.at_least:g}"
        return f"at most {self.at_most:g}"

    def met(self, spread: Spread) -> bool:
        """Whether the values meet it."""
        low, high = spread.range if self.every_seed else spread.interval
        if self.magnitude:
            low, high = 0.0 if low <= 0 <= high else min(abs(low), abs(high)), max(-low, high)
        return low >= self.at_least if self.at_least is not None else high <= (self.at_most or 0.0)


@dataclass(frozen=True)
class Study:
    """A question that many runs answer."""

    name: str
    """Its results are NAME.jsonl, its runs are in the folder NAME."""
    question: str
    """The question, for people."""
    jobs: Callable[[Budget, int], list[Job]]
    """Its runs under a budget, for so many seeds."""
    measures: Mapping[str, Measuring]
    """How runs are measured, by the name that the jobs give."""
    budget: Budget = "fifth"
    """The budget whose results the documentation shows."""
    beside: tuple[str, ...] = ()
    """Studies whose rows stand beside its own."""
    rows: Callable[[Sequence[Row]], Sequence[Row]] = lambda rows: rows
    """From its own rows and those beside it to what tables, targets and figures show."""
    tables: Mapping[str, Table] = field(default_factory=dict)
    """Tables of the documentation by the name of their place, `<!-- table: NAME -->`."""
    targets: tuple[Target, ...] = ()
    figures: Mapping[str, Callable[[Sequence[Row]], "Figure"]] = field(default_factory=dict)
    """Pictures of the documentation by the name of their file."""


_registered: dict[str, Study] = {}


def register_study(study: Study) -> None:
    """Make a study known. Raises `UserError` when motorspace has one of its name."""
    if study.name in _found():
        raise UserError(f"there already is a study {study.name!r}", remedy="choose another name")
    _registered[study.name] = study


def studies() -> dict[str, Study]:
    """Every study by its name: those of this folder, and those that were registered."""
    return _found() | _registered


def study_named(name: str) -> Study:
    """A study by its name. Raises `UserError` naming those there are."""
    known = studies()
    if name not in known:
        raise UserError(
            f"there is no study {name!r}",
            remedy=f"choose one of {', '.join(known)}, or import the module that registers it"
            " (on the command line: --import MODULE)",
        )
    return known[name]


def _found() -> dict[str, Study]:
    modules = (
        importlib.import_module(f"{__package__}.{module.name}")
        for module in pkgutil.iter_modules([str(Path(__file__).parent)])
    )
    found = [study for module in modules if isinstance(study := vars(module).get("STUDY"), Study)]
    return {study.name: study for study in found}
