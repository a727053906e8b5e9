"""How many dimensions do codes fill?"""

import numpy as np
from jaxtyping import Float

from motorspace.analysis.coordinates import Points


def intrinsic_dimension(codes: Points) -> float | None:
    """TwoNN (Facco et al., 2017): the dimension in which two nearest neighbours lie as they do.

    Needs the extra `topology`. Equal codes count once. None for fewer than a hundred.
    """
    import skdim

    different = np.unique(np.round(codes / codes.std(), 9), axis=0)
    return float(skdim.id.TwoNN().fit(different).dimension_) if len(different) >= 100 else None


def participation_ratio(codes: Points) -> float:
    """(sum l)^2 / sum l^2 over the eigenvalues l of the codes' covariance: 1 for a line."""
    power = _powers(codes)
    return float(power.sum() ** 2 / (power**2).sum())


def components_for(codes: Points, *, share: float = 0.95) -> int:
    """The fewest principal components that hold this share of the variance."""
    power = np.cumsum(_powers(codes))
    return int(np.searchsorted(power, share * power[-1] * (1 - 1e-12))) + 1


def _powers(codes: Points) -> Float[np.ndarray, " P"]:
    from sklearn.decomposition import PCA

    return np.asarray(PCA().fit(codes).explained_variance_)
