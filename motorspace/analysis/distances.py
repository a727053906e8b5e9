"""Do codes lie apart as their displacements do? Measures on the distances of pairs."""

import numpy as np
from jaxtyping import Float

from motorspace.analysis.coordinates import Points

Distances = Float[np.ndarray, " J"]
"""Distances of J pairs, as `scipy.spatial.distance.pdist` lists them."""

SHARPNESS = 50.0
"""How fast pairs lose weight with the distance of their displacements (alpha)."""


def topology_error(codes: Distances, displacements: Distances) -> float:
    """D_topo = mean(|h_i - h_j| / max|h| exp(-alpha |p_i - p_j| / max|p|)), alpha = 50.

    As published (Laflaquière and Garcia Ortiz, NeurIPS 2019): displacements that are near each
    other must have codes that are. 0 is perfect. It depends on how the displacements are
    spread, and on the largest distance alone, so compare it on the same sample only.
    """
    return float(np.mean(codes / codes.max() * _nearness(displacements)))


def normalised_topology_error(codes: Distances, displacements: Distances) -> float:
    """(D(h) - D(p)) / (1 - D(p)), D(x) = sum(w |x_i - x_j|) / sum(w) / mean(|x_i - x_j|).

    The same weights w as in `topology_error`. Random codes have 1, and an isometry has 0:
    displacements do not share a place either, so that D(p) is what perfect codes reach. Below
    0 for codes that draw near displacements nearer than they are.
    """
    weights = _nearness(displacements)

    def level(distances: Distances) -> float:
        return float((weights * distances).sum() / weights.sum() / distances.mean())

    ideal = level(displacements)
    return (level(codes) - ideal) / (1.0 - ideal)


def _nearness(displacements: Distances) -> Distances:
    return np.exp(-SHARPNESS * displacements / displacements.max())


def metric_error(decoded: Distances, displacements: Distances) -> float:
    """D_metric = mean(| |q_i - q_j| - |p_i - p_j| |) / max|p_i - p_j|, q = A h + b.

    As published (Laflaquière and Garcia Ortiz, NeurIPS 2019), with `decoded` the distances of
    displacements that a linear map reads off the codes. The map is to be fitted elsewhere.
    """
    return float(np.mean(np.abs(decoded - displacements)) / displacements.max())


def rank_correlations(*distances: Distances) -> Float[np.ndarray, "V V"]:
    """Spearman's correlation of every two kinds of distances over the same pairs.

    Distances that are all equal, as those of a dead code, have none with any other: 0.
    """
    from scipy.stats import rankdata

    ranks = np.stack([rankdata(d) for d in distances])
    centred = ranks - ranks.mean(axis=1, keepdims=True)
    norms = np.linalg.norm(centred, axis=1, keepdims=True)
    centred = centred / np.maximum(norms, 1e-12)
    return centred @ centred.T


def partial(correlations: Float[np.ndarray, "3 3"]) -> float:
    """Correlation of the first two variables with the third held fixed.

    (r_12 - r_13 r_23) / sqrt((1 - r_13^2) (1 - r_23^2)) (Fisher, 1924), here of ranks.
    """
    r12, r13, r23 = correlations[0, 1], correlations[0, 2], correlations[1, 2]
    return float((r12 - r13 * r23) / np.sqrt(max((1 - r13**2) * (1 - r23**2), 1e-12)))


def semipartial(correlations: Float[np.ndarray, "3 3"]) -> float:
    """Correlation of the first variable with what the third leaves open of the second.

    (r_12 - r_13 r_23) / sqrt(1 - r_23^2); its square is what the second explains of the first
    beyond the third. Unlike `partial`, which correlates what is left even where next to nothing
    is left, it vanishes as the first variable comes near the third.
    """
    r12, r13, r23 = correlations[0, 1], correlations[0, 2], correlations[1, 2]
    return float((r12 - r13 * r23) / np.sqrt(max(1 - r23**2, 1e-12)))


def centred_distances(points: Points) -> Distances:
    """Euclidean distances of all pairs."""
    from scipy.spatial.distance import pdist

    return np.asarray(pdist(points - points.mean(axis=0)))
