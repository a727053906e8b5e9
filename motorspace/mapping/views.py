"""What is seen from a place: points on walls, from one scan or from several in a row."""

from typing import NamedTuple

import numpy as np
from jaxtyping import Bool, Float, Int

from motorspace.se2 import relative

FAR = 1e6
"""Coordinate of points that do not exist."""
NEIGHBOUR = 0.05
"""How far apart neighbouring points of one wall may be, share of the reach."""
GRAIN = 0.01
"""Points of a view that are nearer than this to another are left out, share of the reach."""


class Views(NamedTuple):
    """Points that are seen from V places, each in the frame of its own place.

    Args:
        points: Where rays have ended, [V, P, 2]; far away where there is none.
        normals: Unit vectors across the wall there, [V, P, 2]; zero where it is not known.
    """

    points: Float[np.ndarray, "V P 2"]
    normals: Float[np.ndarray, "V P 2"]

    @property
    def exist(self) -> Bool[np.ndarray, "V P"]:
        """Which points there are."""
        return self.points[..., 0] < FAR / 2

    def chosen(self, rows: Int[np.ndarray, " W"]) -> "Views":
        """Those of some places."""
        return Views(self.points[rows], self.normals[rows])


def scan_views(
    points: Float[np.ndarray, "N K 2"], met: Bool[np.ndarray, "N K"], *, reach: float
) -> Views:
    """Every scan as a view; walls run through neighbouring points, in order of their bearing.

    Args:
        points: Where the rays of each scan end, in its own frame, neighbours in bearing side by
            side.
        met: Which of them have met a wall.
        reach: The largest reading.
    """
    before, after = np.roll(points, 1, axis=1), np.roll(points, -1, axis=1)
    near_before = _joined(points, before, met & np.roll(met, 1, axis=1), reach)
    near_after = _joined(points, after, met & np.roll(met, -1, axis=1), reach)
    low = np.where(near_before[..., None], before, points)
    high = np.where(near_after[..., None], after, points)
    along = high - low
    length = np.linalg.norm(along, axis=-1, keepdims=True)
    across = np.stack([-along[..., 1], along[..., 0]], axis=-1)
    normals = np.where(length > 0, across / np.maximum(length, 1e-12), 0.0)
    placed = np.where(met[..., None], points, FAR)
    return Views(placed, np.where(met[..., None], normals, 0.0))


def _joined(
    points: Float[np.ndarray, "N K 2"],
    others: Float[np.ndarray, "N K 2"],
    both: Bool[np.ndarray, "N K"],
    reach: float,
) -> Bool[np.ndarray, "N K"]:
    gap = np.linalg.norm(points - others, axis=-1)
    return both & (gap > 0) & (gap < NEIGHBOUR * reach)


def joined_views(
    scans: Views,
    poses: Float[np.ndarray, "3 N"],
    places: Int[np.ndarray, " V"],
    *,
    around: int,
    num_points: int,
    reach: float,
) -> Views:
    """What has been seen around places, in the frame of each: neighbouring scans joined.

    Args:
        scans: Every scan as a view.
        poses: Where each was taken, [3, N]; only neighbours have to be right among themselves.
        places: Scans whose surroundings are wanted, [V].
        around: Scans before, and after, that are joined with each.
        num_points: Points of a view at most.
        reach: The largest reading.
    """
    num = poses.shape[1]
    shape = len(places), num_points, 2
    points, normals = np.full(shape, FAR), np.zeros(shape)
    exist = scans.exist & (np.sum(scans.normals**2, axis=-1) > 0)
    random = np.random.default_rng(0)
    for view, place in enumerate(places):
        near = np.arange(max(0, place - around), min(num, place + around + 1))
        x, y, turn = relative(np.repeat(poses[:, [place]], len(near), axis=1), poses[:, near])
        kept = exist[near]
        rotation = np.exp(1j * turn)[:, None]
        seen = _complex(scans.points[near]) * rotation + (x + 1j * y)[:, None]
        across = (_complex(scans.normals[near]) * rotation)[kept]
        chosen = _thinned(seen[kept], GRAIN * reach, num_points, random)
        points[view, : len(chosen)] = _pairs(seen[kept][chosen])
        normals[view, : len(chosen)] = _pairs(across[chosen])
    return Views(points, normals)


def _thinned(
    points: np.ndarray, grain: float, most: int, random: np.random.Generator
) -> Int[np.ndarray, " P"]:
    """Which points [complex] to keep: one in each cell, at most so many."""
    cells = np.round(_pairs(points) / grain).astype(np.int64)
    _, first = np.unique(cells, axis=0, return_index=True)
    return random.permutation(first)[:most]


def _complex(pairs: Float[np.ndarray, "*batch 2"]) -> np.ndarray:
    return pairs[..., 0] + 1j * pairs[..., 1]


def _pairs(numbers: np.ndarray) -> Float[np.ndarray, "*batch 2"]:
    return np.stack([numbers.real, numbers.imag], axis=-1)
