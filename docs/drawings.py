"""Draw the diagrams of the documentation: `python -m docs.drawings`."""

import io
import math
from collections.abc import Sequence
from pathlib import Path
from typing import NamedTuple

import matplotlib
import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.patches import Circle, FancyArrowPatch, FancyBboxPatch, Wedge

PICTURES = Path(__file__).parent / "pictures"

CARD, INK, FAINT = "#fbfaf7", "#1f2633", "#8b93a3"
BLUE, ORANGE, GREEN, PURPLE = "#3867b0", "#d07c1f", "#3d8f6a", "#7c5aa8"
STYLE = {
    "font.family": "DejaVu Sans",
    "font.size": 11,
    "text.color": INK,
    "axes.edgecolor": FAINT,
    "axes.labelcolor": INK,
    "xtick.color": FAINT,
    "ytick.color": FAINT,
    "mathtext.fontset": "dejavusans",
    # The same drawing gives the same bytes.
    "svg.hashsalt": "motorspace",
}


class Point(NamedTuple):
    """A place on a canvas, in its own units."""

    x: float
    y: float


def main() -> None:
    """Draw all of them."""
    drawn = {"system": system, "data": data, "frames": frames, "signal": signal}
    for name, draw in drawn.items():
        with matplotlib.rc_context(STYLE):
            (PICTURES / f"{name}.svg").write_bytes(svg(draw()))


def svg(figure: Figure) -> bytes:
    """The figure as an SVG file, without a word about when and by what it was made."""
    buffer = io.BytesIO()
    unsaid = dict.fromkeys(("Creator", "Date", "Format", "Type"))
    figure.savefig(buffer, format="svg", metadata=unsaid, facecolor=CARD)
    return buffer.getvalue()


def canvas(width: float, height: float) -> tuple[Figure, Axes]:
    """An empty card without axes, a hundred units to the inch.

    The card brings its own light background, so it reads the same on a dark page.
    """
    figure = Figure(figsize=(width / 100, height / 100), facecolor=CARD)
    axes = figure.add_axes((0, 0, 1, 1))
    axes.set(xlim=(0, width), ylim=(0, height), aspect="equal")
    axes.axis("off")
    return figure, axes


def box(
    axes: Axes,
    centre: Point,
    size: tuple[float, float],
    text: str,
    colour: str,
    *,
    fill: float = 0.12,
) -> None:
    """A rounded box with its label."""
    width, height = size
    corner = (centre.x - width / 2, centre.y - height / 2)
    style = "round,pad=0,rounding_size=8"
    for face, edge in (((colour, fill), "none"), ("none", colour)):
        axes.add_patch(
            FancyBboxPatch(
                corner, width, height, boxstyle=style, facecolor=face, edgecolor=edge, lw=1.6
            )
        )
    axes.text(*centre, text, ha="center", va="center", linespacing=1.35)


def arrow(
    axes: Axes,
    start: Point,
    end: Point,
    colour: str = INK,
    *,
    bend: float = 0.0,
    dashed: bool = False,
) -> None:
    """An arrow from one place to another; `bend` curves it."""
    axes.add_patch(
        FancyArrowPatch(
            start,
            end,
            arrowstyle="-|>,head_length=5,head_width=3",
            connectionstyle=f"arc3,rad={bend}",
            color=colour,
            lw=1.6,
            linestyle=(0, (4, 3)) if dashed else "-",
            shrinkA=0,
            shrinkB=0,
        )
    )


def fan(axes: Axes, centre: Point, ranges: Sequence[float], colour: str, *, gaze: float) -> None:
    """An agent with its rays, each as long as what it reads."""
    angles = gaze + np.linspace(-math.pi / 2, math.pi / 2, len(ranges))
    for angle, length in zip(angles, ranges, strict=True):
        end = centre.x + length * math.cos(angle), centre.y + length * math.sin(angle)
        axes.plot([centre.x, end[0]], [centre.y, end[1]], color=colour, lw=1.1)
        axes.add_patch(Circle(end, 1.8, facecolor=colour, edgecolor="none"))
    axes.add_patch(Circle(centre, 6, facecolor=INK, edgecolor="none", zorder=3))


def system() -> Figure:
    """Commands to encoder to code; code and sensors to predictor to later sensors; the loss."""
    figure, axes = canvas(1000, 420)
    _encoder(axes)
    box(axes, Point(515, 245), (72, 60), "$h^m$", PURPLE, fill=0.28)
    axes.text(515, 192, "code", ha="center", color=PURPLE, weight="bold")
    axes.text(515, 171, "learns the displacement", ha="center", color=FAINT, fontsize=10)
    arrow(axes, Point(428, 245), Point(478, 245))

    box(axes, Point(650, 245), (96, 60), "MLP", GREEN, fill=0.28)
    axes.text(674, 192, "predictor", color=GREEN, weight="bold")
    arrow(axes, Point(552, 245), Point(601, 245))
    box(axes, Point(780, 245), (88, 52), "$\\hat{s}_{t+T}$", ORANGE)
    axes.text(780, 286, "prediction", ha="center", color=ORANGE, weight="bold")
    arrow(axes, Point(699, 245), Point(735, 245))
    box(axes, Point(920, 245), (110, 60), "loss\n$|\\hat{s} - s|^2$", INK, fill=0.06)
    arrow(axes, Point(825, 245), Point(864, 245))

    fan(axes, Point(130, 62), (26, 38, 52, 60, 46, 40, 58, 44, 30), ORANGE, gaze=0.3)
    axes.text(215, 84, "sensors now", color=ORANGE, weight="bold", va="center")
    axes.text(215, 60, "$s_t$: distances along nine rays", va="center", fontsize=10, color=FAINT)
    axes.plot([440, 662], [72, 72], color=INK, lw=1.6, solid_capstyle="butt")
    arrow(axes, Point(662, 72), Point(662, 214))
    fan(axes, Point(850, 62), (44, 30, 34, 50, 58, 48, 30, 26, 40), ORANGE, gaze=1.9)
    axes.text(782, 84, "sensors later", color=ORANGE, weight="bold", va="center", ha="right")
    axes.text(782, 60, "$s_{t+T}$", va="center", ha="right", fontsize=10, color=FAINT)
    arrow(axes, Point(920, 96), Point(920, 214))

    for x, low in ((920, 276), (650, 278), (240, 312)):
        axes.plot(
            [x, x], [low, 384] if x > 240 else [372, 384], color=FAINT, lw=1.2, ls=(0, (4, 3))
        )
    axes.plot([240, 920], [384, 384], color=FAINT, lw=1.2, ls=(0, (4, 3)))
    for x, tip in ((650, 277), (240, 366)):
        arrow(axes, Point(x, tip + 14), Point(x, tip), FAINT)
    text = "gradients of the prediction error train both networks"
    axes.text(590, 394, text, ha="center", color=FAINT, fontsize=10)
    return figure


def _encoder(axes: Axes) -> None:
    """The recurrence, unrolled over the commands."""
    for x, name in ((90, "t+1"), (190, "t+2"), (390, "t+T")):
        box(axes, Point(x, 320), (76, 40), f"$m_{{{name}}}$", BLUE)
        box(axes, Point(x, 245), (76, 52), "LSTM", BLUE, fill=0.28)
        arrow(axes, Point(x, 300), Point(x, 272))
    for y in (320, 245):
        axes.text(290, y, "$\\cdots$", ha="center", va="center", fontsize=16)
    for left, right in ((128, 151), (228, 268), (312, 351)):
        arrow(axes, Point(left, 245), Point(right, 245))
    axes.text(240, 350, "motor commands", ha="center", color=BLUE, weight="bold")
    axes.text(240, 192, "encoder", ha="center", color=BLUE, weight="bold")


FLOORS = (
    (("worlds", "walls, agents, sensors; the one step of time", BLUE),),
    (("trajectories", "transitions $(s_t, m, s_{t+T})$, sampling", BLUE),),
    (("recordings", "walks, simulated or read from a robot's log", BLUE),),
    (
        ("models", "encoders, losses", PURPLE),
        ("analysis", "measures of codes", GREEN),
        ("reports", "figures, tables", GREEN),
    ),
    (("training", "configuration, the loop, the folder of a run", PURPLE),),
    (("evaluation", "errors, structure of codes", GREEN),),
    (("mapping", "odometry of codes, a map of one walk", PURPLE),),
    (("judge", "a map of its own, and what it says of commands", PURPLE),),
    (
        ("environments", "Gymnasium", ORANGE),
        ("control", "goals, plans", ORANGE),
        ("export", "arrays, ONNX", ORANGE),
    ),
    (("navigation", "tasks, planner, policies", ORANGE),),
    (("running", "jobs, executors, sweeps", FAINT),),
    (("studies", "one file per question", FAINT),),
    (("cli", "one file per family of commands", FAINT),),
)
"""The rooms, lowest first: none imports from a floor above its own."""


def data() -> Figure:
    """The import order: data flows up, imports point down."""
    height = 68 * len(FLOORS) + 28
    figure, axes = canvas(820, height)
    for floor, rooms in enumerate(FLOORS):
        y, width = 46 + 68 * floor, 660 / len(rooms) - 10
        for place, (name, text, colour) in enumerate(rooms):
            x = 85 + 660 / len(rooms) * (place + 0.5)
            box(axes, Point(x, y), (width, 54), "", colour)
            axes.text(x, y + 10, name, ha="center", va="center", weight="bold", fontsize=10.5)
            axes.text(x, y - 11, text, ha="center", va="center", fontsize=9)
    ways = (45, 20, height - 28, BLUE, "data"), (780, height - 28, 20, FAINT, "imports")
    for x, low, high, colour, name in ways:
        arrow(axes, Point(x, low), Point(x, high), colour)
        axes.text(x, height - 14, name, color=colour, weight="bold", ha="center", va="center")
    return figure


def frames() -> Figure:
    """The angles of a pose, and the displacement from one pose to another."""
    figure, axes = canvas(1000, 370)
    _pose(axes, Point(190, 110))
    start, end = Point(580, 80), Point(760, 235)
    _body(axes, start, math.radians(20), BLUE)
    _body(axes, end, math.radians(100), PURPLE)
    ahead = np.array([math.cos(math.radians(20)), math.sin(math.radians(20))])
    side = np.array([-ahead[1], ahead[0]])
    gap = np.array(end) - np.array(start)
    corner = np.array(start) + ahead * (gap @ ahead)
    axes.plot(*zip(start, tuple(corner), strict=True), color=BLUE, lw=1.8)
    axes.plot(*zip(tuple(corner), end, strict=True), color=ORANGE, lw=1.8)
    axes.text(
        *(np.array(start) + ahead * (gap @ ahead) / 2 - side * 24),
        "longitudinal",
        color=BLUE,
        rotation=20,
        ha="center",
        va="center",
    )
    axes.text(
        *(corner + side * (gap @ side) / 2 + ahead * 14),
        "lateral",
        color=ORANGE,
        ha="left",
        va="center",
    )
    axes.add_patch(Wedge(end, 62, 20, 100, width=1.6, color=PURPLE))
    faint = np.array(end) + ahead * 84
    axes.plot(*zip(end, tuple(faint), strict=True), color=FAINT, lw=1.1, ls=(0, (4, 3)))
    axes.text(end.x + 60, end.y + 58, "orientation change", color=PURPLE, va="center")
    axes.text(560, 330, "a displacement, in the frame of the start", weight="bold")
    axes.text(start.x - 12, start.y - 40, "$t$", ha="center")
    axes.text(end.x - 34, end.y + 6, "$t+T$", ha="center")
    return figure


def _pose(axes: Axes, centre: Point) -> None:
    axes.text(60, 330, "a pose: x, y, heading, head", weight="bold")
    arrow(axes, Point(60, 60), Point(420, 60), FAINT)
    arrow(axes, Point(60, 60), Point(60, 300), FAINT)
    for x, y, name in ((424, 56, "x"), (54, 306, "y")):
        axes.text(x, y, name, color=FAINT)
    axes.plot([centre.x, centre.x + 150], [centre.y] * 2, color=FAINT, lw=1.1, ls=(0, (4, 3)))
    for angle, length, colour, name in ((25, 165, BLUE, "heading"), (65, 170, ORANGE, "gaze")):
        along = np.array([math.cos(math.radians(angle)), math.sin(math.radians(angle))])
        tip = np.array(centre) + along * length
        arrow(axes, centre, Point(*tip), colour)
        axes.text(*(tip + along * 8), name, color=colour, ha="left", va="bottom")
    axes.add_patch(Wedge(centre, 88, 0, 25, width=1.6, color=BLUE))
    axes.add_patch(Wedge(centre, 108, 25, 65, width=1.6, color=ORANGE))
    axes.text(centre.x + 96, centre.y + 8, "heading", fontsize=9, color=BLUE)
    axes.text(centre.x + 84, centre.y + 88, "head", fontsize=9, color=ORANGE)
    _body(axes, centre, math.radians(25), INK)


def _body(axes: Axes, centre: Point, heading: float, colour: str) -> None:
    axes.add_patch(Circle(centre, 15, facecolor=colour, edgecolor="none", zorder=3))
    tip = centre.x + 24 * math.cos(heading), centre.y + 24 * math.sin(heading)
    axes.plot([centre.x, tip[0]], [centre.y, tip[1]], color=colour, lw=5, solid_capstyle="round")


def signal() -> Figure:
    """|sin(r) / r|^(T - 1), the length of the mean unit vector after T - 1 turns up to r."""
    figure = Figure(figsize=(6.4, 3.6), layout="constrained", facecolor=CARD)
    axes = figure.add_subplot(facecolor=CARD)
    rotation = np.linspace(0.02, 1.2, 401)
    for horizon, colour in ((2, GREEN), (3, BLUE), (6, PURPLE)):
        left = np.abs(np.sinc(rotation)) ** (horizon - 1)
        axes.plot(rotation, left, color=colour, lw=2, label=f"T = {horizon}")
    axes.legend(loc="lower left", frameon=False)
    axes.set(xlabel="largest rotation r, units of π", ylabel="what is left of one turn's signal")
    axes.set(yscale="log", ylim=(3e-5, 2), xlim=(0, 1.2))
    axes.spines[["top", "right"]].set_visible(False)
    axes.grid(color=INK, alpha=0.08)
    return figure


if __name__ == "__main__":
    main()
