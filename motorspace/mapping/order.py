"""Which rays are neighbours, by how alike they read."""

import numpy as np
from jaxtyping import Float, Int

from motorspace.mapping.mounting import SATURATED

TOLERANCE = 0.05
"""By which ratio two readings differ that count half as alike."""
ROUNDS = 30


def neighbours_in_order(
    sensors: Float[np.ndarray, "N K"], *, reach: float
) -> Int[np.ndarray, " K"]:
    """The rays from one end of the view to the other, in the direction in which they are listed.

    Args:
        sensors: Readings from many places, [N, K].
        reach: The largest reading.

    Returns:
        Indices of the rays, [K].
    """
    alike = _alike(sensors, reach)
    order = _shortened(_by_second_eigenvector(alike), -np.log(alike / alike.max() + 1e-3))
    return order if np.sum(np.diff(order) > 0) * 2 >= len(order) - 1 else order[::-1]


def _alike(sensors: Float[np.ndarray, "N K"], reach: float) -> Float[np.ndarray, "K K"]:
    """How often each two rays read the same, above what they do by chance."""
    size, met = np.log(np.maximum(sensors, 1e-3 * reach)), sensors < SATURATED * reach
    alike = np.zeros((sensors.shape[1],) * 2)
    for ray in range(len(alike)):
        both = met[:, [ray]] & met
        same = both / (1 + ((size[:, [ray]] - size) / TOLERANCE) ** 2)
        alike[ray] = same.sum(axis=0) / np.maximum(both.sum(axis=0), 1)
    np.fill_diagonal(alike, 0.0)
    return np.maximum(alike - np.median(alike), 0.0) ** 2 + 1e-9


def _by_second_eigenvector(alike: Float[np.ndarray, "K K"]) -> Int[np.ndarray, " K"]:
    """Seriation by the second eigenvector of the graph's Laplacian (Atkins et al., 1998)."""
    root = np.sqrt(alike.sum(axis=1))
    _, vectors = np.linalg.eigh(np.eye(len(alike)) - alike / np.outer(root, root))
    return np.argsort(vectors[:, 1] / root)


def _shortened(
    order: Int[np.ndarray, " K"], distance: Float[np.ndarray, "K K"]
) -> Int[np.ndarray, " K"]:
    """A path through all rays from whose parts none gets shorter when it is turned round (2-opt).

    Rays all around a robot have no ends: their second eigenvector runs to and fro, and this
    untangles it.
    """
    size = len(order)
    padded = np.zeros((size + 1, size + 1))
    padded[:size, :size] = distance
    # The path goes on, at no cost, through a place beyond both ends.
    path = np.concatenate([[size], order, [size]])
    for _ in range(ROUNDS * size):
        before, first = path[:-2], path[1:-1]
        last, after = path[1:-1], path[2:]
        now = padded[before, first][:, None] + padded[last, after][None]
        then = padded[np.ix_(before, last)] + padded[np.ix_(first, after)]
        gain = np.triu(now - then, 1)
        start, end = np.unravel_index(int(gain.argmax()), gain.shape)
        if gain[start, end] < 1e-9:
            break
        path[start + 1 : end + 2] = path[start + 1 : end + 2][::-1].copy()
    return path[1:-1]
