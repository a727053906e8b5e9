"""Pictures of worlds, of what agents sense there, and of where they go."""

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.collections import LineCollection, PolyCollection
from matplotlib.figure import Figure

from motorspace._types import Pose
from motorspace.reports.figures.style import SERIES, ink, new_figure, styled
from motorspace.worlds.layouts import Layout
from motorspace.worlds.sensors.base import AbstractSensor
from motorspace.worlds.world import AbstractWorld


@styled
def world_figure(
    world: AbstractWorld, poses: Sequence[Pose] = (), sensor: AbstractSensor[Any] | None = None
) -> Figure:
    """Returns a picture of a world, with agents and what their sensor's rays meet.

    Args:
        world: The world.
        poses: Where agents stand.
        sensor: Their sensor; without one, no rays are drawn.
    """
    figure = new_figure(6, 6)
    axes = figure.add_subplot()
    draw_world(axes, world)
    for pose in poses:
        rays = np.zeros((0, 2, 2)) if sensor is None else sensor.rays(world, pose)
        axes.add_collection(LineCollection(list(rays), colors=SERIES[1], linewidths=0.9))
        axes.scatter(rays[:, 1, 0], rays[:, 1, 1], s=10, color=SERIES[1], zorder=3, linewidths=0)
        x, y, gaze = float(pose.x), float(pose.y), float(pose.gaze)
        axes.scatter([x], [y], s=55, color=SERIES[0], zorder=4, linewidths=0)
        axes.plot([x, x + np.cos(gaze)], [y, y + np.sin(gaze)], color=ink("text"), zorder=5)
    return figure


@styled
def layout_figure(layout: Layout) -> Figure:
    """Returns a picture of a layout: walls, and in colour what nothing stands in.

    Args:
        layout: The layout; no world is built of it.
    """
    x_low, y_low, x_high, y_high = layout.bounds
    height = 8 * min(max((y_high - y_low) / (x_high - x_low), 0.4), 2.0)
    figure = new_figure(8, height)
    axes = figure.add_subplot()
    axes.add_collection(
        PolyCollection([np.array(s) for s in layout.solids], facecolors=ink("pane"), linewidths=0)
    )
    axes.add_collection(LineCollection(layout.segments()[0], colors=ink("text"), linewidths=0.8))
    axes.set(xlim=(x_low, x_high), ylim=(y_low, y_high), aspect="equal", title=layout.title)
    return figure


@styled
def trajectories_figure(world: AbstractWorld, paths: Sequence[Pose]) -> Figure:
    """Returns a picture of trajectories: the position and the gaze at every step.

    Args:
        world: Where they happen.
        paths: One batch of poses for each trajectory, in order of time.
    """
    figure = new_figure(6, 6)
    axes = figure.add_subplot()
    draw_world(axes, world)
    for index, path in enumerate(paths):
        x, y, gaze = np.asarray(path.x), np.asarray(path.y), np.asarray(path.gaze)
        colour = SERIES[index % len(SERIES)]
        axes.plot(x, y, color=colour, lw=1.3)
        axes.scatter(x[:1], y[:1], s=26, color=colour, linewidths=0)
        arrows = (np.cos(gaze), np.sin(gaze))
        # Half a world unit each, so that hardly one reaches through a wall that no agent crosses.
        axes.quiver(
            x, y, *arrows, color=colour, angles="xy", scale_units="xy", scale=2, width=0.003
        )
    return figure


@styled
def layouts_figure(worlds: Mapping[str, AbstractWorld]) -> Figure:
    """Returns a picture of worlds side by side, each under its name."""
    figure = new_figure(3.1 * len(worlds), 3.3)
    panels = figure.subplots(1, len(worlds), squeeze=False)[0]
    for axes, (name, world) in zip(panels, worlds.items(), strict=True):
        draw_world(axes, world)
        axes.set(title=name, xticks=[], yticks=[])
    return figure


def draw_world(axes: Axes, world: AbstractWorld) -> None:
    """Draw the walls, obstacles and nodes of a world."""
    drawing = world.drawing()
    x_low, y_low, x_high, y_high = drawing.bounds
    axes.add_collection(LineCollection(list(drawing.lines), colors=ink("text"), linewidths=1.8))
    if len(drawing.points):
        axes.scatter(drawing.points[:, 0], drawing.points[:, 1], s=12, color=ink("text"))
    for corners in drawing.solids:
        axes.fill(*corners.T, color=ink("grid"))
    margin = 0.02 * (x_high - x_low)
    axes.set(
        xlim=(x_low - margin, x_high + margin),
        ylim=(y_low - margin, y_high + margin),
        aspect="equal",
    )
    axes.grid(False)
    axes.spines[:].set_visible(False)
