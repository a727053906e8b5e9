"""Is the code of two sequences in a row a function of their two codes?"""

import warnings

import numpy as np
from jaxtyping import Float
from sklearn.exceptions import ConvergenceWarning
from sklearn.linear_model import Ridge
from sklearn.neural_network import MLPRegressor
from sklearn.pipeline import make_pipeline
from sklearn.preprocessing import StandardScaler

from motorspace.analysis.coordinates import Points
from motorspace.analysis.projections import pca

NUM_BILINEAR = 20
"""Principal components of each code that enter its products with the other's."""


def composition_errors(first: Points, second: Points, both: Points) -> dict[str, float]:
    """Returns how well maps C(h(a), h(b)) = h(a b) do: E |C - h(a b)|^2 / Var h(a b), held out.

    C is fitted on the first half of the rows and tested on the other.

    Args:
        first: [N, C], the codes of sequences a.
        second: [N, C], the codes of sequences b.
        both: [N, C], the codes of each a followed by its b.

    Returns:
        The error of a `linear` map, of a `bilinear` one (with products of the codes' first
        `NUM_BILINEAR` principal components), and of a `network` of two layers. 0 is perfect, 1 no
        better than the mean.
    """
    reduced = [
        pca(codes, min(NUM_BILINEAR, codes.shape[1])).coordinates for codes in (first, second)
    ]
    products = np.einsum("ni,nj->nij", *reduced).reshape(len(first), -1)
    linear = np.concatenate([first, second], axis=1)
    features = {"linear": linear, "bilinear": np.concatenate([linear, products], axis=1)}
    errors = {}
    for name, inputs in features.items():
        errors[name] = _held_out(make_pipeline(StandardScaler(), Ridge(1e-3)), inputs, both)
    network = MLPRegressor(
        hidden_layer_sizes=(100, 100), early_stopping=True, max_iter=50, random_state=0
    )
    errors["network"] = _held_out(make_pipeline(StandardScaler(), network), linear, both)
    return errors


def _held_out(model: object, inputs: Points, targets: Points) -> float:
    """The mean squared error of a model on the second half, relative to the targets' variance."""
    half = len(inputs) // 2
    level, scale = targets[:half].mean(axis=0), targets[:half].std()
    with warnings.catch_warnings():
        # A fit that is stopped is one that does a little worse.
        warnings.simplefilter("ignore", ConvergenceWarning)
        model.fit(inputs[:half], (targets[:half] - level) / scale)  # type: ignore[attr-defined]
    predicted = model.predict(inputs[half:]) * scale + level  # type: ignore[attr-defined]
    residual = ((predicted.reshape(targets[half:].shape) - targets[half:]) ** 2).sum()
    return float(residual / ((targets[half:] - targets[half:].mean(axis=0)) ** 2).sum())


def congruence_error(composed: Points, exchanged: Points) -> float:
    """Returns E |h(a b) - h(a' b)| / E |h(a b) - h(c d)|, where a' has the code nearest to a's.

    Args:
        composed: [N, C], the codes h(a b), or h(b a) for the other side.
        exchanged: [N, C], the codes h(a' b), or h(b a').

    Returns:
        0 where a code holds all that matters of what goes before (or after), 1 where it holds
        nothing.
    """
    near = np.linalg.norm(composed - exchanged, axis=1).mean()
    far = np.linalg.norm(composed - np.roll(composed, 1, axis=0), axis=1).mean()
    return float(near / max(far, 1e-12))


def nearest_other(codes: Float[np.ndarray, "N C"]) -> np.ndarray:
    """Returns for every row of codes [N, C] the index of the nearest other one."""
    from sklearn.neighbors import NearestNeighbors

    return np.asarray(NearestNeighbors(n_neighbors=1).fit(codes).kneighbors(return_distance=False))[
        :, 0
    ]
