"""Every picture: data in, a matplotlib figure out. Nothing here computes a result."""

import io
from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
from jaxtyping import Bool, Float
from matplotlib.axes import Axes
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.collections import LineCollection
from matplotlib.figure import Figure

from motorspace._types import Pose
from motorspace.worlds.sensors.range_fan import RangeFan
from motorspace.worlds.world import WalledWorld

Numbers = Float[np.ndarray, "N ..."]
COMPONENTS = ("longitudinal displacement", "lateral displacement", "orientation change")
PAPER_COLOURS = ("jet", "jet", "jet")
UNIFORM_COLOURS = ("viridis", "viridis", "twilight")
"""A perceptually uniform choice; orientation gets a cyclic one."""
PANE_COLOUR = (0.86, 0.86, 0.86)
"""Behind the codes: no colour map in use has it."""


def png(figure: Figure, *, dots_per_inch: int = 100) -> bytes:
    """The figure as a PNG file."""
    FigureCanvasAgg(figure)
    buffer = io.BytesIO()
    figure.savefig(buffer, format="png", dpi=dots_per_inch)
    return buffer.getvalue()


def environment_figure(
    world: WalledWorld, poses: Sequence[Pose] = (), fan: RangeFan | None = None
) -> Figure:
    """The walls, and agents with their rays where given."""
    figure = Figure(figsize=(5.5, 5.5), layout="constrained")
    axes = figure.add_subplot()
    _walls(axes, world)
    for pose in poses:
        x, y, gaze = float(pose.x), float(pose.y), float(pose.gaze)
        if fan is not None:
            half = fan.field_of_view / 2
            angles = gaze + np.linspace(-half, half, fan.num_rays)
            ranges = np.asarray(fan.sense(world, pose))[: fan.num_rays]
            ends = np.stack([x + ranges * np.cos(angles), y + ranges * np.sin(angles)], -1)
            rays = [[(x, y), tuple(end)] for end in ends]
            axes.add_collection(LineCollection(rays, colors="tab:orange", linewidths=0.8))
            axes.scatter(ends[:, 0], ends[:, 1], s=8, color="tab:orange", zorder=3)
        axes.scatter([x], [y], s=45, color="tab:blue", zorder=4)
        axes.plot([x, x + np.cos(gaze)], [y, y + np.sin(gaze)], color="black", lw=1.5, zorder=5)
    return figure


def trajectories_figure(world: WalledWorld, paths: Sequence[Pose]) -> Figure:
    """Example trajectories: positions along each, and the gaze at every step."""
    figure = Figure(figsize=(5.5, 5.5), layout="constrained")
    axes = figure.add_subplot()
    _walls(axes, world)
    for index, path in enumerate(paths):
        x, y, gaze = np.asarray(path.x), np.asarray(path.y), np.asarray(path.gaze)
        colour = f"C{index % 10}"
        axes.plot(x, y, color=colour, lw=1.2)
        axes.scatter(x[:1], y[:1], s=22, color=colour)
        arrows = (np.cos(gaze), np.sin(gaze))
        # Half a world unit each, so that hardly one reaches through a wall that no agent crosses.
        axes.quiver(
            x, y, *arrows, color=colour, angles="xy", scale_units="xy", scale=2, width=0.003
        )
    return figure


def layouts_figure(worlds: Mapping[str, WalledWorld]) -> Figure:
    """Every layout, side by side."""
    figure = Figure(figsize=(3.1 * len(worlds), 3.3), layout="constrained")
    for axes, (name, world) in zip(
        figure.subplots(1, len(worlds), squeeze=False)[0], worlds.items(), strict=True
    ):
        _walls(axes, world)
        axes.set_title(name)
        axes.set_xticks([])
        axes.set_yticks([])
    return figure


def codes_figure(
    rows: Sequence[tuple[str, Numbers, Numbers]],
    *,
    colours: Sequence[str] = PAPER_COLOURS,
    axis_name: str = "PC",
) -> Figure:
    """Codes in three dimensions, once per displacement component, one row per run.

    `rows` holds (title, coordinates [N, 3], displacements [N, 3]). As in the paper most points
    are transparent; opaque are those in five narrow ranges of the component shown, spread
    evenly over it.
    """
    figure = Figure(figsize=(12, 3.9 * len(rows)), layout="constrained")
    for row, (title, coordinates, displacements) in enumerate(rows):
        for column, name in enumerate(COMPONENTS):
            axes: Any = figure.add_subplot(len(rows), 3, 3 * row + column + 1, projection="3d")
            value = np.asarray(displacements)[:, column]
            chosen = _chosen(np.asarray(displacements), column)
            low, high = float(value.min()), float(value.max())
            style = {"cmap": colours[column], "vmin": low, "vmax": high, "linewidths": 0}
            style["depthshade"] = False
            faint, strong = coordinates[~chosen], coordinates[chosen]
            axes.scatter(*faint.T, c=value[~chosen], s=4, alpha=0.15, **style)
            shown = axes.scatter(*strong.T, c=value[chosen], s=9, alpha=1.0, **style)
            figure.colorbar(shown, ax=axes, shrink=0.6, pad=0.08)
            axes.set_title(f"{title}\n{name}", fontsize=10)
            for pane in (axes.xaxis, axes.yaxis, axes.zaxis):
                pane.set_pane_color(PANE_COLOUR)
            for axis, number in zip("xyz", (1, 2, 3), strict=True):
                getattr(axes, f"set_{axis}label")(f"{axis_name} {number}", labelpad=-10)
                getattr(axes, f"set_{axis}ticks")([])
    return figure


def lattice_figure(rows: Sequence[tuple[str, Numbers, Numbers]], *, colours: str = "jet") -> Figure:
    """Lattice codes on two components: a row per model, a column per displacement."""
    figure = Figure(figsize=(9, 4 * len(rows)), layout="constrained")
    grid = figure.subplots(len(rows), 2, squeeze=False)
    for panels, (title, coordinates, displacements) in zip(grid, rows, strict=True):
        for column, axes in enumerate(panels):
            value = np.asarray(displacements)[:, column]
            shown = axes.scatter(*coordinates[:, :2].T, c=value, cmap=colours, s=10, linewidths=0)
            figure.colorbar(shown, ax=axes)
            axes.set(title=f"{title}\n{COMPONENTS[column]}", xlabel="PC 1", ylabel="PC 2")
    return figure


def learning_curve_figure(
    curves: Mapping[str, Numbers], references: Mapping[str, float] = {}
) -> Figure:
    """Error over epochs on a logarithmic scale, with constant reference lines."""
    figure = Figure(figsize=(6.5, 4), layout="constrained")
    axes = figure.add_subplot()
    for index, (name, values) in enumerate(curves.items()):
        axes.plot(np.arange(1, len(values) + 1), values, label=name, color=f"C{index}", lw=1.3)
    for index, (name, level) in enumerate(references.items()):
        axes.axhline(level, label=name, color="0.35", linestyle=("--", ":", "-.")[index % 3])
    axes.set(xlabel="epoch", ylabel="mean squared error", yscale="log")
    axes.yaxis.set_major_formatter("{x:g}")
    axes.yaxis.set_minor_formatter("{x:g}")
    axes.legend()
    return figure


def _chosen(displacements: Numbers, column: int) -> Bool[np.ndarray, " N"]:
    """Points to draw opaque: a few narrow ranges of one component."""
    value = displacements[:, column]
    low, high = np.percentile(value, [2, 98])
    width = (high - low) / 40
    near = [np.abs(value - level) < width for level in np.linspace(low, high, 5)]
    return np.any(near, axis=0)


def _walls(axes: Axes, world: WalledWorld) -> None:
    x_low, y_low, x_high, y_high = world.bounds
    axes.add_collection(
        LineCollection(list(np.asarray(world.walls)), colors="0.15", linewidths=1.8)
    )
    solids = np.asarray(world.solids)
    start = 0
    for stop in range(1, len(solids) + 1):
        # A polygon's edges follow each other and end where they began.
        if np.array_equal(solids[stop - 1, 1], solids[start, 0]):
            axes.fill(*solids[start:stop, 0].T, color="0.75")
            start = stop
    margin = 0.02 * (x_high - x_low)
    axes.set(
        xlim=(x_low - margin, x_high + margin),
        ylim=(y_low - margin, y_high + margin),
        aspect="equal",
    )
