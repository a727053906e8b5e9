"""How many dimensions do codes fill?"""

import numpy as np
from jaxtyping import Float

from motorspace.analysis.coordinates import Points
from motorspace.analysis.inputs import FEWEST_POINTS, resolution

SAME = 3e-6
"""Codes that differ by less in every unit are one, relative to the standard deviation of all."""
ROUNDINGS = 8
"""Codes that differ by fewer roundings in every unit are one."""


def intrinsic_dimension(codes: Points) -> float:
    """Returns the dimension by the ratio of the distances of two nearest neighbours (TwoNN).

    Codes that are equal up to rounding count once: how far rounding puts them apart says nothing
    of the space they lie in. Needs the extra `topology`. Facco et al., 2017.

    Args:
        codes: [N, C].

    Returns:
        The dimension; NaN for fewer than a hundred different codes.
    """
    import skdim

    spread = codes.std()
    different = np.unique(np.round(codes / spread, 9), axis=0)
    different = _apart(different, max(SAME, ROUNDINGS * resolution(codes) / float(spread)))
    if len(different) < FEWEST_POINTS:
        return float("nan")
    if different.shape[1] == 1:  # which scikit-dimension refuses; a constant changes no distance
        different = np.pad(different, ((0, 0), (0, 1)))
    return float(skdim.id.TwoNN().fit(different).dimension_)


def participation_ratio(codes: Points) -> float:
    """Returns (sum l)^2 / sum l^2 over the eigenvalues l of the codes' covariance: 1 for a line."""
    power = _powers(codes)
    return float(power.sum() ** 2 / (power**2).sum())


def components_for(codes: Points, *, share: float = 0.95) -> int:
    """Returns the fewest principal components that hold this share of the variance."""
    power = np.cumsum(_powers(codes))
    return int(np.searchsorted(power, share * power[-1] * (1 - 1e-12))) + 1


def _apart(points: Points, tolerance: float) -> Float[np.ndarray, "_ _"]:
    """The points without those that lie within `tolerance`, in every unit, of an earlier one."""
    from scipy.spatial import cKDTree

    # Whole heaps of equal points go first: the pairs within a heap grow with its square.
    _, first = np.unique(np.floor(points / tolerance), axis=0, return_index=True)
    points = points[np.sort(first)]
    near = cKDTree(points).query_pairs(tolerance, p=np.inf, output_type="ndarray")
    keep = np.ones(len(points), bool)
    keep[near.max(axis=1)] = False
    return points[keep]


def _powers(codes: Points) -> Float[np.ndarray, " P"]:
    from sklearn.decomposition import PCA

    return np.asarray(PCA().fit(codes).explained_variance_)
