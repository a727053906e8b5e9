"""Displacements as points."""

from typing import NamedTuple

import numpy as np
from jaxtyping import Array, Float

Numbers = Array | np.ndarray
Points = Float[np.ndarray, "N _"]
"""N points; of what dimension is free, and differs between those of one function."""

COMPONENTS = ("longitudinal", "lateral", "cos", "sin")


class Coordinates(NamedTuple):
    """Displacements as points whose Euclidean distances compare them."""

    points: Float[np.ndarray, "N 4"]
    """(longitudinal, lateral, w cos, w sin) of each displacement."""
    weight: float
    """The w by which orientation counts, world units."""


def displacement_coordinates(
    displacements: Float[Numbers, "N 3"], *, weight: float | None = None
) -> Coordinates:
    """Returns displacements as points (longitudinal, lateral, w cos, w sin).

    Args:
        displacements: [N, 3]: longitudinal, lateral (world units), orientation change (radians).
        weight: The w. By default cos and sin together have as much variance as the two
            translations, so that neither alone decides which displacements are near each other.

    Example:
        >>> displacement_coordinates(np.array([[1.0, 2.0, 0.0]]), weight=3.0).points
        array([[1., 2., 3., 0.]])
    """
    longitudinal, lateral, turn = np.asarray(displacements, np.float64).T
    translation = np.stack([longitudinal, lateral], axis=1)
    orientation = np.stack([np.cos(turn), np.sin(turn)], axis=1)
    if weight is None:
        weight = float(np.sqrt(_variance(translation) / _variance(orientation)))
    return Coordinates(np.concatenate([translation, weight * orientation], axis=1), weight)


def _variance(points: Points) -> float:
    return float(points.var(axis=0).sum()) or 1.0
