"""What odometry gets wrong, as a function of the motion itself, and how uncertain it is then.

Displacements that matching measures between neighbouring moments say by how much odometry is off:
a bias of the motors, a wheel that is larger than the other. What is left is noise, whose
variance grows with the motion. No pose is needed for either.
"""

from typing import NamedTuple

import numpy as np
from jaxtyping import Float
from scipy.optimize import nnls

from motorspace.mapping.matching import Matches
from motorspace.mapping.weighted import Equations
from motorspace.se2 import adjoint, compose, exponential, inverse, logarithm, relative

Steps = Float[np.ndarray, "3 S"]

ROUNDS, FITS = 20, 2
LIMIT = 5.0
"""Standard deviations beyond which a residual is cut off."""
MOST_ALIKE = 0.99
"""Correlations are taken for a little less, which keeps covariances regular."""
LEAST = np.array([1e-3, 1e-3, 1e-4])
"""Standard deviations that are never undercut: of shifts, as a share of the reach, and of turns."""


class Motion(NamedTuple):
    """How displacements by odometry differ from the true ones.

    Args:
        twist: From `terms` of a displacement to the twist that it lacks, [6, 3].
        variance: From its squared `sizes` to the variances of what is then left, [3, 3].
        correlation: Of what is left, among x, y and angle: who turns first slips sideways, [3, 3].
        reach: The largest reading, which is the unit of lengths.
    """

    twist: Float[np.ndarray, "6 3"]
    variance: Float[np.ndarray, "3 3"]
    correlation: Float[np.ndarray, "3 3"]
    reach: float

    def corrected(self, steps: Steps) -> Steps:
        """Displacements without what is known to be wrong."""
        twist = terms(steps, self.reach) @ self.twist
        return np.asarray(compose(steps, exponential(twist * self._scale)))

    def covariance(self, steps: Steps) -> Float[np.ndarray, "S 3 3"]:
        """The covariance of corrected displacements, in the frame of their ends."""
        deviation = self.deviations(steps) * self._scale
        return deviation[:, :, None] * self.correlation * deviation[:, None]

    def deviations(self, steps: Steps) -> Float[np.ndarray, "S 3"]:
        """Standard deviations of corrected displacements: shares of the reach, radians."""
        return np.asarray(np.sqrt(sizes(steps, self.reach) @ self.variance + LEAST**2))

    @property
    def _scale(self) -> Float[np.ndarray, "3"]:
        return np.array([self.reach, self.reach, 1.0])


def terms(steps: Steps, reach: float) -> Float[np.ndarray, "S 6"]:
    """What corrections are linear in: a constant, the displacement, and how large it is."""
    x, y, angle = steps / np.array([[reach], [reach], [1.0]])
    return np.stack([np.ones_like(x), x, y, angle, np.hypot(x, y), np.abs(angle)], axis=-1)


def sizes(steps: Steps, reach: float) -> Float[np.ndarray, "S 3"]:
    """What variances are linear in: a constant, the squared length, the squared turn."""
    x, y, angle = steps / np.array([[reach], [reach], [1.0]])
    return np.stack([np.ones_like(x), x**2 + y**2, angle**2], axis=-1)


def fit_motion(steps: Steps, measured: Matches, *, reach: float, correct: bool = True) -> Motion:
    """How odometry is off, where displacements have been measured.

    Args:
        steps: By odometry, [3, S].
        measured: The same displacements as matching has them, S of them.
        reach: The largest reading.
        correct: Whether there is a correction; else there is noise alone.
    """
    scale = np.array([reach, reach, 1.0])
    off = logarithm(np.asarray(relative(steps, measured.displacement))) / scale
    doubt = measured.covariance(reach=reach)
    known = terms(steps, reach)
    twist = _correction(known, off, doubt) if correct else np.zeros((known.shape[1], 3))
    left = off - known @ twist
    motion = Motion(twist, _variances(sizes(steps, reach), left), np.eye(3), reach)
    return motion._replace(correlation=_correlation(left / motion.deviations(steps)))


def _correction(
    known: Float[np.ndarray, "S 6"],
    off: Float[np.ndarray, "S 3"],
    doubt: Float[np.ndarray, "S 3 3"],
) -> Float[np.ndarray, "6 3"]:
    """What is off on average, by matches that are as certain as their walls, and by motion's noise.

    How large the noise is comes out of the fit.
    """
    equations = np.einsum("su,ab->saub", known, np.eye(3)).reshape(len(off), 3, -1)
    noise = LEAST
    for _ in range(FITS):
        information = np.linalg.inv(doubt + np.diag(noise**2))
        twist = Equations(equations, off, information).fitted().reshape(-1, 3)
        noise = np.maximum(LEAST, 1.4826 * np.median(np.abs(off - known @ twist), axis=0))
    return twist


def _variances(
    known: Float[np.ndarray, "S 3"], left: Float[np.ndarray, "S 3"]
) -> Float[np.ndarray, "3 3"]:
    """Variances that are sums of squares, by weighted least squares on squared residuals."""
    found = np.zeros((known.shape[1], 3))
    for axis in range(3):
        typical = (1.4826 * np.median(np.abs(left[:, axis]))) ** 2 + 1e-12
        expected = np.full(len(left), typical)
        for _ in range(ROUNDS):
            squared = np.minimum(left[:, axis] ** 2, LIMIT**2 * expected)
            found[:, axis], _ = nnls(known / expected[:, None], squared / expected)
            expected = known @ found[:, axis] + 1e-12
    return found


def _correlation(left: Float[np.ndarray, "S 3"]) -> Float[np.ndarray, "3 3"]:
    """Correlations of standardised residuals, of which some are wrong."""
    sizes_squared = np.sum(left**2, axis=1)
    rows = left / np.sqrt(np.maximum(sizes_squared / LIMIT**2, 1.0))[:, None]
    products = rows.T @ rows + 1e-9 * np.eye(3)
    scale = np.sqrt(np.diagonal(products))
    return np.asarray(MOST_ALIKE * products / np.outer(scale, scale) + (1 - MOST_ALIKE) * np.eye(3))


def chained(steps: Steps) -> Float[np.ndarray, "3 N"]:
    """Where displacements in a row lead from (0, 0, 0) on."""
    frames = [np.zeros(3)]
    for step in steps.T:
        frames.append(np.asarray(compose(frames[-1], step)))
    return np.stack(frames, axis=1)


def chained_covariance(
    steps: Steps, covariance: Float[np.ndarray, "S 3 3"], *, gap: int
) -> Float[np.ndarray, "W 3 3"]:
    """The covariance of displacements over `gap` steps, in the frames of their ends.

    Args:
        steps: Displacements in a row, [3, S].
        covariance: Of each, in the frame of its own end, [S, 3, 3].
        gap: Steps of a window, at most S.
    """
    num = steps.shape[1] - gap + 1
    total = np.zeros((num, 3, 3))
    for index in range(gap):
        rows = slice(index, index + num)
        carried = adjoint(np.asarray(inverse(steps[:, rows])))
        total = carried @ total @ np.swapaxes(carried, -1, -2) + covariance[rows]
    return total
