"""Closed lines with fewer points, which still do not meet."""

import numpy as np
from jaxtyping import Bool, Float, Int

from motorspace.worlds.validation import meet

Ring = Float[np.ndarray, "P 2"]

AT_ONCE = 256
"""Segments that are compared with all others in one step."""


def simplified(rings: list[np.ndarray], tolerance: float) -> list[np.ndarray]:
    """The closed lines with fewer points, none of them further away than `tolerance`.

    Douglas and Peucker (1973); where lines would then meet, they keep all their points.

    Args:
        rings: Points of each line, the first one not repeated; the lines do not meet.
        tolerance: In the unit of the points.
    """
    rings = [np.roll(ring, -int(np.lexsort(ring.T[::-1])[0]), axis=0) for ring in rings]
    kept = [_kept_of_ring(ring, tolerance) for ring in rings]
    while len(meeting := _meeting([ring[k] for ring, k in zip(rings, kept, strict=True)])):
        corners = np.concatenate([np.flatnonzero(k) for k in kept])
        owners = np.repeat(np.arange(len(rings)), [int(k.sum()) for k in kept])
        for segment in meeting.tolist():
            owner, start = owners[segment], corners[segment]
            within = segment + 1 < len(owners) and owners[segment + 1] == owner
            kept[owner][start : corners[segment + 1] if within else None] = True
    return [ring[k] for ring, k in zip(rings, kept, strict=True)]


def _kept_of_ring(ring: Ring, tolerance: float) -> Bool[np.ndarray, " P"]:
    """The points that stay: the first, the one farthest from it, and what lies off in between."""
    far = int(np.argmax(np.hypot(*(ring - ring[0]).T)))
    closed = np.concatenate([ring, ring[:1]])
    kept = np.zeros(len(closed), bool)
    _keep(closed, kept, (0, far), tolerance)
    _keep(closed, kept, (far, len(ring)), tolerance)
    if kept.sum() < 4:  # the first point counts twice, and two do not enclose anything
        kept[:] = True
    return kept[:-1]


def _keep(
    line: Float[np.ndarray, "Q 2"],
    kept: Bool[np.ndarray, " Q"],
    part: tuple[int, int],
    tolerance: float,
) -> None:
    """Mark the points of a part that stay, with a stack in place of the recursion."""
    kept[[*part]] = True
    parts = [part]
    while parts:
        start, end = parts.pop()
        if end - start < 2:
            continue
        away = _distances(line[start + 1 : end], line[start], line[end])
        farthest = int(np.argmax(away))
        if away[farthest] > tolerance + 1e-9:
            middle = start + 1 + farthest
            kept[middle] = True
            parts += [(start, middle), (middle, end)]


def _distances(
    points: Ring, start: Float[np.ndarray, "2"], end: Float[np.ndarray, "2"]
) -> Float[np.ndarray, " P"]:
    """Distances from a segment."""
    along = end - start
    share = np.clip((points - start) @ along / max(float(along @ along), 1e-300), 0.0, 1.0)
    return np.hypot(*(points - start - share[:, None] * along).T)


def _meeting(rings: list[np.ndarray]) -> Int[np.ndarray, " M"]:
    """The segments of closed lines that meet others than their neighbours."""
    start = np.concatenate(rings)
    end = np.concatenate([np.roll(ring, -1, axis=0) for ring in rings])
    following = np.concatenate(_following([len(ring) for ring in rings]))
    low, high = np.minimum(start, end), np.maximum(start, end)
    found = []
    for first in range(0, len(start), AT_ONCE):
        part = slice(first, first + AT_ONCE)
        near = (low[part, None] <= high[None, first:]) & (low[None, first:] <= high[part, None])
        one, other = (axis + first for axis in np.nonzero(near.all(axis=-1)))
        apart = (one < other) & (following[one] != other) & (following[other] != one)
        one, other = one[apart], other[apart]
        met = meet(start[one], end[one], start[other], end[other])
        found += [one[met], other[met]]
    return np.unique(np.concatenate(found))


def _following(lengths: list[int]) -> list[Int[np.ndarray, " L"]]:
    """Of each segment the next one around its line."""
    starts = np.concatenate([[0], np.cumsum(lengths)[:-1]])
    return [first + np.roll(np.arange(num), -1) for first, num in zip(starts, lengths, strict=True)]
