"""Does orientation close into a circle?"""

import numpy as np
from jaxtyping import Float

from motorspace.analysis.coordinates import Points
from motorspace.analysis.projections import pca

Angles = Float[np.ndarray, " N"]

NUM_BINS = 24
MOST_LOOP_POINTS = 300
"""Persistent homology grows with the cube of the points."""


def winding_number(codes: Points, turns: Angles) -> float:
    """Returns how often codes go around while orientation goes around once.

    The mean codes of `NUM_BINS` equal ranges of orientation, on the plane of their first two
    principal components, make a closed path; its angle about its centre is counted.

    Args:
        codes: [N, C].
        turns: [N] orientation changes, radians.

    Returns:
        A whole number: 1 or -1 for a circle. 0 when some range holds no code, so that the
        orientations themselves do not close, and for codes of one column.
    """
    bins = np.floor((turns + np.pi) / (2 * np.pi) * NUM_BINS).astype(int) % NUM_BINS
    counts = np.bincount(bins, minlength=NUM_BINS)
    if not counts.all() or codes.shape[1] < 2:
        return 0.0
    sums = [np.bincount(bins, column, minlength=NUM_BINS) for column in codes.T]
    x, y = pca(np.stack(sums, axis=1) / counts[:, None], 2).coordinates.T
    angles = np.arctan2(y, x)
    return float(np.round(wrapped(np.diff(angles, append=angles[0])).sum() / (2 * np.pi)))


def circular_correlation(decoded: Angles, turns: Angles) -> float:
    """Returns the correlation of two angles [N]: 1 for equal ones.

    Jammalamadaka and SenGupta, Topics in Circular Statistics, 2001.
    """
    a, b = np.sin(decoded - mean_angle(decoded)), np.sin(turns - mean_angle(turns))
    return float((a * b).sum() / np.sqrt(max((a**2).sum() * (b**2).sum(), 1e-12)))


def circular_error(decoded: Angles, turns: Angles) -> float:
    """Returns the mean absolute difference of two angles [N] in degrees; 90 for random ones.

    Example:
        >>> circular_error(np.array([np.pi]), np.array([-np.pi / 2]))
        90.0
    """
    return float(np.degrees(np.abs(wrapped(decoded - turns)).mean()))


def mean_angle(angles: Angles) -> float:
    """Returns the direction of the sum of unit vectors, radians."""
    return float(np.arctan2(np.sin(angles).sum(), np.cos(angles).sum()))


def wrapped(angles: Angles) -> Angles:
    """Returns the same angles in [-pi, pi)."""
    return (angles + np.pi) % (2 * np.pi) - np.pi


def seam_gap(codes: Points, points: Points, turns: Angles, *, width: float = 0.3) -> float:
    """Returns how far apart codes lie across half a turn, relative to codes beside it.

    Of every code whose orientation change is within `width` radians below half a turn: the distance
    to the code of the displacement nearest to its own just beyond, where angles begin anew, over
    that to the nearest on its own side, each relative to how far the displacements are apart.

    Args:
        codes: [N, C].
        points: [N, P], the coordinates of the displacements.
        turns: [N] orientation changes, radians in (-pi, pi].
        width: Radians on either side of half a turn.

    Returns:
        1 where orientation closes, far above 1 where it is torn open; NaN with fewer than ten
        codes on either side.
    """
    before, beyond = np.flatnonzero(turns > np.pi - width), np.flatnonzero(turns < width - np.pi)
    if min(len(before), len(beyond)) < 10:
        return float("nan")
    across = _stretch(codes, points, before, beyond, rank=0)
    return across / _stretch(codes, points, before, before, rank=1)


def _stretch(
    codes: Points, points: Points, first: np.ndarray, second: np.ndarray, *, rank: int
) -> float:
    """Mean distance of codes over that of points, of each of `first` and the nearest `second`."""
    from sklearn.neighbors import NearestNeighbors

    near = NearestNeighbors(n_neighbors=rank + 1).fit(points[second])
    chosen = second[near.kneighbors(points[first], return_distance=False)[:, rank]]
    apart = np.linalg.norm(codes[first] - codes[chosen], axis=1).mean()
    return float(apart / np.linalg.norm(points[first] - points[chosen], axis=1).mean())


def loop_persistence(codes: Points) -> float:
    """Returns how clearly the codes have one hole: (longest - second H1 bar) / longest death.

    Bars of the Vietoris-Rips filtration of at most `MOST_LOOP_POINTS` codes (Edelsbrunner and
    Harer, Computational Topology, 2010). Needs the extra `topology`.

    Args:
        codes: [N, C], of small translation: others fill the hole.

    Returns:
        Near 1 for a circle; near 0 for a disc, a line, or two holes that are alike.
    """
    import gudhi

    step = -(-len(codes) // MOST_LOOP_POINTS)
    some = codes[::step] / codes.std()
    tree = gudhi.RipsComplex(points=some).create_simplex_tree(max_dimension=1)
    tree.collapse_edges()
    tree.expansion(2)
    tree.compute_persistence()
    bars = tree.persistence_intervals_in_dimension(1)
    bars = bars[np.isfinite(bars).all(axis=1)] if len(bars) else np.zeros((0, 2))
    lengths = np.sort(np.diff(bars, axis=1).ravel())[::-1]
    if not len(lengths):
        return 0.0
    second = lengths[1] if len(lengths) > 1 else 0.0
    return float((lengths[0] - second) / bars[:, 1].max())
