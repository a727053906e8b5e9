"""Decoding displacements from codes, and how much codes vary."""

import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Float

Numbers = Array | np.ndarray
COMPONENTS = ("longitudinal", "lateral", "cos", "sin")


def displacement_targets(displacements: Float[Numbers, "N 3"]) -> Float[Numbers, "N 4"]:
    """(longitudinal, lateral, cos, sin of the orientation change) of each displacement."""
    longitudinal, lateral, turn = displacements.T
    return jnp.stack([longitudinal, lateral, jnp.cos(turn), jnp.sin(turn)], axis=-1)


def linear_probe(
    codes: Float[Numbers, "N C"],
    targets: Float[Numbers, "N D"],
    test_codes: Float[Numbers, "P C"],
    test_targets: Float[Numbers, "P D"],
    *,
    ridge: float = 1e-6,
) -> Float[Numbers, " D"]:
    """R2 on the test rows of ridge regression fitted on the others, per target.

    `ridge` is relative to the largest eigenvalue of the centred codes' covariance.
    """
    x, y = np.asarray(codes, np.float64), np.asarray(targets, np.float64)
    x_test, y_test = np.asarray(test_codes, np.float64), np.asarray(test_targets, np.float64)
    centre, level = x.mean(0), y.mean(0)
    gram = (x - centre).T @ (x - centre)
    strength = ridge * max(float(np.linalg.eigvalsh(gram)[-1]), 1e-12)
    weights = np.linalg.solve(gram + strength * np.eye(len(gram)), (x - centre).T @ (y - level))
    residual = y_test - level - (x_test - centre) @ weights
    spread = ((y_test - y_test.mean(0)) ** 2).sum(0)
    return jnp.asarray(1.0 - (residual**2).sum(0) / np.maximum(spread, 1e-12))


def within_to_total_variance(
    codes: Float[Numbers, "N C"], groups: Float[Numbers, "N ..."]
) -> float:
    """Share of the codes' variance that lies within groups of equal label; 0 is organised.

    A label is a row of `groups`, rounded to a thousandth. NaN for codes that do not vary.
    """
    x = np.asarray(codes, np.float64)
    labels = np.round(np.asarray(groups, np.float64).reshape(len(x), -1), 3) + 0.0
    _, index = np.unique(labels, axis=0, return_inverse=True)
    index = index.ravel()
    counts = np.bincount(index)
    means = np.stack([np.bincount(index, column) / counts for column in x.T], axis=-1)
    total = ((x - x.mean(0)) ** 2).sum()
    return float(((x - means[index]) ** 2).sum() / total) if total > 0 else float("nan")
