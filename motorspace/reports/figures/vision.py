"""Pictures of what eyes see."""

from collections.abc import Sequence

import jax.numpy as jnp
import numpy as np
from matplotlib.axes import Axes
from matplotlib.collections import LineCollection
from matplotlib.figure import Figure

from motorspace._types import Pose
from motorspace.reports.figures.style import SERIES, ink, new_figure, styled
from motorspace.reports.figures.worlds import draw_world
from motorspace.worlds.sensors.retina import Retina
from motorspace.worlds.world import WalledWorld

PIECE = 0.1
"""Length of the pieces that walls are drawn in, world units: no texture changes within one."""


@styled
def view_figure(world: WalledWorld, poses: Sequence[Pose], retina: Retina) -> Figure:
    """Returns a picture of a painted world with agents in it, and of the strip that each one sees.

    Args:
        world: The world; its walls are painted.
        poses: Where agents stand, one to six.
        retina: Their eyes. A strip shows what is to the left on the left.
    """
    figure = new_figure(6, 6 + 0.5 * len(poses))
    rows = figure.add_gridspec(1 + len(poses), 1, height_ratios=[6.0, *[0.3] * len(poses)])
    axes = figure.add_subplot(rows[0])
    draw_painted(axes, world)
    for number, pose in enumerate(poses):
        colour = SERIES[number % len(SERIES)]
        edges = retina.rays(world, pose)[[0, -1]]
        axes.add_collection(LineCollection(list(edges), colors=colour, linewidths=1.0))
        x, y, gaze = float(pose.x), float(pose.y), float(pose.gaze)
        axes.scatter([x], [y], s=70, color=colour, zorder=4, linewidths=0)
        axes.plot([x, x + 1.5 * np.cos(gaze)], [y, y + 1.5 * np.sin(gaze)], color=ink("text"))
        strip = figure.add_subplot(rows[1 + number])
        pixels = np.asarray(retina.sense(world, pose)).reshape(1, -1, 3)
        strip.imshow((pixels[:, ::-1] + 1) / 2, aspect="auto", interpolation="nearest")
        strip.set(xticks=[], yticks=[])
        strip.grid(False)
        strip.spines[:].set(visible=True, color=colour, linewidth=2)
    return figure


def draw_painted(axes: Axes, world: WalledWorld) -> None:
    """Draw a world with its walls in their colours."""
    draw_world(axes, world)
    assert world.coat is not None, "eyes have looked at it"
    for number, (start, end) in enumerate(np.asarray(world.walls)):
        pieces = max(1, round(float(np.linalg.norm(end - start)) / PIECE))
        ends = start + np.linspace(0, 1, pieces + 1)[:, None] * (end - start)
        x, y = jnp.asarray(((ends[:-1] + ends[1:]) / 2).T, jnp.float32)
        colours = np.asarray(world.coat.colours(jnp.full(pieces, number), x, y))
        lines = np.stack([ends[:-1], ends[1:]], axis=1)
        axes.add_collection(
            LineCollection(
                list(lines), colors=colours, linewidths=4.0, antialiaseds=False, zorder=3
            )
        )
