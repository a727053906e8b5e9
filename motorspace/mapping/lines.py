"""Where rays end lie walls: straight lines through the points that fall into one cell."""

from typing import NamedTuple

import numpy as np
from jaxtyping import Float, Int

Points = Float[np.ndarray, "2 P"]

FEWEST = 6
"""Points that a line takes before it says how far off they are."""
ROUNDS = 3
"""Fits of each line; points that are off by more than the tolerance count less and less."""


class Lines(NamedTuple):
    """Lines through P points in L cells.

    Args:
        cells: The cell of each point, [P].
        middle: The points' mean in each cell, [2, L].
        normal: The unit vector across each line, [2, L].
        spread: Variance of the points along and across the line, [2, L].
        num_points: Points in each cell, [L].
        off: How far each point is off its line, [P].
        weight: What each point counts, [P], from 0 to 1.
    """

    cells: Int[np.ndarray, " P"]
    middle: Float[np.ndarray, "2 L"]
    normal: Float[np.ndarray, "2 L"]
    spread: Float[np.ndarray, "2 L"]
    num_points: Int[np.ndarray, " L"]
    off: Float[np.ndarray, " P"]
    weight: Float[np.ndarray, " P"]

    def usable(self, ratio: float) -> np.ndarray:
        """Which points [P] are in cells whose variance along is `ratio` times that across."""
        thin = (self.num_points >= FEWEST) & (self.spread[0] > ratio * self.spread[1])
        return np.asarray(thin[self.cells])


def fit_lines(
    points: Points, groups: Int[np.ndarray, " P"], *, cell: float, tolerance: float
) -> Lines:
    """Lines through the points of each group in square cells.

    Args:
        points: [2, P].
        groups: Points of other groups share no line, [P].
        cell: Side of the cells.
        tolerance: How far off a point is that counts a quarter.
    """
    places = np.stack([groups, *np.floor(points / cell).astype(np.int64)])
    places -= places.min(axis=1, keepdims=True)
    flat = np.ravel_multi_index(tuple(places), tuple(places.max(axis=1) + 1))
    _, cells, count = np.unique(flat, return_inverse=True, return_counts=True)
    weight = np.ones(points.shape[1])

    def mean(values: np.ndarray) -> np.ndarray:
        total = np.bincount(cells, weight, len(count))
        return np.bincount(cells, values * weight, len(count)) / np.maximum(total, 1e-9)

    for _ in range(ROUNDS):
        middle = np.stack([mean(axis) for axis in points])
        dx, dy = points - middle[:, cells]
        xx, xy, yy = mean(dx * dx), mean(dx * dy), mean(dy * dy)
        angle = np.arctan2(2 * xy, xx - yy) / 2
        normal = np.stack([-np.sin(angle), np.cos(angle)])
        off = normal[0, cells] * dx + normal[1, cells] * dy
        weight = (1 + (off / tolerance) ** 2) ** -2
    across = xx * normal[0] ** 2 + yy * normal[1] ** 2 + 2 * xy * normal[0] * normal[1]
    spread = np.stack([xx + yy - across, across])
    return Lines(cells, middle, normal, spread, count, off, weight)
