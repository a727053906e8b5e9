"""Are neighbours among the codes neighbours among the displacements, and the other way round?"""

from typing import NamedTuple

from motorspace.analysis.coordinates import Points


def trustworthiness(codes: Points, displacements: Points, *, k: int) -> float:
    """Returns whether the `k` nearest codes are near in displacement: 1 if so, about 0.5 if random.

    1 - 2 / (n k (2n - 3k - 1)) sum_i sum_{j near i in codes alone} (rank(i, j) - k); Venna and
    Kaski, 2001.
    """
    from sklearn.manifold import trustworthiness as of_embedding

    return float(of_embedding(displacements, codes, n_neighbors=k))


def continuity(codes: Points, displacements: Points, *, k: int) -> float:
    """Returns whether the `k` nearest displacements are near among the codes, on the same scale."""
    return trustworthiness(displacements, codes, k=k)


class NeighbourError(NamedTuple):
    """Mean squared distance in displacement of the nearest codes, relative to two others."""

    to_random: float
    """To that of random pairs: 1 for random codes."""
    to_floor: float
    """To that of the points nearest in displacement itself: 1 is perfect."""


def neighbour_error(codes: Points, displacements: Points, *, k: int = 5) -> NeighbourError:
    """Returns 1 / (n k) sum_i sum_{j in kNN(i)} |p_i - p_j|^2 relative to two others.

    KNN-MSE (Raffin et al., S-RL Toolbox, 2018). The mean over random pairs is twice the
    displacements' variance, with no need to draw any.

    Args:
        codes: [N, C].
        displacements: [N, P], as points.
        k: How many nearest codes of each.
    """
    error = _spread_of_neighbours(codes, displacements, k)
    floor = _spread_of_neighbours(displacements, displacements, k)
    return NeighbourError(
        error / float(2 * displacements.var(axis=0).sum()), error / max(floor, 1e-12)
    )


def _spread_of_neighbours(points: Points, displacements: Points, k: int) -> float:
    from sklearn.neighbors import NearestNeighbors

    near = NearestNeighbors(n_neighbors=k).fit(points).kneighbors(return_distance=False)
    return float(((displacements[near] - displacements[:, None]) ** 2).sum(axis=-1).mean())
