"""Reports: measures by key, each with the standard error of drawing subsets."""

import math
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from motorspace.analysis.measures import measure


class Estimate(float):
    """The value of a measure: a float that knows its standard error.

    Example:
        >>> value = Estimate(0.98, standard_error=0.004)
        >>> value > 0.9, value
        (True, 0.98 ± 0.004)
    """

    standard_error: float | None
    """Of the mean over random subsets; 0 where one subset holds all points, None for a measure
    that is not taken on subsets."""

    def __new__(cls, value: float, standard_error: float | None = None) -> "Estimate":
        made = super().__new__(cls, value)
        made.standard_error = standard_error
        return made

    @property
    def mean(self) -> float:
        """The value as a plain float."""
        return float(self)

    def __getnewargs__(self) -> tuple[float, float | None]:  # type: ignore[override]
        return float(self), self.standard_error

    def __repr__(self) -> str:
        error = f" ± {self.standard_error:.2g}" if self.standard_error else ""
        return f"{float(self):.4g}{error}"


Estimates = dict[str, Estimate]


def over_subsets(
    take: Callable[[np.ndarray], dict[str, float]], subsets: Sequence[np.ndarray]
) -> Estimates:
    """Returns the mean of each measure over subsets of the points, and its standard error.

    Args:
        take: From the indices of some points to {key: value}.
        subsets: The indices of each subset.
    """
    samples = [take(rows) for rows in subsets]
    table = {key: np.array([sample[key] for sample in samples]) for key in samples[0]}
    many = len(samples)
    return {
        key: Estimate(
            float(values.mean()), float(values.std(ddof=1) / np.sqrt(many)) if many > 1 else 0.0
        )
        for key, values in table.items()
    }


@dataclass(frozen=True, eq=False)
class Topology(Mapping[str, Estimate]):
    """A report on codes: the measures that could be taken, by their keys.

    `report["linear_r2.cos"]` is an `Estimate`, a float with a `standard_error`. What is not
    measured is not in the report: `report.get("partial_motors")` is None without motors. As
    attributes, measures are `report.rank_correlation`, and families are mappings:
    `report.linear_r2["cos"]`, `report.trustworthiness[20]`. `motorspace.analysis.measures.measure`
    tells what each key means; `print(report)` makes a table.
    """

    num_points: int
    """Codes that were measured."""
    weight: float
    """World units that a unit of (cos, sin) of the orientation change counts for."""
    seed: int
    """Seed of the random subsets of pairs."""
    estimates: Mapping[str, Estimate]
    """The same as a plain mapping."""

    def __getitem__(self, key: str) -> Estimate:
        return self.estimates[key]

    def __iter__(self) -> Iterator[str]:
        return iter(self.estimates)

    def __len__(self) -> int:
        return len(self.estimates)

    def __getattr__(self, name: str) -> Any:
        if name.startswith("_") or name == "estimates":  # as copying and pickling ask for
            raise AttributeError(name)
        if name in self.estimates:
            return self.estimates[name]
        family = {
            int(rest) if rest.isdigit() else rest: value
            for key, value in self.items()
            for head, _, rest in [key.partition(".")]
            if head == name
        }
        if family:
            return family
        raise AttributeError(f"this report has no {name!r}; it has {', '.join(self)}")

    def updated(self, estimates: Mapping[str, float]) -> "Topology":
        """Returns the report with further measures, or others in place of its own."""
        added = {key: Estimate(value) for key, value in estimates.items()}
        return replace(self, estimates=_defined({**self.estimates, **added}))

    def to_dict(self) -> dict[str, list[float | None]]:
        """Returns {key: [value, standard error]}, with None for what is no number: valid JSON."""
        return {key: [_finite(one), _finite(one.standard_error)] for key, one in self.items()}

    def __str__(self) -> str:
        """A table with a line for each measure."""
        head = f"{self.num_points:,} points, weight of orientation {self.weight:.4g}"
        lines = [head, "", _line("measure", "value", "std. error", "perfect", "chance")]
        for key, value in self.items():
            known, error = measure(key), value.standard_error
            lines.append(
                _line(
                    known.title,
                    f"{value.mean:.4g}",
                    f"{error:.2g}" if error else "",
                    _number(known.perfect),
                    _number(known.chance),
                )
            )
        return "\n".join(lines)


def report(num_points: int, weight: float, seed: int, estimates: Estimates) -> Topology:
    """Returns the report of these measures without those that are undefined here (NaN)."""
    return Topology(num_points, weight, seed, _defined(estimates))


def _defined(estimates: Mapping[str, Estimate]) -> Estimates:
    return {key: value for key, value in estimates.items() if not math.isnan(value)}


def _line(label: str, value: str, error: str, perfect: str, chance: str) -> str:
    return f"{label:<44} {value:>10} {error:>10} {perfect:>8} {chance:>7}".rstrip()


def _number(value: float | None) -> str:
    return "" if value is None else f"{value:g}"


def _finite(value: float | None) -> float | None:
    return float(value) if value is not None and math.isfinite(value) else None
