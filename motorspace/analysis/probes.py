"""Decoding displacements from codes."""

from collections.abc import Callable

import jax.numpy as jnp
import numpy as np
from jaxtyping import Float

from motorspace.analysis.coordinates import Numbers


def displacement_targets(displacements: Float[Numbers, "N 3"]) -> Float[Numbers, "N 4"]:
    """Returns (longitudinal, lateral, cos, sin of the orientation change) of each displacement."""
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
    """Returns R² [D] on the test rows of `linear_decoder` fitted on the others, per target.

    Args:
        codes: [N, C] to fit on.
        targets: [N, D] that belong to them.
        test_codes: [P, C] to test on.
        test_targets: [P, D] that belong to them.
        ridge: Strength of the regularisation, as in `linear_decoder`.
    """
    x_test, y_test = np.asarray(test_codes, np.float64), np.asarray(test_targets, np.float64)
    return jnp.asarray(explained(linear_decoder(codes, targets, ridge=ridge)(x_test), y_test))


def explained(
    decoded: Float[np.ndarray, "P D"], true: Float[np.ndarray, "P D"]
) -> Float[np.ndarray, " D"]:
    """Returns R² of each decoded column: 1 is perfect, 0 no better than the mean.

    Example:
        >>> true = np.array([[1.0], [2.0], [3.0]])
        >>> explained(true, true), explained(np.full((3, 1), 2.0), true)
        (array([1.]), array([0.]))
    """
    spread = ((true - true.mean(0)) ** 2).sum(0)
    return np.asarray(1.0 - ((true - decoded) ** 2).sum(0) / np.maximum(spread, 1e-12))


def linear_decoder(
    codes: Float[Numbers, "N C"], targets: Float[Numbers, "N D"], *, ridge: float = 1e-6
) -> Callable[[Float[np.ndarray, "P C"]], Float[np.ndarray, "P D"]]:
    """Returns the affine map from codes [N, C] to targets [N, D] that ridge regression finds.

    `ridge` is relative to the largest eigenvalue of the centred codes' covariance.
    """
    x, y = np.asarray(codes, np.float64), np.asarray(targets, np.float64)
    centre, level = x.mean(0), y.mean(0)
    gram = (x - centre).T @ (x - centre)
    strength = ridge * max(float(np.linalg.eigvalsh(gram)[-1]), 1e-12)
    weights = np.linalg.solve(gram + strength * np.eye(len(gram)), (x - centre).T @ (y - level))
    return lambda given: level + (given - centre) @ weights


def neighbour_probe(
    codes: Float[Numbers, "N C"],
    targets: Float[Numbers, "N D"],
    test_codes: Float[Numbers, "P C"],
    test_targets: Float[Numbers, "P D"],
    *,
    k: int = 10,
) -> Float[np.ndarray, " D"]:
    """Returns R² [D] on the test rows of the mean target of the `k` nearest codes of the others.

    Weighted by inverse distance. What this nonlinear probe decodes better than `linear_probe`
    does, the codes hold on a curved surface. Arguments as of `linear_probe`.
    """
    from sklearn.metrics import r2_score
    from sklearn.neighbors import KNeighborsRegressor

    fitted = KNeighborsRegressor(k, weights="distance").fit(np.asarray(codes), np.asarray(targets))
    predicted = fitted.predict(np.asarray(test_codes))
    return np.asarray(r2_score(np.asarray(test_targets), predicted, multioutput="raw_values"))
