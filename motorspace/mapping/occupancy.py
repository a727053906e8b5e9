"""Which cells of the plane rays that met something have crossed, and in which they have ended."""

from typing import NamedTuple

import numpy as np
from jaxtyping import Bool, Float, Int

from motorspace._errors import UserError
from motorspace.mapping.mounting import SATURATED, Mounting

OCCUPIED = 0.3
"""Share of the rays in a cell that end there, from which on it counts as occupied."""
MARGIN = 1
"""Cells around everything that has been seen."""
MOST_CELLS = 40_000_000
CHUNK_SIZE = 20_000
"""Rays that are followed at once."""


class Occupancy(NamedTuple):
    """A grid of cells.

    Args:
        ended: Rays that have ended in each cell, [W, H].
        crossed: Rays that have gone through it, [W, H].
        low: Corner of the first cell, [2].
        cell: Side of a cell.
    """

    ended: Int[np.ndarray, "W H"]
    crossed: Int[np.ndarray, "W H"]
    low: Float[np.ndarray, "2"]
    cell: float

    @property
    def occupied(self) -> Bool[np.ndarray, "W H"]:
        """The cells that hold something."""
        return self.ended > OCCUPIED * np.maximum(self.ended + self.crossed, 1)

    @property
    def seen(self) -> Bool[np.ndarray, "W H"]:
        """The cells that rays have reached."""
        return self.ended + self.crossed > 0


class Grid(NamedTuple):
    """Where cells lie: the corner of the first one, how many, their side."""

    low: Float[np.ndarray, "2"]
    shape: tuple[int, int]
    cell: float


def occupancy(
    eyes: Float[np.ndarray, "3 N"],
    sensors: Float[np.ndarray, "N K"],
    mounting: Mounting,
    *,
    cell: float,
    grid: Grid | None = None,
) -> Occupancy:
    """Draw readings where they were taken.

    Args:
        eyes: Where the rays begin at every moment, [3, N].
        sensors: The readings, [N, K].
        mounting: Where the rays point.
        cell: Side of a cell, in the readings' unit.
        grid: Where the cells lie; by default around everything that was seen.

    Raises:
        UserError: For so small cells that there are too many.
    """
    grid = grid_around(eyes, sensors, mounting, cell=cell) if grid is None else grid
    ended, crossed = np.zeros((2, grid.shape[0] * grid.shape[1]), np.int64)
    # Lasers also read nothing where a wall is dark or steep: that shows no free space.
    met = sensors.reshape(-1) < SATURATED * mounting.reach
    angles = (eyes[2][:, None] + mounting.angles).reshape(-1)[met]
    starts = np.repeat(eyes[:2], sensors.shape[1], axis=1)[:, met]
    lengths = sensors.reshape(-1)[met]
    for first in range(0, len(lengths), CHUNK_SIZE):
        rows = slice(first, first + CHUNK_SIZE)
        rays = starts[:, rows], angles[rows], lengths[rows]
        ended += _counted(_ends(*rays), grid)
        crossed += _counted(_along(*rays, grid.cell), grid)
    return Occupancy(ended.reshape(grid.shape), crossed.reshape(grid.shape), grid.low, grid.cell)


def grid_around(
    eyes: Float[np.ndarray, "3 N"],
    sensors: Float[np.ndarray, "N K"],
    mounting: Mounting,
    *,
    cell: float,
) -> Grid:
    """Cells that hold all ends of rays."""
    ends = mounting.ends(eyes, sensors)[:, sensors < SATURATED * mounting.reach]
    points = np.concatenate([ends, eyes[:2]], axis=1)
    low = np.floor(points.min(axis=1) / cell) - MARGIN
    high = np.floor(points.max(axis=1) / cell) + 1 + MARGIN
    width, height = (high - low).astype(int)
    if width * height > MOST_CELLS:
        raise UserError(
            f"{width} x {height} cells are too many", remedy="choose a larger side of the cells"
        )
    return Grid(low * cell, (int(width), int(height)), cell)


def agreement(first: Occupancy, second: Occupancy) -> float:
    """Intersection over union of the occupied cells of two drawings on the same grid."""
    both = np.sum(first.occupied & second.occupied)
    either = np.sum(first.occupied | second.occupied)
    return float(both / max(either, 1))


def _ends(
    starts: Float[np.ndarray, "2 R"],
    angles: Float[np.ndarray, " R"],
    lengths: Float[np.ndarray, " R"],
) -> Float[np.ndarray, "2 R"]:
    return starts + lengths * np.stack([np.cos(angles), np.sin(angles)])


def _along(
    starts: Float[np.ndarray, "2 R"],
    angles: Float[np.ndarray, " R"],
    lengths: Float[np.ndarray, " R"],
    cell: float,
) -> Float[np.ndarray, "2 P"]:
    """Points on the rays, one in each cell or two, up to a cell before their ends."""
    num = max(int(np.ceil(lengths.max(initial=0.0) / cell)), 1)
    distance = cell * np.arange(num)
    inside = distance[None] < (lengths - cell)[:, None]
    direction = np.stack([np.cos(angles), np.sin(angles)])
    points = starts[..., None] + direction[..., None] * distance
    return points[:, inside]


def _counted(points: Float[np.ndarray, "2 P"], grid: Grid) -> Int[np.ndarray, " C"]:
    """How many points lie in each cell."""
    cells = np.floor((points - grid.low[:, None]) / grid.cell).astype(int)
    inside = ((cells >= 0) & (cells < np.array(grid.shape)[:, None])).all(axis=0)
    flat = np.ravel_multi_index(tuple(cells[:, inside]), grid.shape)
    return np.bincount(flat, minlength=grid.shape[0] * grid.shape[1])
