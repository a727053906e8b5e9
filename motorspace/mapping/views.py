"""What is seen from a place: points on walls, from one scan or from several in a row."""

from typing import NamedTuple

import numpy as np
from jaxtyping import Bool, Float, Int

from motorspace.se2 import relative

FAR = 1e6
"""Coordinate of points that do not exist."""
NEIGHBOUR = 0.05
"""How far apart neighbouring points of one wall may be, share of the reach."""
NEAR, MOST_NEAR = 0.025, 8
"""Up to where more points count for the direction of a wall, share of the reach; how many more."""
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

    def in_reaches(self, reach: float) -> Float[np.ndarray, "V P 2"]:
        """The points in another unit; those that do not exist stay as far away."""
        return np.where(self.exist[..., None], self.points / reach, FAR)

    def beside(self, others: "Views") -> "Views":
        """These and others, whose points may be of another number."""
        most = max(self.points.shape[1], others.points.shape[1])
        pairs = zip(self, others, (FAR, 0.0), strict=True)
        return Views(
            *(
                np.concatenate([_filled(a, most, none), _filled(b, most, none)])
                for a, b, none in pairs
            )
        )


def _filled(
    points: Float[np.ndarray, "V P 2"], most: int, none: float
) -> Float[np.ndarray, "V Q 2"]:
    missing = most - points.shape[1]
    return np.pad(points, ((0, 0), (0, missing), (0, 0)), constant_values=none)


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
    weight, near = _neighbours(points, met, reach)
    middle = np.sum(weight[..., None] * near, axis=0) / np.maximum(weight.sum(axis=0), 1)[..., None]
    x, y = np.moveaxis(near - middle, -1, 0)
    xx, xy, yy = (np.sum(weight * product, axis=0) for product in (x * x, x * y, y * y))
    along = np.arctan2(2 * xy, xx - yy) / 2
    across = np.stack([-np.sin(along), np.cos(along)], axis=-1)
    normals = np.where((xx + yy > 0)[..., None], across, 0.0)
    placed = np.where(met[..., None], points, FAR)
    return Views(placed, np.where(met[..., None], normals, 0.0))


def _neighbours(
    points: Float[np.ndarray, "N K 2"], met: Bool[np.ndarray, "N K"], reach: float
) -> tuple[Float[np.ndarray, "W N K"], Float[np.ndarray, "W N K 2"]]:
    """Points that may be on one wall with each, and whether they are (1 or 0).

    The next ones on either side, and as many more as are really near: the wall through two
    points that nearly touch is mostly noise.
    """
    shifts = np.arange(-MOST_NEAR, MOST_NEAR + 1)
    near = np.stack([np.roll(points, shift, axis=1) for shift in shifts])
    both = met & np.stack([np.roll(met, shift, axis=1) for shift in shifts])
    gap = np.linalg.norm(near - points, axis=-1) / reach
    limit = np.where(np.abs(shifts) <= 1, NEIGHBOUR, NEAR)[:, None, None]
    return np.where(both & (gap < limit), 1.0, 0.0), near


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
