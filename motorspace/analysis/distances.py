"""Do codes lie apart as their displacements do? Measures on the distances of pairs."""

import numpy as np
from jaxtyping import Float

from motorspace.analysis.coordinates import Points

Distances = Float[np.ndarray, " J"]
"""Distances of J pairs, as `scipy.spatial.distance.pdist` lists them."""

SHARPNESS = 50.0
"""How fast pairs lose weight with the distance of their displacements (alpha)."""


def topology_error(codes: Distances, displacements: Distances) -> float:
    """Returns D_topo = mean(|h_i - h_j| / max|h| exp(-alpha |p_i - p_j| / max|p|)), alpha = 50.

    Displacements that are near each other must have codes that are. As published (Laflaquière and
    Garcia Ortiz, NeurIPS 2019). It depends on how the displacements are spread, and on the
    largest distance alone, so compare it on the same sample only.

    Args:
        codes: [J] distances of pairs of codes.
        displacements: [J] distances of the same pairs of displacements.

    Returns:
        0 is perfect; NaN where all codes are equal.
    """
    if not codes.any():
        return float("nan")
    return float(np.mean(codes / codes.max() * _nearness(displacements)))


def normalised_topology_error(codes: Distances, displacements: Distances) -> float:
    """Returns (D(h) - D(p)) / (1 - D(p)), D(x) = sum(w |x_i - x_j|) / sum(w) / mean(|x_i - x_j|).

    With the weights w of `topology_error`. Displacements do not share a place either: D(p) is what
    perfect codes reach.

    Args:
        codes: [J] distances of pairs of codes.
        displacements: [J] distances of the same pairs of displacements.

    Returns:
        0 for an isometry, 1 for random codes, below 0 for codes that draw near displacements
        nearer than they are; NaN where all codes are equal.
    """
    if not codes.any():
        return float("nan")
    weights = _nearness(displacements)

    def level(distances: Distances) -> float:
        return float((weights * distances).sum() / weights.sum() / distances.mean())

    ideal = level(displacements)
    return (level(codes) - ideal) / (1.0 - ideal)


def _nearness(displacements: Distances) -> Distances:
    return np.exp(-SHARPNESS * displacements / displacements.max())


def metric_error(decoded: Distances, displacements: Distances) -> float:
    """Returns D_metric = mean(| |q_i - q_j| - |p_i - p_j| |) / max|p_i - p_j|, q = A h + b.

    As published (Laflaquière and Garcia Ortiz, NeurIPS 2019).

    Args:
        decoded: [J] distances of displacements that a linear map decodes from the codes; fit it on
            other points.
        displacements: [J] distances of the true displacements.
    """
    return float(np.mean(np.abs(decoded - displacements)) / displacements.max())


def rank_correlations(*distances: Distances) -> Float[np.ndarray, "V V"]:
    """Returns Spearman's correlation of every two of V kinds of distances [J] of the same pairs.

    Distances that are all equal, as those of collapsed codes, have 0 with any other.
    """
    from scipy.stats import rankdata

    ranks = np.stack([rankdata(d) for d in distances])
    centred = ranks - ranks.mean(axis=1, keepdims=True)
    norms = np.linalg.norm(centred, axis=1, keepdims=True)
    centred = centred / np.maximum(norms, 1e-12)
    return centred @ centred.T


def partial(correlations: Float[np.ndarray, "3 3"]) -> float:
    """Returns the correlation of the first two variables with the third held fixed.

    (r_12 - r_13 r_23) / sqrt((1 - r_13^2) (1 - r_23^2)); Fisher, 1924.
    """
    r12, r13, r23 = correlations[0, 1], correlations[0, 2], correlations[1, 2]
    return float((r12 - r13 * r23) / np.sqrt(max((1 - r13**2) * (1 - r23**2), 1e-12)))


def semipartial(correlations: Float[np.ndarray, "3 3"]) -> float:
    """Returns the correlation of the first variable with what the third leaves open of the second.

    (r_12 - r_13 r_23) / sqrt(1 - r_23^2); its square is what the second explains of the first
    beyond the third. Unlike `partial`, which correlates what is left even where next to nothing
    is left, it vanishes as the first variable comes near the third.
    """
    r12, r13, r23 = correlations[0, 1], correlations[0, 2], correlations[1, 2]
    return float((r12 - r13 * r23) / np.sqrt(max(1 - r23**2, 1e-12)))


def centred_distances(points: Points) -> Distances:
    """Returns the Euclidean distances [J] of all pairs of points [N, P].

    On an accelerator they are computed there, in single precision.
    """
    from scipy.spatial.distance import pdist

    from motorspace._devices import on_accelerator

    centred = points - points.mean(axis=0)
    return on_device(centred) if on_accelerator() else np.asarray(pdist(centred))


def on_device(points: Points) -> Distances:
    """Returns what `pdist` does, computed where JAX computes."""
    import jax.numpy as jnp

    first, second = np.triu_indices(len(points), 1)
    placed = jnp.asarray(points, jnp.float32)
    apart = jnp.linalg.norm(placed[first] - placed[second], axis=-1)
    return np.asarray(apart, np.float64)
