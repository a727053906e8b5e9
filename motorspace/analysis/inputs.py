"""What anybody hands in, checked before anything is measured on it."""

import warnings

import numpy as np
from jaxtyping import Float, Int
from numpy.typing import ArrayLike

from motorspace._errors import UserError
from motorspace.analysis.coordinates import Points

FEWEST_POINTS = 100
LARGEST, SMALLEST = 1e50, 1e-50
"""Beyond these, products of squared distances leave the range of float64."""
ORDINARY = 1e4
"""Codes that spread by less, and by more than its inverse, are measured as they are."""
ROUNDED = 16
"""Codes that vary by no more than this many roundings do not vary."""
SHARE_IN_DEGREES = 0.1
"""Share of turns beyond a full one from which on they look like degrees."""


class CollapsedCodesError(UserError):
    """The codes are all the same: there is nothing to measure."""


def checked(
    codes: ArrayLike, displacements: ArrayLike, motors: ArrayLike | None
) -> tuple[Points, Float[np.ndarray, "N 3"], Points | None]:
    """Returns codes, displacements and motors in float64, one row for each sequence.

    Warns of displacements that look like degrees.

    Args:
        codes: [N, ...] numbers.
        displacements: [N, 3]: longitudinal, lateral (world units), orientation change (radians).
        motors: [N, ...] numbers, or None.

    Raises:
        CollapsedCodesError: For codes that are all the same.
        UserError: For other shapes and types, rows that do not belong together, too few of them,
            values that are not finite or out of range, and displacements that do not vary.
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
            f"{len(h)} points are too few to measure", remedy=f"give at least {FEWEST_POINTS:,}"
        )
    _check_variation(h, d)
    _warn_of_degrees(d[:, 2])
    return h, d, m


def checked_groups(groups: ArrayLike, num: int) -> Int[np.ndarray, " N"]:
    """Returns the number of each code's group.

    Args:
        groups: [N] whole numbers, negative for codes of no group.
        num: How many codes there are.

    Raises:
        UserError: Unless there is one whole number for each code.
    """
    labels = np.asarray(groups)
    if labels.shape != (num,) or not np.issubdtype(labels.dtype, np.integer):
        raise UserError(
            f"the groups are {labels.dtype} of shape {labels.shape}",
            remedy=f"give one whole number for each of the {num:,} codes",
        )
    return labels


def checked_options(weight: float | None, subsets: int, seed: int) -> None:
    """Checks the options of `topology`. Raises `UserError` for those that cannot be used."""
    if weight is not None and not 0 < weight < np.inf:
        raise UserError(
            f"weight must be positive, got {weight}",
            remedy="give the world units that a unit of (cos, sin) counts for, or leave it out",
        )
    for name, value, least in (("subsets", subsets, 1), ("seed", seed, 0)):
        if value < least:
            raise UserError(f"{name} must be at least {least}, got {value}")


def moderate(codes: Points) -> tuple[Points, float]:
    """Returns codes whose spread is near 1, and by what they were divided.

    What is measured does not depend on scale, but the guards against divisions by zero do. Codes
    of an ordinary scale are returned as they are.
    """
    spread = float(np.ptp(codes, axis=0).max())
    if 1 / ORDINARY < spread < ORDINARY:
        return codes, 1.0
    scale = 2.0 ** np.round(np.log2(spread))  # a power of two: dividing by it rounds nothing
    return codes / scale, float(scale)


def resolution(values: Points) -> float:
    """Returns the spacing of floating-point numbers at the largest magnitude of `values`.

    In float32 if all of them are such numbers, whatever type holds them now.
    """
    with np.errstate(over="ignore", under="ignore"):
        single = np.array_equal(values, values.astype(np.float32))
    return float(np.finfo(np.float32 if single else np.float64).eps * np.abs(values).max())


def _rows(values: ArrayLike, name: str) -> Points:
    """One row of float64 for each sequence."""
    array = _numbers(values, name)
    if array.ndim < 2:
        what = f"have the shape {array.shape}" if array.ndim else "are a single number"
        raise UserError(
            f"the {name} {what}",
            remedy="give one row for every sequence; a single column has the shape (N, 1)",
        )
    if array.size == 0:
        raise UserError(
            f"the {name} are empty, of shape {array.shape}",
            remedy="give one row of numbers for every sequence",
        )
    array = array.reshape(len(array), -1)
    if not np.isfinite(array).all():
        row, column = np.argwhere(~np.isfinite(array))[0]
        raise UserError(
            f"the {name} hold {array[row, column]} in row {row}, column {column}",
            remedy="remove the rows that are not finite",
        )
    if (largest := float(np.abs(array).max())) > LARGEST:
        raise UserError(
            f"the {name} hold values as large as {largest:.0e}, whose distances overflow",
            remedy="check that training has not diverged, or divide them by a constant",
        )
    return array


def _numbers(values: ArrayLike, name: str) -> np.ndarray:
    try:
        array = np.asarray(values)
        if np.ma.is_masked(values):
            array = np.ma.asarray(values, np.float64).filled(np.nan)
    except (TypeError, ValueError, RuntimeError) as error:  # as other libraries' arrays raise
        reason = str(error).partition("\n")[0]
        raise UserError(
            f"the {name} are no array ({reason})", remedy="give rows of equally many numbers"
        ) from None
    if array.dtype.kind not in "fiub":
        kind = "complex numbers" if array.dtype.kind == "c" else f"{array.dtype}, not real numbers"
        remedy = "give real numbers, for example array.astype(float)"
        if array.dtype.kind == "c":
            remedy = "give real and imaginary parts as columns of their own"
        raise UserError(f"the {name} hold {kind}", remedy=remedy)
    with np.errstate(over="ignore"):  # a long double that is too large is infinite, and refused
        return array.astype(np.float64)


def _check_variation(h: Points, d: Float[np.ndarray, "N 3"]) -> None:
    spread = float(np.ptp(h, axis=0).max())
    if spread <= ROUNDED * resolution(h):
        raise CollapsedCodesError(
            "the codes are all the same",
            remedy="check that the encoder has not collapsed, and which columns were read",
        )
    if spread < SMALLEST:
        raise UserError(
            f"the codes differ by {spread:.0e} at most, whose squares underflow",
            remedy="multiply them by a constant",
        )
    if not np.ptp(d, axis=0).any():
        raise UserError(
            "the displacements are all the same", remedy="check which columns were read"
        )


def _warn_of_degrees(turns: Float[np.ndarray, " N"]) -> None:
    share = float((np.abs(turns) > 2 * np.pi).mean())
    if share > SHARE_IN_DEGREES:
        warnings.warn(
            f"{share:.0%} of the orientation changes are more than a full turn (2 pi): they are"
            " measured as radians; if they are degrees, convert them with numpy.radians",
            UserWarning,
            stacklevel=4,
        )
