"""Moving pictures of agents on their way."""

from collections.abc import Sequence
from typing import Any

import numpy as np
from jaxtyping import Float
from matplotlib.animation import FuncAnimation
from matplotlib.axes import Axes
from matplotlib.collections import LineCollection

from motorspace._types import Pose
from motorspace.reports.figures.answers import draw_pose
from motorspace.reports.figures.style import SERIES, ink, new_figure, styled
from motorspace.reports.figures.worlds import draw_world
from motorspace.worlds.sensors.base import AbstractSensor
from motorspace.worlds.world import AbstractWorld

MILLISECONDS = 150
"""For which a frame is shown."""
RESTING = 10
"""Frames for which the end stays."""


@styled
def ways_film(
    world: AbstractWorld,
    paths: Sequence[Pose],
    goal: Float[np.ndarray, "3"] | None = None,
    sensor: AbstractSensor[Any] | None = None,
) -> FuncAnimation:
    """Returns a moving picture of agents that act side by side, a command in every frame.

    Args:
        world: Where they act.
        paths: One batch of poses for each agent, in order of time.
        goal: Where they should end (x, y, heading), if there is such a place.
        sensor: Their sensor; without one, no rays are drawn.

    Returns:
        The film; `film.save("film.gif", writer="pillow")` writes it.
    """
    figure = new_figure(4.4, 4.4)
    axes = figure.add_subplot()
    last = max(len(path.x) for path in paths) - 1

    @styled
    def draw(moment: int) -> None:
        axes.clear()
        draw_world(axes, world)
        if goal is not None:
            axes.scatter(
                goal[0], goal[1], s=220, facecolors="none", edgecolors=ink("text"), zorder=4
            )
            draw_pose(axes, tuple(goal), ink("text"))
        for index, path in enumerate(paths):
            if sensor is not None:
                _draw_rays(axes, sensor.rays(world, _at(path, moment)))
            _draw_way(axes, path, moment, SERIES[index % len(SERIES)])
        axes.set(xticks=[], yticks=[], title=f"{min(moment, last)} commands")

    frames = range(last + 1 + RESTING)
    return FuncAnimation(figure, draw, frames, init_func=lambda: None, interval=MILLISECONDS)


def _at(path: Pose, moment: int) -> Pose:
    """The pose at a moment, and the last one from then on."""
    index = min(moment, len(path.x) - 1)
    return Pose(path.x[index], path.y[index], path.heading[index], path.head[index])


def _draw_rays(axes: Axes, rays: Float[np.ndarray, "R 2 2"]) -> None:
    axes.add_collection(LineCollection(list(rays), colors=SERIES[1], linewidths=0.6))


def _draw_way(axes: Axes, path: Pose, moment: int, colour: str) -> None:
    axes.plot(path.x[: moment + 1], path.y[: moment + 1], color=colour, lw=1.3, alpha=0.8)
    here = _at(path, moment)
    axes.scatter([float(here.x)], [float(here.y)], s=40, color=colour, zorder=5, linewidths=0)
    draw_pose(axes, (float(here.x), float(here.y), float(here.gaze)), colour, length=1.2)
