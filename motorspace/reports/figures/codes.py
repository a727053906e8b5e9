"""Pictures of codes, coloured by the displacements that belong to them."""

from collections.abc import Sequence
from typing import Any

import numpy as np
from jaxtyping import Bool, Float
from matplotlib.colors import Colormap
from matplotlib.figure import Figure

from motorspace.reports.figures.style import CYCLIC, UNIFORM, ink, new_figure, styled

Numbers = Float[np.ndarray, "N _"]
COMPONENTS = ("longitudinal displacement", "lateral displacement", "orientation change")
UNITS = ("world units", "world units", "radians")
Colours = Sequence[str | Colormap]


@styled
def codes_figure(
    rows: Sequence[tuple[str, Numbers, Numbers]],
    *,
    colours: Colours = UNIFORM,
    axis_name: str = "PC",
) -> Figure:
    """Returns codes in three dimensions: a row of panels per run, a panel per component.

    As in the paper most points are transparent; opaque are those in five narrow ranges of the
    component shown, spread evenly over it.

    Args:
        rows: (title, coordinates [N, P], displacements [N, 3]) of each run. The first three
            coordinates are shown; missing ones are 0.
        colours: A colour map for each component; `style.JET` for those of the paper.
        axis_name: What the coordinates are called: PC for principal components.
    """
    figure = new_figure(12, 3.5 * len(rows))
    for row, (title, coordinates, displacements) in enumerate(rows):
        points, moved = three_columns(coordinates), np.asarray(displacements)
        for column, name in enumerate(COMPONENTS):
            axes: Any = figure.add_subplot(len(rows), 3, 3 * row + column + 1, projection="3d")
            shown = _scatter(axes, points, moved[:, column], colours[column])
            bar = figure.colorbar(shown, ax=axes, shrink=0.6, pad=0.13, label=UNITS[column])
            bar.outline.set_visible(False)
            if (ticks := angle_ticks(shown.get_clim())) and colours[column] is CYCLIC:
                bar.set_ticks([*ticks], labels=[*ticks.values()])
            axes.set_title("\n".join(part for part in (title, name) if part))
            _bare(axes, axis_name)
    return figure


@styled
def lattice_figure(
    rows: Sequence[tuple[str, Numbers, Numbers]], *, colours: str | Colormap = "viridis"
) -> Figure:
    """Returns lattice codes on two coordinates: a row per model, a panel per translation.

    Args:
        rows: (title, coordinates [N, P], displacements [N, 3]) of each run.
        colours: The colour map.
    """
    figure = new_figure(9, 4 * len(rows))
    grid = figure.subplots(len(rows), 2, squeeze=False)
    for panels, (title, coordinates, displacements) in zip(grid, rows, strict=True):
        x, y, _ = three_columns(coordinates).T
        for column, axes in enumerate(panels):
            value = np.asarray(displacements)[:, column]
            shown = axes.scatter(x, y, c=value, cmap=colours, s=10, linewidths=0)
            figure.colorbar(shown, ax=axes, label=UNITS[column])
            axes.set(title=f"{title}\n{COMPONENTS[column]}", xlabel="PC 1", ylabel="PC 2")
    return figure


def three_columns(coordinates: Numbers) -> Float[np.ndarray, "N 3"]:
    """Returns the first three coordinates of each point, 0 where there are fewer."""
    points = np.asarray(coordinates, np.float64).reshape(len(coordinates), -1)[:, :3]
    return np.pad(points, ((0, 0), (0, 3 - points.shape[1])))


def colour_scale(value: Float[np.ndarray, " N"], colours: str | Colormap) -> dict[str, Any]:
    """Returns the colour map of a component and its ends: a full circle for a cyclic map.

    Angles within a quarter turn either way do not close: they get an open map.
    """
    if colours is not CYCLIC:
        return {"cmap": colours, "vmin": float(value.min()), "vmax": float(value.max())}
    if np.abs(value).max() < np.pi / 2:
        return colour_scale(value, "viridis")
    return {"cmap": colours, "vmin": -np.pi, "vmax": np.pi}


def angle_ticks(limits: tuple[float, float]) -> dict[float, str]:
    """Returns what is written on a scale of a full circle, and nothing for other scales."""
    if limits != (-np.pi, np.pi):
        return {}
    return {-np.pi: "-π", -np.pi / 2: "-π/2", 0.0: "0", np.pi / 2: "π/2", np.pi: "π"}


def _scatter(
    axes: Any,
    points: Float[np.ndarray, "N 3"],
    value: Float[np.ndarray, " N"],
    colours: str | Colormap,
) -> Any:
    if colours is CYCLIC:
        value = (value + np.pi) % (2 * np.pi) - np.pi
    style = colour_scale(value, colours) | {"linewidths": 0, "depthshade": False}
    chosen = _in_bands(value)
    axes.scatter(*points[~chosen].T, c=value[~chosen], s=4, alpha=0.15, **style)
    return axes.scatter(*points[chosen].T, c=value[chosen], s=9, **style)


def _in_bands(value: Float[np.ndarray, " N"]) -> Bool[np.ndarray, " N"]:
    """The points to draw opaque: a few narrow ranges of one component."""
    low, high = np.percentile(value, [2, 98])
    width = (high - low) / 40
    near = [np.abs(value - level) <= width for level in np.linspace(low, high, 5)]
    return np.any(near, axis=0)


def _bare(axes: Any, name: str) -> None:
    """Panes of the theme, and axes with names alone."""
    for pane in (axes.xaxis, axes.yaxis, axes.zaxis):
        pane.set_pane_color(ink("pane"))
    axes.grid(False)
    axes.set_box_aspect((1, 1, 1), zoom=0.95)
    for axis, number in zip("xyz", (1, 2, 3), strict=True):
        getattr(axes, f"set_{axis}label")(f"{name} {number}", labelpad=-10)
        getattr(axes, f"set_{axis}ticks")([])
