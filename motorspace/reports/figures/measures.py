"""Pictures of measures: views of rows that hold labels, and values or intervals by key.

A row is one cell of an experiment: `{"agent": "forward", "rotation": 0.4, "linear_r2.worst":
{"mean": ..., "low": ..., "high": ...}}`. What a key is called, its scale and its perfect value
stand in the table of measures.
"""

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any, Literal

import numpy as np
from jaxtyping import Float
from matplotlib.axes import Axes
from matplotlib.axis import XAxis, YAxis
from matplotlib.figure import Figure
from matplotlib.ticker import LogLocator, NullFormatter

from motorspace.analysis.measures import Measure, measure
from motorspace.reports.figures.style import SERIES, ink, new_figure, styled
from motorspace.reports.tables import Interval, Row, interval_of

STROKES = ("-", "--", ":", "-.")
MOST_COLUMNS = 4


@dataclass(frozen=True)
class Axis:
    """The horizontal axis of curves: a column of the rows."""

    column: str
    label: str = ""
    """What the picture calls it; by default the column's name."""
    scale: Literal["linear", "log", "symlog"] = "linear"
    linear_below: float = 1e-5
    """Up to where the scale `symlog` is linear, so that it has a 0."""
    mark: float | None = None
    """Where a vertical line stands, as for the length that was trained on."""


@styled
def curves_figure(
    rows: Sequence[Row],
    x: Axis | str,
    measures: Sequence[str],
    *,
    series: Sequence[str] = (),
    panels: str = "",
    targets: Mapping[str, float] = {},
) -> Figure:
    """Returns curves of measures over a column, with the intervals of their means.

    A dotted line is at what is perfect, a dashed one at the target.

    Args:
        rows: Labels, and values or intervals by key.
        x: The horizontal axis, or the column that it shows.
        measures: Their keys: a panel for each.
        series: Columns whose values tell curves apart: the first by colour, the second by stroke.
        panels: A column with a panel for each of its values, for one measure.
        targets: {key: the value to reach}.

    Example:
        >>> rows = [{"r": r, "linear_r2.cos": 1 - r / 10} for r in (0.2, 0.4)]
        >>> len(curves_figure(rows, "r", ["linear_r2.cos"]).axes)
        1
    """
    axis = Axis(x) if isinstance(x, str) else x
    grid = [(key, part) for key in measures for part in (_values(rows, panels) if panels else [""])]
    across = min(len(grid), MOST_COLUMNS)
    down = -(-len(grid) // across)
    figure = new_figure(1.2 + 3.3 * across, 0.5 + 3.0 * down)
    axes_of = figure.subplots(down, across, squeeze=False, sharey=bool(panels)).ravel()
    for axes, (key, part) in zip(axes_of, grid, strict=False):
        chosen = [row for row in rows if not panels or row.get(panels) == part]
        known = measure(key)
        for names, curve in _curves(chosen, series).items():
            look = _look(names, [_values(rows, column) for column in series])
            _curve(axes, axis.column, key, curve, label=", ".join(map(_word, names)), **look)
        _frame(axes, known, targets.get(key))
        axes.set(title=_word(part) if panels else known.title)
        _scale(axes, axis)
    for axes in axes_of[len(grid) :]:
        axes.remove()
    if panels:
        figure.axes[0].set_ylabel(measure(measures[0]).title)
    _legend(figure)
    return figure


@styled
def changes_figure(rows: Sequence[Row], label: str, measures: Sequence[str]) -> Figure:
    """Returns a line for each row, with a panel for each measure and its interval.

    Args:
        rows: Labels, and values or intervals by key.
        label: The column that names the rows.
        measures: Their keys.
    """
    figure = new_figure(1.8 + 3 * len(measures), 1.0 + 0.3 * len(rows))
    panels = figure.subplots(1, len(measures), sharey=True, squeeze=False)[0]
    for axes, key in zip(panels, measures, strict=True):
        known, found = measure(key), _points(rows, key)
        shown = [place for place, row in enumerate(rows) if interval_of(row.get(key))]
        axes.hlines(shown, found["low"], found["high"], color=SERIES[0], lw=2.2, alpha=0.45)
        axes.plot(found["mean"], shown, "o", ms=5, color=SERIES[0])
        if known.log_scale:
            axes.set_xscale("log")
            _label_logarithms(axes.xaxis, axes.get_xlim())
        if _near(known.perfect, axes.get_xlim(), known):
            axes.axvline(known.perfect or 0.0, color=ink("muted"), lw=0.8, ls=":")
        axes.set(title=known.title, yticks=range(len(rows)), yticklabels=[r[label] for r in rows])
    figure.axes[0].invert_yaxis()
    return figure


@styled
def comparison_figure(rows: Sequence[Row], x: str, y: str, *, series: Sequence[str] = ()) -> Figure:
    """Returns one measure over another, a point with its intervals for each row.

    Args:
        rows: Labels, and values or intervals by key.
        x: The key of the measure across.
        y: The key of the measure upward; equal values of both lie on the dotted line.
        series: Columns that tell points apart: the first by colour, the second by filling.
    """
    figure = new_figure(5.6, 4.4)
    axes = figure.add_subplot()
    present = [row for row in rows if interval_of(row.get(x)) and interval_of(row.get(y))]
    for names, points in _curves(present, series).items():
        colour, stroke = _look(names, [_values(rows, column) for column in series]).values()
        across, upward = _points(points, x), _points(points, y)
        axes.errorbar(
            across["mean"],
            upward["mean"],
            xerr=_around(across),
            yerr=_around(upward),
            label=", ".join(map(_word, names)),
            fmt="o",
            color=colour,
            elinewidth=0.8,
            mfc=colour if stroke == STROKES[0] else "none",
        )
    axes.axline((0, 0), slope=1, color=ink("muted"), lw=0.8, ls=":")
    axes.set(xlabel=measure(x).title, ylabel=measure(y).title)
    if series:
        axes.legend()
    return figure


@styled
def learning_figure(
    curves: Mapping[str, Float[np.ndarray, " _"]], references: Mapping[str, float] = {}
) -> Figure:
    """Returns errors over epochs on a logarithmic scale, with constant levels to compare with.

    Args:
        curves: {name: the mean squared error after each epoch}.
        references: {name: level}.
    """
    figure = new_figure(7.5, 4.0)
    axes = figure.add_subplot()
    for name, values in curves.items():
        axes.plot(np.arange(1, len(values) + 1), values, label=name)
    for index, (name, level) in enumerate(references.items()):
        axes.axhline(level, label=name, color=ink("muted"), lw=1.1, ls=STROKES[1 + index % 3])
    axes.set(xlabel="epoch", ylabel="mean squared error", yscale="log")
    axes.yaxis.set_major_formatter("{x:g}")
    axes.yaxis.set_minor_formatter("{x:g}")
    axes.legend(loc="upper right", ncols=2)
    return figure


def along(rows: Iterable[Row], family: str, column: str) -> list[Row]:
    """Returns a row for each member of a family that ends in a number, which becomes a column.

    Args:
        rows: With keys such as `length_error.translation.6`.
        family: The first part of the keys, such as `length_error.translation`; it becomes the key.
        column: What the number is, such as `commands`.

    Example:
        >>> along([{"agent": "a", "trustworthiness.10": 0.9}], "trustworthiness", "k")
        [{'agent': 'a', 'k': 10, 'trustworthiness': 0.9}]
    """
    long: list[Row] = []
    for row in rows:
        labels = {name: value for name, value in row.items() if "." not in name}
        for key, value in row.items():
            head, _, last = key.rpartition(".")
            if head == family and last.isdigit():
                long.append({**labels, column: int(last), family: value})
    return long


def _values(rows: Iterable[Row], column: str) -> list[Any]:
    """The values of a column, in the order in which they come."""
    return list(dict.fromkeys(row[column] for row in rows if column in row))


def _curves(rows: Sequence[Row], series: Sequence[str]) -> dict[tuple[Any, ...], list[Row]]:
    curves: dict[tuple[Any, ...], list[Row]] = {}
    for row in rows:
        curves.setdefault(tuple(row.get(column) for column in series), []).append(row)
    return curves


def _look(names: Sequence[Any], values: Sequence[list[Any]]) -> dict[str, Any]:
    """Colour by the first of the names, stroke by the second."""
    places = [found.index(name) for name, found in zip(names, values, strict=True)] + [0, 0]
    return {
        "color": SERIES[places[0] % len(SERIES)],
        "ls": STROKES[places[1] % len(STROKES)],
    }


def _curve(
    axes: Axes, column: str, key: str, rows: Sequence[Row], *, label: str, **look: Any
) -> None:
    present = [row for row in rows if interval_of(row.get(key))]
    if not present:
        return
    x, found = [row[column] for row in present], _points(present, key)
    drawn = axes.plot(x, found["mean"], marker="o", label=label, **look)
    axes.fill_between(x, found["low"], found["high"], alpha=0.18, color=drawn[0].get_color(), lw=0)


def _points(rows: Sequence[Row], key: str) -> dict[str, Float[np.ndarray, " _"]]:
    """Means and ends of a measure in all rows that have it."""
    found = [one for row in rows if (one := interval_of(row.get(key)))]
    return {end: np.array([getattr(one, end) for one in found]) for end in Interval._fields}


def _around(found: Mapping[str, Float[np.ndarray, " _"]]) -> Float[np.ndarray, "2 _"]:
    return np.stack([found["mean"] - found["low"], found["high"] - found["mean"]])


def _frame(axes: Axes, known: Measure, target: float | None) -> None:
    if known.log_scale:
        axes.set_yscale("log")
        _label_logarithms(axes.yaxis, axes.get_ylim())
    if target is not None:
        axes.axhline(target, color=ink("text"), lw=0.8, ls="--")
    if _near(known.perfect, axes.get_ylim(), known):
        axes.axhline(known.perfect or 0.0, color=ink("muted"), lw=0.8, ls=":")


def _label_logarithms(axis: XAxis | YAxis, limits: tuple[float, float]) -> None:
    """Labels at 1, 2, 5 where less than two decades are shown; else those of matplotlib."""
    if limits[1] < 100 * limits[0]:
        axis.set_major_locator(LogLocator(subs=(1.0, 2.0, 5.0)))
        axis.set_major_formatter("{x:g}")
        axis.set_minor_formatter(NullFormatter())


def _near(value: float | None, limits: tuple[float, float], known: Measure) -> bool:
    """Whether a value is on the scale, or so near that showing it leaves the curves their room."""
    if value is None or (known.log_scale and value <= 0):
        return False
    room = 0.3 * (limits[1] - limits[0])
    return bool(known.log_scale or limits[0] - room <= value <= limits[1] + room)


def _scale(axes: Axes, axis: Axis) -> None:
    axes.set_xlabel(axis.label or axis.column)
    if axis.scale == "symlog":
        axes.set_xscale("symlog", linthresh=axis.linear_below)
        axes.set_xlim(left=-axis.linear_below / 2)
    else:
        axes.set_xscale(axis.scale)
    if axis.mark is not None:
        axes.axvline(axis.mark, color=ink("muted"), lw=0.8, ls=":")


def _legend(figure: Figure) -> None:
    """One legend for all panels."""
    found = {
        label: handle
        for axes in figure.axes
        for handle, label in zip(*axes.get_legend_handles_labels(), strict=True)
        if label
    }
    if found:
        columns = min(len(found), 2 * max(1, round(figure.get_figwidth() / 4)))
        figure.legend(found.values(), found.keys(), loc="outside lower center", ncols=columns)


def _word(value: Any) -> str:
    return f"{value:g}" if isinstance(value, float) else str(value)
