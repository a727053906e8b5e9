"""Codes seen along a few directions."""

from dataclasses import dataclass

import numpy as np
from jaxtyping import Array, Float


@dataclass(frozen=True)
class Projection:
    """Coordinates of N codes on their first principal components."""

    coordinates: Float[np.ndarray, "N P"]
    explained_variance_ratio: Float[np.ndarray, " P"]


def pca(codes: Float[Array | np.ndarray, "N C"], num_components: int = 3) -> Projection:
    """Returns codes [N, C] on their principal components, largest variance first.

    Each component's sign makes its largest loading positive, so that two calls agree.

    Args:
        codes: [N, C].
        num_components: How many; codes of fewer units have as many as units.
    """
    x = np.asarray(codes, np.float64)
    centred = x - x.mean(axis=0)
    _, singular, directions = np.linalg.svd(centred, full_matrices=False)
    kept = directions[:num_components]
    largest = np.abs(kept).argmax(axis=1)
    kept = kept * np.sign(kept[np.arange(len(kept)), largest])[:, None]
    power = singular**2
    ratio = power / power.sum() if power.sum() > 0 else np.zeros_like(power)
    return Projection(centred @ kept.T, ratio[:num_components])


def ica(
    codes: Float[Array | np.ndarray, "N C"], num_components: int = 3, *, seed: int = 0
) -> Float[np.ndarray, "N P"]:
    """Returns independent components [N, P] of codes, of unit variance.

    FastICA (Hyvärinen and Oja, 2000).

    Args:
        codes: [N, C].
        num_components: P.
        seed: Seed of its first guess.
    """
    from sklearn.decomposition import FastICA

    separate = FastICA(num_components, random_state=seed, whiten="unit-variance", max_iter=1000)
    return np.asarray(separate.fit_transform(np.asarray(codes, np.float64)))
