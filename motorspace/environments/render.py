"""An agent in its world as an array of pixels, without a drawing library."""

from typing import Any

import numpy as np
from jaxtyping import Float, UInt8

from motorspace._types import Pose
from motorspace.worlds.sensors.base import AbstractSensor
from motorspace.worlds.sensors.range_fan import RangeFan
from motorspace.worlds.world import AbstractWorld, LatticeWorld, WalledWorld

SIZE = 320
PAPER, INK, RAY, BODY = (255, 255, 255), (40, 40, 40), (255, 160, 60), (30, 100, 200)

Image = UInt8[np.ndarray, "H W 3"]


def render(world: AbstractWorld, sensor: AbstractSensor[Any], pose: Pose) -> Image:
    """A fresh picture of the agent, its gaze and its rays."""
    image = np.full((SIZE, SIZE, 3), PAPER, np.uint8)
    x, y, gaze = float(pose.x), float(pose.y), float(pose.gaze)
    if isinstance(world, LatticeWorld):
        bounds = (-1.0, -1.0, float(world.width), float(world.height))
        for node in np.ndindex(world.width, world.height):
            _disc(image, bounds, np.array(node, float), 3, INK)
        ahead = 0.4
    else:
        assert isinstance(world, WalledWorld)
        bounds = world.bounds
        if isinstance(sensor, RangeFan):
            half = sensor.field_of_view / 2
            angles = gaze + np.linspace(-half, half, sensor.num_rays)
            ranges = np.asarray(sensor.sense(world, pose))[: sensor.num_rays]
            for angle, reach in zip(angles, ranges, strict=True):
                end = (x + reach * np.cos(angle), y + reach * np.sin(angle))
                _line(image, bounds, np.array([(x, y), end]), RAY)
        for wall in np.asarray(world.walls):
            _line(image, bounds, wall, INK)
        ahead = 1.5
    tip = (x + ahead * np.cos(gaze), y + ahead * np.sin(gaze))
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
