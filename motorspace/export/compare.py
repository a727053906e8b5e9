"""Runs side by side: where their configurations differ, and what each was measured at."""

import json
import math
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from datetime import UTC, datetime
from pathlib import Path
from typing import Any

from motorspace._errors import UserError
from motorspace.export.files import made_by
from motorspace.training.run import Run, load_run

Value = str | int | float | bool | None
Cells = dict[str, tuple[Value, ...]]
"""One value for each run by the dotted name of what it says; None where a run has none."""

Measure = Callable[[Run], Mapping[str, Any]]
"""What a run is measured at, by the keys of the measures."""

EVALUATION = "evaluation.json"


@dataclass(frozen=True)
class Measured:
    """One run as it is compared."""

    name: str
    config: Mapping[str, Any]
    measures: Mapping[str, Any]
    when: str
    """The date of the evaluation, or "now"."""


@dataclass(frozen=True)
class Comparison:
    """Runs side by side. `str` gives a text table."""

    names: tuple[str, ...]
    measured: tuple[str, ...]
    """When each run was measured: a date, or "now"."""
    config: Cells
    """The values that differ between the configurations."""
    measures: Cells

    def as_json(self) -> dict[str, Any]:
        """The comparison as data for JSON; numbers that are not finite become null."""
        return {
            "runs": list(self.names),
            "measured": list(self.measured),
            "config": {name: list(values) for name, values in self.config.items()},
            "measures": {name: [*map(_finite, row)] for name, row in self.measures.items()},
        }

    def __str__(self) -> str:
        config = [[f"  {name}", *map(_text, values)] for name, values in self.config.items()]
        measures = [[f"  {name}", *map(_text, values)] for name, values in self.measures.items()]
        rows = [
            ["", *self.names],
            ["configuration" if config else "configurations are equal"],
            *config,
            ["measured", *self.measured],
            *measures,
        ]
        return _aligned(rows)


def compare(folders: Sequence[Path], *, measure: Measure) -> Comparison:
    """The runs in these folders side by side.

    What `evaluation.json` in a run's folder says is used, with its date, unless the weights are
    newer than it; other runs are measured now.

    Args:
        folders: The folders of two or more finished runs.
        measure: Measures a run.

    Returns:
        Configuration values that differ, and every measure that any of the runs has.

    Raises:
        UserError: There are fewer than two folders, a folder holds no finished run, or its
            `evaluation.json` is damaged.
    """
    if len(folders) < 2:
        raise UserError(f"compare needs at least two runs, got {len(folders)}")
    return compared([measured(folder, measure) for folder in folders])


def compared(runs: Sequence[Measured]) -> Comparison:
    """Measured runs side by side.

    >>> a = Measured("a", {"model": {"encoder": "lstm"}}, {"prediction.error": 0.5}, "now")
    >>> b = Measured("b", {"model": {"encoder": "gru"}}, {"prediction.error": 0.25}, "now")
    >>> print(compared([a, b]))
                        a     b
    configuration
      model.encoder     lstm  gru
    measured            now   now
      prediction.error  0.5   0.25
    """
    config = _side_by_side([run.config for run in runs])
    return Comparison(
        tuple(run.name for run in runs),
        tuple(run.when for run in runs),
        {name: values for name, values in config.items() if _differ(values)},
        _side_by_side([run.measures for run in runs]),
    )


def measured(folder: Path, measure: Measure) -> Measured:
    """The run in a folder as `evaluation.json` has it, or else as `measure` finds it now.

    Raises:
        UserError: The folder holds no finished run, or its `evaluation.json` is damaged.
    """
    run, path = load_run(folder), folder / EVALUATION
    config = made_by(run)["config"]
    if not path.exists() or path.stat().st_mtime < _trained(folder):
        return Measured(str(folder), config, measure(run), "now")
    try:
        found = json.loads(path.read_bytes())
        date = datetime.fromtimestamp(path.stat().st_mtime, UTC)
        return Measured(str(folder), config, dict(found), f"{date:%Y-%m-%d}")
    except (OSError, ValueError, TypeError):
        raise UserError(
            "the evaluation cannot be read",
            where=path,
            remedy=f"measure again: motorspace evaluate {folder}",
        ) from None


def _trained(folder: Path) -> float:
    """When the weights were written, seconds."""
    return (folder / "weights.safetensors").stat().st_mtime


def _side_by_side(found: Sequence[Mapping[str, Any]]) -> Cells:
    """The values of all, in the order of those who name them first."""
    flat = [dict(_flat(values)) for values in found]
    names = dict.fromkeys(name for values in flat for name in values)
    return {name: tuple(values.get(name) for values in flat) for name in names}


def _flat(values: Mapping[str, Any], prefix: str = "") -> Iterator[tuple[str, Value]]:
    for name, value in values.items():
        if isinstance(value, Mapping):
            yield from _flat(value, f"{prefix}{name}.")
        elif isinstance(value, str | int | float | None):
            yield f"{prefix}{name}", value
        else:
            yield f"{prefix}{name}", json.dumps(value)


def _differ(values: tuple[Value, ...]) -> bool:
    return any(value != values[0] for value in values)


def _finite(value: Value) -> Value:
    return None if isinstance(value, float) and not math.isfinite(value) else value


def _text(value: Value) -> str:
    if value is None:
        return "-"
    return f"{value:.6g}" if isinstance(value, float) else str(value)


def _aligned(rows: Sequence[Sequence[str]]) -> str:
    """Columns as wide as their longest cell."""
    num = max(len(row) for row in rows)
    full = [[*row, *[""] * (num - len(row))] for row in rows]
    widths = [max(len(row[column]) for row in full) for column in range(num)]
    lines = ("  ".join(cell.ljust(w) for cell, w in zip(row, widths, strict=True)) for row in full)
    return "\n".join(line.rstrip() for line in lines)
