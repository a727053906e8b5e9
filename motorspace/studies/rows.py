"""From the results of runs to rows: a cell of a study, and its measures over the seeds."""

import math
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field, replace
from functools import cache
from statistics import fmean
from typing import Any

import numpy as np
from jaxtyping import Int

from motorspace._errors import UserError
from motorspace.analysis.measures import Measure, measure
from motorspace.running.jobs import Value, shown
from motorspace.running.store import Number, Result

LEVEL, NUM_RESAMPLES = 0.95, 9999
COMPONENTS = ("longitudinal", "lateral", "cos", "sin")

SYMBOLS = {"rotation": "r", "horizon": "T"}
"""What tables call some settings of cells."""

Numbers = Mapping[str, Number]
"""{key of a measure: value}."""

Settings = Mapping[str, Value | tuple[Value, ...]]
"""Settings of a cell; a tuple stands for any of its values."""


@dataclass(frozen=True)
class Spread:
    """Values of one measure over seeds.

    Example:
        >>> Spread((1.0, 2.0, 3.0, 4.0)).ends
        {'mean': 2.5, 'low': 1.5, 'high': 3.5}
    """

    values: tuple[float, ...]

    @property
    def mean(self) -> float:
        """Their mean."""
        return fmean(self.values)

    @property
    def range(self) -> tuple[float, float]:
        """The lowest and the highest."""
        return min(self.values), max(self.values)

    @property
    def interval(self) -> tuple[float, float]:
        """The bootstrapped 95 % confidence interval of the mean (percentiles)."""
        return _interval(self.values)

    @property
    def ends(self) -> dict[str, float]:
        """The mean and the ends of its interval, as tables and figures take them."""
        low, high = self.interval
        return {"mean": self.mean, "low": low, "high": high}

    def __truediv__(self, level: float) -> "Spread":
        return Spread(tuple(value / level for value in self.values))


@cache
def _interval(values: tuple[float, ...]) -> tuple[float, float]:
    mean = fmean(values)
    if min(values) == max(values):
        return mean, mean
    means = np.asarray(values)[_resamples(len(values))].mean(axis=-1)
    low, high = np.percentile(means, [100 * (1 - LEVEL) / 2, 100 * (1 + LEVEL) / 2])
    return float(low), float(high)


@cache
def _resamples(num: int) -> Int[np.ndarray, "9999 num"]:
    """Which of `num` values each resample holds."""
    return np.random.default_rng(0).integers(0, num, (NUM_RESAMPLES, num))


@dataclass(frozen=True)
class Row:
    """A cell of a study, and what its runs were measured at.

    `row["prediction.error"]` is a `Spread`. A measure that some of the runs lack is not in the
    row.
    """

    study: str
    cell: Mapping[str, Value]
    epochs: int
    runs: Mapping[int, Numbers]
    """{seed: {key of a measure: value}}."""
    derived: Mapping[str, Spread] = field(default_factory=dict)
    """Further measures, made of these runs and of other rows."""

    @property
    def name(self) -> str:
        """The cell, for people.

        Example:
            >>> Row("table1", {"agent": "forward", "rotation": 0.2}, 5000, {}).name
            'forward, r = 0.2 π'
        """
        return ", ".join(
            str(value) if isinstance(value, str) else f"{SYMBOLS.get(name, name)} = {said}"
            for name, value in self.cell.items()
            if (said := setting(name, value))
        )

    def get(self, key: str) -> Spread | None:
        """The values of a measure, or None."""
        if key in self.derived:
            return self.derived[key]
        values = [run.get(key, math.nan) for run in self.runs.values()]
        if not all(map(math.isfinite, values)):
            return None
        found = known_measure(key)
        sign = abs if found and found.arbitrary_sign else float
        return Spread(tuple(map(sign, values)))

    def __getitem__(self, key: str) -> Spread:
        found = self.get(key)
        if found is None:
            raise KeyError(key)
        return found

    def __contains__(self, key: str) -> bool:
        return self.get(key) is not None

    def line(self, *keys: str) -> dict[str, Any]:
        """The settings of the cell and these measures, as figures take them."""
        return {**self.cell, **{key: self[key].ends for key in keys if key in self}}

    def matches(self, settings: Settings) -> bool:
        """Whether the cell has these settings."""
        return all(
            self.cell.get(name) in (value if isinstance(value, tuple) else (value,))
            for name, value in settings.items()
        )

    def with_measures(self, made: Mapping[str, Spread | None]) -> "Row":
        """The row with further measures, of those that are not None."""
        found = {key: spread for key, spread in made.items() if spread is not None}
        return replace(self, derived={**self.derived, **found})


def setting(name: str, value: Value) -> str:
    """A setting of a cell as tables write it: rotations in units of pi."""
    return f"{float(value):.12} π" if name == "rotation" else shown(value)


def under(numbers: Numbers, place: str) -> dict[str, float]:
    """The numbers whose keys begin with a place, without it.

    Example:
        >>> under({"here/error": 1.0, "there/error": 2.0}, "here/")
        {'error': 1.0}
    """
    return {
        key.removeprefix(place): float(value)
        for key, value in numbers.items()
        if key.startswith(place)
    }


def rows_of(study: str, results: Iterable[Result]) -> list[Row]:
    """One row for each cell, in the order in which the cells first come."""
    rows: dict[tuple[tuple[str, Value], ...], list[Result]] = {}
    for result in results:
        rows.setdefault(result.cell, []).append(result)
    return [
        Row(study, dict(cell), runs[0].epochs, {run.seed: run.metrics for run in runs})
        for cell, runs in rows.items()
    ]


def chosen(
    rows: Iterable[Row], study: str | None = None, /, **settings: Value | tuple[Value, ...]
) -> list[Row]:
    """The rows whose cells have these settings."""
    return [row for row in rows if row.matches(settings) and study in (None, row.study)]


def paired(row: Row, other: Row) -> list[tuple[Numbers, Numbers]]:
    """The runs of a row, each with that of the other row which has the same seed, if there is."""
    return [(own, other.runs[seed]) for seed, own in row.runs.items() if seed in other.runs]


def with_worst(row: Row, *families: str) -> Row:
    """The row with the least R² of the four components, as `linear_r2.worst`."""

    def worst(family: str) -> Spread | None:
        keys = [f"{family}.{component}" for component in COMPONENTS]
        if not all(key in row for key in keys):
            return None
        return Spread(tuple(min(run[key] for key in keys) for run in row.runs.values()))

    return row.with_measures({f"{family}.worst": worst(family) for family in families})


def known_measure(key: str) -> Measure | None:
    """The measure of a key, if it is defined."""
    try:
        return measure(key)
    except UserError:
        return None
