"""An agent in its world as an array of pixels, without a drawing library."""

import numpy as np
from jaxtyping import Float, UInt8

from motorspace._types import Pose
from motorspace.worlds.scenario import Scenario

SIZE = 320
PAPER, INK, RAY, BODY = (255, 255, 255), (40, 40, 40), (255, 160, 60), (30, 100, 200)
GOAL = (60, 160, 80)

Image = UInt8[np.ndarray, "H W 3"]


def render(scenario: Scenario, pose: Pose, *, goal: Pose | None = None) -> Image:
    """A fresh picture of the world, the agent, its gaze, what it senses, and its goal if any."""
    image = np.full((SIZE, SIZE, 3), PAPER, np.uint8)
    drawing = scenario.world.drawing()
    bounds = drawing.bounds
    for ray in scenario.sensor.rays(scenario.world, pose):
        _line(image, bounds, ray, RAY)
    for wall in drawing.lines:
        _line(image, bounds, wall, INK)
    for point in drawing.points:
        _disc(image, bounds, point, 3, INK)
    if goal is not None:
        _disc(image, bounds, np.array([float(goal.x), float(goal.y)]), 5, GOAL)
    x, y, gaze = map(float, pose.frame)
    tip = (x + drawing.pointer * np.cos(gaze), y + drawing.pointer * np.sin(gaze))
    _disc(image, bounds, np.array([x, y]), 5, BODY)
    _line(image, bounds, np.array([(x, y), tip]), INK)
    return image


def _pixels(
    bounds: tuple[float, ...], points: Float[np.ndarray, "N 2"]
) -> Float[np.ndarray, "N 2"]:
    """Row and column of each point; y points up in the world and rows point down."""
    low, high = np.array(bounds[:2]), np.array(bounds[2:])
    share = (points - low) / (high - low).max()
    return np.stack([1.0 - share[:, 1], share[:, 0]], axis=-1) * (SIZE - 5) + 2


def _line(
    image: Image,
    bounds: tuple[float, ...],
    ends: Float[np.ndarray, "2 2"],
    colour: tuple[int, int, int],
) -> None:
    a, b = _pixels(bounds, ends)
    steps = np.linspace(0.0, 1.0, int(np.abs(b - a).max()) * 2 + 2)[:, None]
    rows, columns = np.round(a + steps * (b - a)).astype(int).T
    keep = (rows >= 0) & (rows < SIZE - 1) & (columns >= 0) & (columns < SIZE - 1)
    rows, columns = rows[keep], columns[keep]
    for down, right in ((0, 0), (1, 0), (0, 1)):
        image[rows + down, columns + right] = colour


def _disc(
    image: Image,
    bounds: tuple[float, ...],
    centre: Float[np.ndarray, "2"],
    radius: int,
    colour: tuple[int, int, int],
) -> None:
    row, column = _pixels(bounds, centre[None])[0]
    rows, columns = np.ogrid[:SIZE, :SIZE]
    image[(rows - row) ** 2 + (columns - column) ** 2 <= radius**2] = colour
