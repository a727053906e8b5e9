"""Do sequences that lead to the same displacement share a code?"""

import numpy as np
from jaxtyping import Float, Int

from motorspace.analysis.coordinates import Numbers, Points

Labels = Int[np.ndarray, " N"]
"""A number for every group of equivalent sequences; negative for those of no group."""

ROUNDING = 1e-24
"""Variance of codes that differ by float64 rounding alone, relative to their mean square."""

NUM_CANDIDATES = 64
"""Sequences looked through for one as far in motors as an equivalent one."""


def equal_rows(values: Float[np.ndarray, "N D"], *, decimals: int = 3) -> Labels:
    """Returns a label for every row [D] that occurs, rounded; -1 for those that occur once.

    Example:
        >>> equal_rows(np.array([[1.0], [2.0], [1.0]]))
        array([ 0, -1,  0])
    """
    index = _numbered(np.round(values, decimals) + 0.0)
    return np.where(np.bincount(index)[index] > 1, index, -1)


def within_to_total_variance(
    codes: Float[Numbers, "N C"], groups: Float[Numbers, "N ..."]
) -> float:
    """Returns the share of the codes' variance that lies within groups of equal label.

    Args:
        codes: [N, C].
        groups: [N, ...]; a label is a row, rounded to a thousandth.

    Returns:
        0 where every group shares a code, 1 where groups make no difference; NaN for codes that
        do not vary.
    """
    x = np.asarray(codes, np.float64)
    labels = np.round(np.asarray(groups, np.float64).reshape(len(x), -1), 3) + 0.0
    total = ((x - x.mean(0)) ** 2).sum()
    return float(_squares_within(x, _numbered(labels)).sum() / total) if total > 0 else float("nan")


def equivalence_ratio(codes: Points, groups: Labels) -> float:
    """Returns the mean squared distance of codes within groups over that of all pairs.

    E_g E_{i,j in g} |h_i - h_j|^2 / E_{i,j} |h_i - h_j|^2, both without the pairs of a code and
    itself. The total is that of all codes given, so that it does not depend on how many are
    in a group.

    Args:
        codes: [N, C].
        groups: [N]; negative for codes of no group.

    Returns:
        0 where equivalent sequences share a code, 1 where their codes are unrelated; NaN without
        groups or for codes that do not vary.

    Example:
        >>> codes = np.array([[0.0], [0.0], [1.0], [1.0]])
        >>> equivalence_ratio(codes, np.array([0, 0, 1, 1]))
        0.0
    """
    total = 2 * codes.var(axis=0, ddof=1).sum()
    grouped = groups >= 0
    if not grouped.any() or total <= ROUNDING * float((codes**2).sum(axis=1).mean()):
        return float("nan")
    index = _numbered(groups[grouped])
    squares, counts = _squares_within(codes[grouped], index), np.bincount(index)
    several = counts > 1
    within = 2 * squares[several] / (counts[several] - 1)
    return float(within.mean() / total) if several.any() else float("nan")


def equivalence_auc(codes: Points, motors: Points, groups: Labels, *, seed: int = 0) -> float:
    """Returns the area under the ROC curve for telling equivalent pairs by their codes' distance.

    Each equivalent pair (i, j) is set against a pair (i, k) of another group whose motor
    distance is the nearest to its own among `NUM_CANDIDATES` random ones, so that codes that
    copy the motor commands gain nothing.

    Args:
        codes: [N, C].
        motors: [N, M], the motor commands behind each code.
        groups: [N]; negative for codes of no group.
        seed: Seed of the pairs and candidates.

    Returns:
        1 where equivalent pairs are nearest, 0.5 for copies of the motors and for collapsed
        codes; NaN without pairs.
    """
    from sklearn.metrics import roc_auc_score

    rng = np.random.default_rng(seed)
    first, second = _pairs(groups, rng)
    if not len(first):
        return float("nan")
    candidates = rng.integers(len(codes), size=(len(first), NUM_CANDIDATES))
    wanted = _distance(motors, first, second)[:, None]
    off = np.abs(_distance(motors, first[:, None], candidates) - wanted)
    own = groups[candidates] == groups[first][:, None]
    off[own] = np.inf
    third = candidates[np.arange(len(first)), off.argmin(axis=1)]
    distances = np.concatenate([_distance(codes, first, second), _distance(codes, first, third)])
    # Distances that differ by rounding alone are equal: collapsed codes must not seem to tell.
    distances = np.round(distances / max(distances.max(), 1e-30), 9)
    equivalent = np.repeat([1, 0], len(first))
    return float(roc_auc_score(equivalent, -distances))


def _numbered(labels: np.ndarray) -> Labels:
    """The place of each label, or row of labels, among those that occur."""
    return np.asarray(np.unique(labels, axis=0, return_inverse=True)[1]).ravel()


def _squares_within(codes: Points, index: Labels) -> Float[np.ndarray, " G"]:
    """Of each group the squared distances from its mean, added up."""
    counts = np.bincount(index)
    means = np.stack([np.bincount(index, column) / counts for column in codes.T], axis=1)
    return np.bincount(index, ((codes - means[index]) ** 2).sum(axis=1))


def _pairs(groups: Labels, rng: np.random.Generator) -> tuple[np.ndarray, np.ndarray]:
    """Every member of a group with a random other one."""
    order = rng.permutation(np.flatnonzero(groups >= 0))
    order = order[np.argsort(groups[order], kind="stable")]
    same = groups[order[1:]] == groups[order[:-1]]
    return order[:-1][same], order[1:][same]


def _distance(points: Points, i: np.ndarray, j: np.ndarray) -> np.ndarray:
    return np.linalg.norm(points[i] - points[j], axis=-1)
