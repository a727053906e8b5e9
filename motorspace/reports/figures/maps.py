"""Pictures of maps that were put together from readings."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from jaxtyping import Bool, Float
from matplotlib.collections import LineCollection
from matplotlib.colors import ListedColormap
from matplotlib.figure import Figure

from motorspace.reports.figures.style import SERIES, ink, new_figure, styled
from motorspace.reports.tables import Row, interval_of


@dataclass(frozen=True)
class MapPanel:
    """One drawing of readings."""

    title: str
    occupied: Bool[np.ndarray, "W H"]
    """The cells that hold something."""
    seen: Bool[np.ndarray, "W H"]
    """The cells that rays have reached."""
    low: Float[np.ndarray, "2"]
    """Corner of the first cell."""
    cell: float
    """Side of a cell, world units."""
    path: Float[np.ndarray, "2 N"] | None = None
    """Where the readings were taken."""
    loops: Float[np.ndarray, "L 2 2"] | None = None
    """Pairs of places that were recognised as one another."""


@styled
def map_figure(panels: Sequence[MapPanel]) -> Figure:
    """Returns a picture of maps side by side: cells that hold something, and the way between.

    Args:
        panels: The maps; empty cells are pale, cells that were never seen are left blank.
    """
    width, height = panels[0].occupied.shape
    tall = min(max(height / width, 0.35), 1.6)
    side = max(5.6, 8 / len(panels))
    figure = new_figure(side * len(panels), side * tall + 0.5)
    for axes, panel in zip(figure.subplots(1, len(panels), squeeze=False)[0], panels, strict=True):
        cells = np.where(panel.occupied, 2, panel.seen.astype(int)).T
        x, y = panel.low
        extent = (
            x,
            x + panel.cell * panel.occupied.shape[0],
            y,
            y + panel.cell * panel.occupied.shape[1],
        )
        colours = ListedColormap([ink("page"), ink("pane"), ink("text")])
        axes.imshow(cells, origin="lower", extent=extent, cmap=colours, vmin=0, vmax=2)
        if panel.loops is not None:
            axes.add_collection(LineCollection(list(panel.loops), colors=SERIES[1], lw=0.6))
        if panel.path is not None:
            axes.plot(*panel.path, color=SERIES[0], lw=0.8)
        axes.set(aspect="equal", title=panel.title)
        axes.grid(False)
    return figure


@styled
def paths_figure(paths: dict[str, Float[np.ndarray, "2 N"]]) -> Figure:
    """Returns a picture of paths of one walk, each under its name."""
    wide, tall = np.ptp(np.concatenate([*paths.values()], axis=1), axis=1)
    figure = new_figure(7.5, 7.5 * min(max(tall / max(wide, 1e-9), 0.35), 1.2) + 0.6)
    axes = figure.add_subplot()
    for (name, path), colour in zip(paths.items(), SERIES, strict=False):
        axes.plot(*path, color=colour, lw=1.2, label=name)
    x, y = next(iter(paths.values()))[:, :1]
    axes.scatter(x, y, s=40, color=ink("text"), zorder=4, linewidths=0)
    axes.set(aspect="equal", xlabel="x (world units)", ylabel="y (world units)")
    axes.legend()
    return figure


@styled
def errors_figure(errors: Mapping[str, Row], *, unit: str = "world units") -> Figure:
    """Returns a picture of how far off paths are, on a logarithmic scale.

    Args:
        errors: {walk: {path: its absolute error, or mean and interval}}; a row for each walk.
        unit: What errors are measured in.
    """
    paths = list(dict.fromkeys(path for found in errors.values() for path in found))
    figure = new_figure(7.5, 1.1 + 0.5 * len(errors))
    axes = figure.add_subplot()
    for path, colour in zip(paths, SERIES, strict=False):
        known = [(row, interval_of(found.get(path))) for row, found in enumerate(errors.values())]
        for row, interval in known:
            if interval is not None:
                axes.plot([interval.low, interval.high], [row, row], color=colour, lw=2)
                axes.plot(interval.mean, row, "o", color=colour)
        axes.plot([], [], "o", color=colour, label=path)
    axes.set(xscale="log", xlabel=f"absolute error of the path ({unit})")
    axes.set_yticks(range(len(errors)), list(errors))
    axes.set_ylim(len(errors) - 0.5, -0.5)
    figure.legend(loc="outside upper center", ncols=len(paths))
    return figure
