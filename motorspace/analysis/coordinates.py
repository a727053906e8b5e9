"""Displacements and codes as points, checked before anything is measured on them."""

from typing import NamedTuple

import numpy as np
from jaxtyping import Array, Float
from numpy.typing import ArrayLike

from motorspace._errors import UserError

Numbers = Array | np.ndarray
Points = Float[np.ndarray, "N _"]
"""N points; of what dimension is free, and differs between those of one function."""

COMPONENTS = ("longitudinal", "lateral", "cos", "sin")
FEWEST_POINTS = 100


class DeadCodesError(UserError):
    """The codes are all the same: there is nothing to measure."""


class Coordinates(NamedTuple):
    """Displacements as points whose Euclidean distances compare them."""

    points: Float[np.ndarray, "N 4"]
    """(longitudinal, lateral, w cos, w sin) of each displacement."""
    weight: float
    """The w by which orientation counts, world units."""


def displacement_coordinates(
    displacements: Float[Numbers, "N 3"], *, weight: float | None = None
) -> Coordinates:
    """(longitudinal, lateral, w cos, w sin), by default with the w of equal variances.

    That w gives cos and sin together as much variance as the two translations have, so that
    neither alone decides which displacements are near each other.
    """
    longitudinal, lateral, turn = np.asarray(displacements, np.float64).T
    translation = np.stack([longitudinal, lateral], axis=1)
    orientation = np.stack([np.cos(turn), np.sin(turn)], axis=1)
    if weight is None:
        weight = float(np.sqrt(_variance(translation) / _variance(orientation)))
    return Coordinates(np.concatenate([translation, weight * orientation], axis=1), weight)


def _variance(points: Points) -> float:
    return float(points.var(axis=0).sum()) or 1.0


def checked(
    codes: ArrayLike, displacements: ArrayLike, motors: ArrayLike | None
) -> tuple[Points, Float[np.ndarray, "N 3"], Points | None]:
    """The same in float64, one row each.

    Raises `UserError` for another shape, for rows that do not belong together, for too few of
    them, for values that are not finite, and for what does not vary at all.
    """
    h = _rows(codes, "codes")
    d = _rows(displacements, "displacements")
    m = None if motors is None else _rows(motors, "motors")
    if d.shape[1] != 3:
        raise UserError(
            f"the displacements have {d.shape[1]} columns",
            remedy="give three: longitudinal, lateral, orientation change in radians",
        )
    for name, values in (("displacements", d), ("motors", m)):
        if values is not None and len(values) != len(h):
            raise UserError(
                f"there are {len(h):,} codes and {len(values):,} {name}",
                remedy="give one row of each for every sequence",
            )
    if len(h) < FEWEST_POINTS:
        raise UserError(
            f"{len(h)} points are too few to measure",
            remedy=f"give at least {FEWEST_POINTS:,}",
        )
    if not np.ptp(h, axis=0).any():
        raise DeadCodesError(
            "the codes are all the same",
            remedy="check that the encoder has not collapsed, or the columns that were read",
        )
    if not np.ptp(d, axis=0).any():
        raise UserError(
            "the displacements are all the same", remedy="check the columns that were read"
        )
    return h, d, m


def _rows(values: ArrayLike, name: str) -> Points:
    try:
        array = np.asarray(values, np.float64)
    except (TypeError, ValueError):
        raise UserError(f"the {name} are no numbers", remedy="give an array of numbers") from None
    if array.ndim < 2:
        raise UserError(
            f"the {name} have the shape {array.shape}", remedy="give one row for every sequence"
        )
    array = array.reshape(len(array), -1)
    if not np.isfinite(array).all():
        row, column = np.argwhere(~np.isfinite(array))[0]
        raise UserError(
            f"the {name} hold {array[row, column]} in row {row}, column {column}",
            remedy="remove the rows that are not finite",
        )
    return array
