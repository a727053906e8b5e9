"""Tables: rows of labels and of measures by key, as Markdown, and numbers as people read them."""

import re
from collections.abc import Mapping, Sequence
from math import floor, log10
from typing import Any, NamedTuple

import numpy as np

from motorspace.analysis.measures import measure

Row = Mapping[str, Any]
DIGITS = 3
SMALL = 1e-3
"""Numbers below it are written with an exponent."""
PLACE = re.compile(r"(<!-- table: ([a-z0-9_]+) -->\n)(.*?)(<!-- end -->)", re.DOTALL)
"""Where a table stands in a page."""


class Interval(NamedTuple):
    """A mean, and the ends of its interval."""

    low: float
    mean: float
    high: float

    @property
    def half_width(self) -> float:
        """Half of the interval's length."""
        return (self.high - self.low) / 2


def interval_of(value: Any) -> Interval | None:
    """Returns a value of a row as an interval; None where the value is no number.

    Args:
        value: {"mean", "low", "high"}, as rows over several seeds hold it, or one number.

    Example:
        >>> interval_of({"mean": 2.0, "low": 1.5, "high": 2.5}).half_width
        0.5
    """
    if isinstance(value, Mapping) and "mean" in value:
        return Interval(*(float(value[end]) for end in ("low", "mean", "high")))
    if isinstance(value, int | float | np.integer | np.floating) and not isinstance(value, bool):
        return Interval(float(value), float(value), float(value))
    return None


def measured_rows(rows: Sequence[Row], labels: Sequence[str], keys: Sequence[str]) -> list[Row]:
    """Returns the rows of a table: columns of `labels`, then measures under their labels.

    Args:
        rows: Each holds its labels, and values or intervals by the keys of measures.
        labels: Which columns of the rows come first, as they are.
        keys: Which measures follow; a dash stands where a row lacks one.

    Example:
        >>> measured_rows([{"agent": "forward", "linear_r2.worst": 0.99}], ["agent"],
        ...               ["linear_r2.worst"])
        [{'agent': 'forward', 'linear R², worst': 0.99}]
    """
    return [
        {label: row.get(label) for label in labels} | {measure(k).title: row.get(k) for k in keys}
        for row in rows
    ]


def report_rows(report: Mapping[str, float]) -> list[Row]:
    """Returns a report on codes as the rows of a table: value, what is perfect, and chance.

    Args:
        report: What `topology` returns, or {key: value}.
    """
    rows: list[Row] = []
    for key, value in report.items():
        known, error = measure(key), getattr(value, "standard_error", None) or 0.0
        spread = {"mean": float(value), "low": value - error, "high": value + error}
        rows.append(
            {"measure": known.title, "value": spread, "perfect": _exactly(known.perfect)}
            | {"chance": _exactly(known.chance), "what it is": known.meaning}
        )
    return rows


def markdown_table(rows: Sequence[Row]) -> str:
    """Returns rows as a Markdown table; the first row's keys are the columns. No rows, no table.

    Example:
        >>> print(markdown_table([{"agent": "forward", "error": 3.80314}]), end="")
        | agent | error |
        |---|---|
        | forward | 3.80 |
    """
    if not rows:
        return ""
    columns = list(rows[0])
    lines = ["| " + " | ".join(columns) + " |", "|" + "---|" * len(columns)]
    lines += [
        "| " + " | ".join(shown(row.get(c)).replace("|", "\\|") for c in columns) + " |"
        for row in rows
    ]
    return "\n".join(lines) + "\n"


def shown(value: Any) -> str:
    """Returns a value as a table shows it: three digits, ± half the interval, a dash for nothing.

    Example:
        >>> shown(0.99674), shown({"mean": 3.803, "low": 3.78, "high": 3.82}), shown(None)
        ('0.997', '3.80 ± 0.02', '–')
    """
    if value is None:
        return "–"
    if isinstance(value, bool | np.bool_):
        return "yes" if value else "no"
    if isinstance(value, int | np.integer):
        return f"{value:,}" if abs(int(value)) >= 10_000 else str(value)
    found = interval_of(value)
    if found is None:
        return str(value)
    return _with_half_width(found) if found.half_width > 0 else number(found.mean)


def number(value: float) -> str:
    """Returns a number with three significant digits.

    Example:
        >>> number(0.5), number(1.0), number(12345.6), number(0.0000123)
        ('0.500', '1', '12,346', '1.23e-5')
    """
    if not np.isfinite(value):
        return str(float(value))
    if value == round(value) and abs(value) < 10**DIGITS:
        return f"{value:.0f}"
    if value != 0 and abs(value) < SMALL:
        return _small(value, DIGITS)
    return f"{value:,.{_decimals(value, DIGITS)}f}"


def _exactly(value: float | None) -> str:
    return "" if value is None else f"{value:g}"


def _with_half_width(found: Interval) -> str:
    """The mean in three digits, and the half-width to the same place or in one digit."""
    mean, half = found.mean, found.half_width
    if max(abs(mean), half) < SMALL:
        return f"{_small(mean, DIGITS)} ± {_small(half, 1)}"
    decimals = min(_decimals(mean, DIGITS), _decimals(half, 2))
    if round(half, decimals) > 0:
        return f"{mean:,.{decimals}f} ± {half:,.{decimals}f}"
    fine = f"{half:.{_decimals(half, 1)}f}" if half > SMALL / 10 else _small(half, 1)
    return f"{mean:,.{decimals}f} ± {fine}"


def _decimals(value: float, digits: int) -> int:
    """Decimal places that show so many significant digits; many for 0, which has none."""
    return max(0, digits - 1 - floor(log10(abs(value)))) if value else 99


def _small(value: float, digits: int) -> str:
    mantissa, exponent = f"{value:.{digits - 1}e}".split("e")
    return f"{mantissa}e{int(exponent)}" if value else "0"


def places(page: str) -> list[str]:
    """Returns the names of the tables that stand in a page.

    Example:
        >>> places("<!-- table: errors -->\\n<!-- end -->")
        ['errors']
    """
    return [found[2] for found in PLACE.finditer(page)]


def filled(page: str, tables: Mapping[str, str]) -> str:
    """Returns the page with these tables in their places; others stay as they are.

    Args:
        page: Markdown.
        tables: {name: Markdown}.
    """
    return PLACE.sub(lambda found: found[1] + tables.get(found[2], found[3]) + found[4], page)
