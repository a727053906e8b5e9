"""Pictures of plans: many motor sequences that lead to one goal."""

import numpy as np
from jaxtyping import Float
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from motorspace.reports.figures.style import SERIES, ink, new_figure, styled

ARROW = 0.35
"""Length of the arrows that show where an agent faces, world units."""


@styled
def answers_figure(
    paths: Float[np.ndarray, "N L 3"], goal: Float[np.ndarray, "3"] | None = None
) -> Figure:
    """Returns a picture of ways from one place, and of where they should lead.

    Args:
        paths: N ways of L poses (x, y, angle) in the frame of their start, [N, L, 3]; world units,
            radians.
        goal: The displacement wanted (longitudinal, lateral, turn), if there is one.
    """
    figure = new_figure(5.5, 5)
    axes = figure.add_subplot()
    for index, path in enumerate(np.asarray(paths, float)):
        x, y, angle = path.T
        colour = SERIES[index % len(SERIES)]
        axes.plot(x, y, color=colour, lw=1.2, alpha=0.8, marker="o", ms=3)
        draw_pose(axes, (x[-1], y[-1], angle[-1]), colour)
    draw_pose(axes, (0.0, 0.0, 0.0), ink("text"))
    if goal is not None:
        axes.scatter(goal[0], goal[1], s=220, facecolors="none", edgecolors=ink("text"), zorder=4)
        draw_pose(axes, tuple(goal), ink("text"))
    axes.set(aspect="equal", xlabel="ahead, world units", ylabel="to the left, world units")
    return figure


def draw_pose(axes: Axes, pose: tuple[float, ...], colour: str, length: float = ARROW) -> None:
    """Draw an arrow from a position (x, y) in the direction of an angle."""
    x, y, angle = pose
    axes.annotate(
        "",
        xy=(x + length * np.cos(angle), y + length * np.sin(angle)),
        xytext=(x, y),
        arrowprops={"arrowstyle": "-|>", "color": colour, "lw": 1.4},
        zorder=5,
    )
