"""Panels of curves: measures with their intervals, over whatever was varied."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

from matplotlib.axes import Axes
from matplotlib.figure import Figure


Point = tuple[float, float, float, float]
"""Where a value was measured, the value, and the two ends of its interval."""


@dataclass(frozen=True)
class Curve:
    """Points that a line connects.

    Args:
        points: In order of x.
        style: Options of matplotlib's `plot`: color, ls, ...
    """

    points: Sequence[Point]
    style: Mapping[str, Any] = field(default_factory=dict)


@dataclass(frozen=True)
class Panel:
    """Curves that share axes.

    Args:
        title: What stands above.
        curves: {name in the legend: curve}; those without points are left out.
        axes: Options of matplotlib's `Axes.set`: xlabel, yscale, ...
        level: A value that is marked, such as a target.
        mark: A place that is marked, such as the length that was trained on.
        joined: Whether a line connects the points; otherwise each stands for itself beside the
            diagonal.
        linear_below: The horizontal axis is logarithmic from here on, and linear below.
    """

    title: str
    curves: Mapping[str, Curve]
    axes: Mapping[str, Any] = field(default_factory=dict)
    level: float | None = None
    mark: float | None = None
    joined: bool = True
    linear_below: float | None = None


def panels_figure(
    panels: Sequence[Panel],
    *,
    size: tuple[float, float] = (5.2, 4.0),
    rows: int = 1,
    legend: str = "first",
    share_y: bool = False,
) -> Figure:
    """Returns a figure with the panels side by side.

    Args:
        panels: The panels, row by row.
        size: Of the figure, inches.
        rows: Rows of panels.
        legend: Where the one legend stands: in the `"first"` panel, `"below"` all, or `"right"`.
        share_y: Whether all panels have the same scale of values.
    """
    figure = Figure(figsize=size, layout="constrained")
    grid = figure.subplots(rows, -(-len(panels) // rows), sharey=share_y, squeeze=False)
    for axes, panel in zip(grid.flat, panels, strict=True):
        _draw(axes, panel)
    first = figure.axes[0]
    if legend == "first":
        first.legend(fontsize=8)
    else:
        place = {"below": "outside lower center", "right": "outside right center"}[legend]
        names = first.get_legend_handles_labels()
        figure.legend(*names, loc=place, ncols=4 if legend == "below" else 1)
    return figure


def _draw(axes: Axes, panel: Panel) -> None:
    for name, curve in panel.curves.items():
        if not curve.points:
            continue
        x, value, low, high = zip(*curve.points, strict=True)
        style = {"ls": "" if not panel.joined else "-"} | dict(curve.style)
        drawn = axes.plot(x, value, marker="o", ms=3.5, label=name, **style)
        colour = drawn[0].get_color()
        if panel.joined:
            axes.fill_between(x, low, high, alpha=0.2, color=colour, lw=0)
        else:
            axes.vlines(x, low, high, color=colour, lw=0.8)
    if not panel.joined:
        axes.axline((0, 0), slope=1, color="0.4", lw=0.8, ls=":")
    if panel.level is not None:
        axes.axhline(panel.level, color="0.4", lw=0.8, ls=":")
    if panel.mark is not None:
        axes.axvline(panel.mark, color="0.4", lw=0.8, ls=":")
    axes.set(title=panel.title, **panel.axes)
    if panel.linear_below is not None:
        axes.set_xscale("symlog", linthresh=panel.linear_below)
        axes.set_xlim(left=-panel.linear_below / 2)


def bars_figure(names: Sequence[str], panels: Mapping[str, Sequence[Point | None]]) -> Figure:
    """Returns a figure with a line for each name and a panel for each measure.

    Args:
        names: What the lines are called, from the top.
        panels: {title: a point for each name, or None}; x is not used.
    """
    size = (1.5 + 3 * len(panels), 1.2 + 0.26 * len(names))
    figure = Figure(figsize=size, layout="constrained")
    grid = figure.subplots(1, len(panels), sharey=True, squeeze=False)[0]
    for axes, (title, points) in zip(grid, panels.items(), strict=True):
        for place, point in enumerate(points):
            if point is not None:
                _, value, low, high = point
                axes.hlines(place, low, high, color="tab:blue")
                axes.plot(value, place, "o", ms=4, color="tab:blue")
        axes.set(title=title, yticks=range(len(names)), yticklabels=names)
        axes.grid(axis="y", lw=0.4)
    figure.axes[0].invert_yaxis()
    return figure
