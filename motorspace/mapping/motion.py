"""What odometry gets wrong, as a function of the motion itself, and how uncertain it is then.

Displacements that matching measures between neighbouring moments say by how much odometry is off:
a bias of the motors, a wheel that is larger than the other. What is left is noise of several
sources, most of which grow with the motion. No pose is needed for either.
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
LEAST = np.array([1e-3, 1e-3, 1e-4])
"""Standard deviations that are never undercut: of shifts, as a share of the reach, and of turns."""
ENTRIES = np.triu_indices(3)
"""Entries of a symmetric matrix that say all of it."""
TWICE = np.where(ENTRIES[0] == ENTRIES[1], 1.0, np.sqrt(2.0))
"""What they are multiplied by, so that those beside the diagonal count twice."""


class Motion(NamedTuple):
    """How displacements by odometry differ from the true ones.

    Args:
        twist: From `terms` of a displacement to the twist that it lacks, [6, 3].
        strength: Squared strength of each of the `sources` of what is then left, [12].
        reach: The largest reading, which is the unit of lengths.
    """

    twist: Float[np.ndarray, "6 3"]
    strength: Float[np.ndarray, "12"]
    reach: float

    def corrected(self, steps: Steps) -> Steps:
        """Displacements without what is known to be wrong."""
        twist = terms(steps, self.reach) @ self.twist
        return np.asarray(compose(steps, exponential(twist * self._scale)))

    def covariance(self, steps: Steps) -> Float[np.ndarray, "S 3 3"]:
        """The covariance of corrected displacements, in the frame of their ends."""
        covariance = _covariance(_products(sources(steps, self.reach)), self.strength)
        return covariance * np.outer(self._scale, self._scale)

    @property
    def _scale(self) -> Float[np.ndarray, "3"]:
        return np.array([self.reach, self.reach, 1.0])


def terms(steps: Steps, reach: float) -> Float[np.ndarray, "S 6"]:
    """What corrections are linear in: a constant, the displacement, and how large it is."""
    x, y, angle = steps / np.array([[reach], [reach], [1.0]])
    return np.stack([np.ones_like(x), x, y, angle, np.hypot(x, y), np.abs(angle)], axis=-1)


def sources(steps: Steps, reach: float) -> Float[np.ndarray, "S 12 3"]:
    """The twists, in the frame of their ends, that noise of unit strength adds to displacements.

    Noise at the end in x, in y and in the angle, and in the angle at the beginning, which swings
    the whole displacement; each constant, proportional to the length, and to the turn.
    """
    scaled = np.asarray(steps / np.array([[reach], [reach], [1.0]]))
    ones = np.ones(scaled.shape[1])
    sizes = np.stack([ones, np.hypot(scaled[0], scaled[1]), np.abs(scaled[2])], axis=1)
    at_end = np.broadcast_to(np.eye(3), (len(ones), 3, 3))
    at_beginning = adjoint(np.asarray(inverse(scaled)))[:, :, 2]
    ways = np.concatenate([at_end, at_beginning[:, None]], axis=1)
    return (sizes[:, :, None, None] * ways[:, None]).reshape(len(ones), -1, 3)


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
    return Motion(twist, _strengths(sources(steps, reach), off - known @ twist), reach)


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
        noise = _spread(off - known @ twist)
    return twist


def _strengths(
    known: Float[np.ndarray, "S 12 3"], left: Float[np.ndarray, "S 3"]
) -> Float[np.ndarray, "12"]:
    """Squared strengths whose covariances are nearest to the squared residuals.

    Least squares without negative strengths, each step weighted by the covariance that it has
    after the round before.
    """
    products = _products(known)
    covariance = np.broadcast_to(np.diag(_spread(left) ** 2), (len(left), 3, 3))
    strength = np.zeros(known.shape[1])
    for _ in range(ROUNDS):
        whitening = np.linalg.inv(np.linalg.cholesky(covariance))
        residual = np.einsum("sab,sb->sa", whitening, left)
        size = np.sum(residual**2, axis=1)
        residual /= np.sqrt(np.maximum(size / LIMIT**2, 1.0))[:, None]
        across = np.swapaxes(whitening, -1, -2)
        least = whitening @ np.diag(LEAST**2) @ across
        wanted = _entries(residual[:, :, None] * residual[:, None] - least)
        offered = _entries(whitening[:, None] @ products @ across[:, None])
        equations = np.moveaxis(offered, 1, -1).reshape(-1, known.shape[1])
        strength = _not_negative(equations, wanted.reshape(-1))
        covariance = _covariance(products, strength)
    return strength


def _spread(left: Float[np.ndarray, "S 3"]) -> Float[np.ndarray, "3"]:
    """Standard deviations of residuals of which some are wrong, by their median."""
    return np.maximum(LEAST, 1.4826 * np.median(np.abs(left), axis=0))


def _not_negative(
    equations: Float[np.ndarray, "E U"], wanted: Float[np.ndarray, " E"]
) -> Float[np.ndarray, " U"]:
    """Least squares without negative unknowns, of many equations: by their normal equations."""
    normal = equations.T @ equations
    size = normal.shape[0]
    root = np.linalg.cholesky(normal + 1e-9 * np.trace(normal) / size * np.eye(size)).T
    return np.asarray(nnls(root, np.linalg.solve(root.T, equations.T @ wanted))[0])


def _entries(symmetric: Float[np.ndarray, "*batch 3 3"]) -> Float[np.ndarray, "*batch 6"]:
    return symmetric[..., ENTRIES[0], ENTRIES[1]] * TWICE


def _products(known: Float[np.ndarray, "S U 3"]) -> Float[np.ndarray, "S U 3 3"]:
    return known[..., :, None] * known[..., None, :]


def _covariance(
    products: Float[np.ndarray, "S U 3 3"], strength: Float[np.ndarray, " U"]
) -> Float[np.ndarray, "S 3 3"]:
    return np.asarray(np.einsum("u,suab->sab", strength, products) + np.diag(LEAST**2))


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
