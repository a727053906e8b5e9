"""How far a path is off the true one: absolute and relative errors, drift, coverage.

Paths are [3, N]: x, y and heading at every moment, in any frame. Definitions follow Sturm et al.
(2012): the absolute error after the best rigid alignment, and errors of displacements over windows.
"""

from typing import NamedTuple

import numpy as np
from jaxtyping import Float

from motorspace._errors import UserError
from motorspace.se2 import compose, relative

Path = Float[np.ndarray, "3 N"]

QUANTILES = {0.68: 3.5059, 0.95: 7.8147}
"""Squared distances, in standard deviations, within which so much of a normal distribution in
three dimensions lies."""


class Alignment(NamedTuple):
    """The motion of the plane that lays one path on another.

    Args:
        frame: x, y, angle, [3].
        scale: What lengths are multiplied by before; 1 of a rigid motion.
    """

    frame: Float[np.ndarray, "3"]
    scale: float

    def __call__(self, path: Path) -> Path:
        """The path, moved."""
        scaled = path * np.array([[self.scale], [self.scale], [1.0]])
        frame = np.broadcast_to(self.frame[:, None], path.shape)
        return np.asarray(compose(frame, scaled))


def alignment(path: Path, truth: Path, *, scaled: bool = False) -> Alignment:
    """The rigid motion, or similarity, that brings positions nearest to the true ones.

    Least squares (Umeyama, 1991); the headings do not count, and nothing is mirrored.

    Args:
        path: Estimated, [3, N].
        truth: At the same moments, [3, N].
        scaled: Whether lengths may be scaled, too. A path that has collapsed to a point then looks
            better than it is.

    Raises:
        UserError: For paths of different lengths, or of fewer than two moments.
    """
    _check(path, truth)
    place, wanted = (part[0] + 1j * part[1] for part in (path, truth))
    centre, target = place.mean(), wanted.mean()
    product = np.sum((wanted - target) * np.conj(place - centre))
    spread = np.sum(np.abs(place - centre) ** 2)
    scale = float(abs(product) / max(spread, 1e-12)) if scaled else 1.0
    angle = float(np.angle(product))
    shift = target - scale * centre * np.exp(1j * angle)
    return Alignment(np.array([shift.real, shift.imag, angle]), scale)


def aligned(path: Path, truth: Path, *, scaled: bool = False) -> Path:
    """The path, laid on the true one; see `alignment`."""
    return alignment(path, truth, scaled=scaled)(path)


def standing_still(truth: Path) -> Path:
    """The reference that odometry has to beat: the path that stays where it begins, [3, N]."""
    return np.repeat(truth[:, :1], truth.shape[1], axis=1)


def absolute_error(path: Path, truth: Path, *, scaled: bool = False) -> float:
    """The absolute trajectory error (ATE): root mean square distance after alignment.

    Args:
        path: Estimated, [3, N].
        truth: At the same moments, [3, N].
        scaled: Whether lengths may be scaled, too.

    Returns:
        World units.

    Raises:
        UserError: For paths of different lengths, or of fewer than two moments.

    Example:
        >>> truth = np.array([[0.0, 1.0, 2.0], [0.0, 0.0, 1.0], [0.0, 0.0, 0.0]])
        >>> round(absolute_error(truth + np.array([[3.0], [1.0], [0.0]]), truth), 6)
        0.0
    """
    off = aligned(path, truth, scaled=scaled)[:2] - truth[:2]
    return float(np.sqrt(np.mean(np.sum(off**2, axis=0))))


def relative_errors(path: Path, truth: Path, *, gap: int) -> Float[np.ndarray, "3 W"]:
    """Errors of the displacements over `gap` steps, each in the frame of its true end.

    Args:
        path: Estimated, [3, N].
        truth: At the same moments, [3, N].
        gap: Steps from the beginning of a displacement to its end.

    Returns:
        x, y and heading of the estimated end as seen from the true one, [3, N - gap].

    Raises:
        UserError: For paths of different lengths, or no longer than the gap.
    """
    _check(path, truth)
    if not 1 <= gap < path.shape[1]:
        raise UserError(
            f"a path of {path.shape[1]} moments has no displacement over {gap} steps",
            remedy="choose a gap from 1 to one less than the moments",
        )
    moved, should = (relative(part[:, :-gap], part[:, gap:]) for part in (path, truth))
    return np.asarray(relative(should, moved))


def relative_error(path: Path, truth: Path, *, gap: int) -> tuple[float, float]:
    """The relative pose error (RPE) over `gap` steps: root mean squares of shift and turn.

    Args:
        path: Estimated, [3, N].
        truth: At the same moments, [3, N].
        gap: Steps from the beginning of a displacement to its end.

    Returns:
        World units; radians.

    Raises:
        UserError: As `relative_errors` does.
    """
    x, y, angle = relative_errors(path, truth, gap=gap)
    return float(np.sqrt(np.mean(x**2 + y**2))), float(np.sqrt(np.mean(angle**2)))


def drift(path: Path, truth: Path) -> float:
    """How far the end is off, as a share of the true path, when the beginnings coincide.

    Args:
        path: Estimated, [3, N].
        truth: At the same moments, [3, N].

    Raises:
        UserError: For paths of different lengths, and a true path of length zero.
    """
    _check(path, truth)
    length = float(np.hypot(*np.diff(truth[:2], axis=1)).sum())
    if length == 0:
        raise UserError("the true path has no length", remedy="score a walk that moves")
    ends = (relative(part[:, 0], part[:, -1]) for part in (path, truth))
    estimated, true = ends
    return float(np.hypot(*(estimated[:2] - true[:2]))) / length


def coverage(
    errors: Float[np.ndarray, "3 W"], covariance: Float[np.ndarray, "W 3 3"]
) -> dict[float, float]:
    """How many errors lie in the ellipsoids that should hold 68 and 95 % of them.

    Args:
        errors: Of displacements, [3, W], as `relative_errors` returns them.
        covariance: What was claimed of each, [W, 3, 3], in the same frame.

    Returns:
        Shares, by what they should be.
    """
    solved = np.linalg.solve(covariance, errors.T[..., None])[..., 0]
    squared = np.einsum("aw,wa->w", errors, solved)
    return {share: float(np.mean(squared < bound)) for share, bound in QUANTILES.items()}


def _check(path: Path, truth: Path) -> None:
    if path.shape != truth.shape or path.shape[1] < 2:
        raise UserError(
            f"paths of shapes {path.shape} and {truth.shape} cannot be compared",
            remedy="give both as [3, N], at the same moments, of which there are at least two",
        )
