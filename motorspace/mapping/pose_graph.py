"""Poses from displacements between them: sparse least squares with loops that may be wrong."""

from typing import NamedTuple

import numpy as np
import scipy.sparse as sparse
from jaxtyping import Float, Int
from scipy.sparse.linalg import splu

from motorspace.se2 import relative, wrap

STEPS = 30
SETTLED = 1e-6
"""Largest change of a step after which there is no further one."""
DOUBT = 4.0
"""Squared error, in standard deviations, from which on a measurement counts less than half."""


class Edges(NamedTuple):
    """Displacements that were measured between poses.

    Args:
        first: [E], the pose that they begin at.
        second: [E], the pose that they lead to.
        displacement: [3, E], the second pose in the frame of the first.
        information: [E, 3, 3], inverse covariance, in the frame of the second.
    """

    first: Int[np.ndarray, " E"]
    second: Int[np.ndarray, " E"]
    displacement: Float[np.ndarray, "3 E"]
    information: Float[np.ndarray, "E 3 3"]

    @classmethod
    def of(
        cls,
        pairs: Int[np.ndarray, "2 E"],
        displacement: Float[np.ndarray, "3 E"],
        information: Float[np.ndarray, "E 3 3"],
    ) -> "Edges":
        """Measurements between pairs of poses."""
        return cls(pairs[0], pairs[1], displacement, information)

    def errors(self, poses: Float[np.ndarray, "3 N"]) -> Float[np.ndarray, " E"]:
        """Squared error of each measurement, in standard deviations."""
        off = _off(self, poses)
        return np.einsum("ae,eab,be->e", off, self.information, off)

    def chosen(self, rows: np.ndarray) -> "Edges":
        """Some of them, by a mask or by indices."""
        first, second, displacement, information = self
        return Edges(first[rows], second[rows], displacement[:, rows], information[rows])

    def between(self, moments: Int[np.ndarray, " V"], certainty: float) -> "Edges":
        """The same between moments instead of their places in a list, as certain as said."""
        first, second, displacement, information = self
        return Edges(moments[first], moments[second], displacement, certainty * information)


def joined(*parts: Edges) -> Edges:
    """All measurements in one."""
    first, second, displacement, information = zip(*parts, strict=True)
    return Edges(
        np.concatenate(first),
        np.concatenate(second),
        np.concatenate(displacement, axis=1),
        np.concatenate(information),
    )


def optimised(
    trusted: Edges, doubted: Edges, poses: Float[np.ndarray, "3 N"]
) -> Float[np.ndarray, "3 N"]:
    """The poses that agree best with the measurements; the first one stays.

    Args:
        trusted: Measurements whose errors are as they say, such as odometry.
        doubted: Measurements of which some are wrong, such as matches (a Cauchy loss).
        poses: Where to begin, such as where the odometry leads.
    """
    poses = np.array(poses, np.float64)
    edges = joined(trusted, doubted)
    doubt = np.repeat([np.inf, DOUBT], [len(trusted.first), len(doubted.first)])
    for _ in range(STEPS):
        step = _step(edges, doubt, poses)
        poses = poses + step
        if np.abs(step).max() < SETTLED:
            break
    return np.stack([poses[0], poses[1], wrap(poses[2])])


def chordal(edges: Edges, num: int) -> Float[np.ndarray, "3 N"]:
    """Where to begin when odometry leads astray: directions first, then places, each linear.

    Directions as cosines and sines, whose chords are least squares (Martinec and Pajdla, 2007;
    Carlone et al., 2015).
    """
    rows = np.arange(len(edges.first))
    certainty = np.sqrt(edges.information[:, 2, 2])
    forward = sparse.csr_matrix((certainty, (rows, edges.second)), shape=(len(rows), num))
    turn = certainty * np.exp(1j * edges.displacement[2])
    back = sparse.csr_matrix((turn, (rows, edges.first)), shape=(len(rows), num))
    direction = _least_squares((forward - back).tocsc(), np.zeros(len(rows), complex), fixed=1.0)
    angle = np.angle(direction)
    certainty = np.sqrt(np.maximum(np.linalg.det(edges.information[:, :2, :2]), 0.0)) ** 0.5
    moved = (edges.displacement[0] + 1j * edges.displacement[1]) * np.exp(1j * angle[edges.first])
    difference = sparse.csr_matrix(
        (
            np.concatenate([certainty, -certainty]),
            (np.tile(rows, 2), np.concatenate([edges.second, edges.first])),
        ),
        shape=(len(rows), num),
    )
    place = _least_squares(difference.tocsc().astype(complex), certainty * moved, fixed=0.0)
    return np.stack([place.real, place.imag, angle])


def _least_squares(matrix: sparse.csc_matrix, wanted: np.ndarray, *, fixed: float) -> np.ndarray:
    """The unknowns of least squared errors, the first of which is known."""
    rest = matrix[:, 1:]
    wanted = wanted - matrix[:, [0]].toarray()[:, 0] * fixed
    adjoint = rest.conj().T
    normal = (adjoint @ rest + 1e-9 * sparse.eye(rest.shape[1])).tocsc()
    return np.append(np.array([fixed], complex), _solve(normal, adjoint @ wanted))


def _solve(normal: sparse.csc_matrix, wanted: np.ndarray) -> np.ndarray:
    options = {"SymmetricMode": True}
    factors = splu(normal, permc_spec="MMD_AT_PLUS_A", diag_pivot_thresh=0.0, options=options)
    return np.asarray(factors.solve(wanted))


def _off(edges: Edges, poses: Float[np.ndarray, "3 N"]) -> Float[np.ndarray, "3 E"]:
    """The second pose, in the frame in which it was measured to be."""
    moved = relative(poses[:, edges.first], poses[:, edges.second])
    return np.asarray(relative(edges.displacement, moved))


def _step(
    edges: Edges, doubt: Float[np.ndarray, " E"], poses: Float[np.ndarray, "3 N"]
) -> Float[np.ndarray, "3 N"]:
    """One Gauss-Newton step on all poses but the first."""
    num = poses.shape[1]
    off = _off(edges, poses)
    squared = np.einsum("ae,eab,be->e", off, edges.information, off)
    information = edges.information / (1 + squared / doubt)[:, None, None]
    by_first, by_second = _jacobians(edges, poses)
    blocks, downhill = [], np.zeros((num, 3))
    for rows, left in ((edges.first, by_first), (edges.second, by_second)):
        weighted = np.einsum("eab,eac->ebc", left, information)
        np.add.at(downhill, rows, np.einsum("ebc,ce->eb", weighted, off))
        blocks += [
            (rows, columns, weighted @ right)
            for columns, right in ((edges.first, by_first), (edges.second, by_second))
        ]
    axis = np.arange(3)
    values, row, column = (
        np.concatenate([block[part].reshape(-1) for block in _indexed(blocks, axis)])
        for part in range(3)
    )
    normal = sparse.csc_matrix((values, (row, column)), shape=(3 * num, 3 * num))
    free = normal[3:, 3:] + 1e-9 * sparse.eye(3 * num - 3)
    step = _solve(free.tocsc(), -downhill.reshape(-1)[3:])
    return np.append(np.zeros(3), step).reshape(-1, 3).T


def _indexed(
    blocks: list[tuple[np.ndarray, np.ndarray, np.ndarray]], axis: np.ndarray
) -> list[tuple[np.ndarray, np.ndarray, np.ndarray]]:
    found = []
    for rows, columns, values in blocks:
        row = np.broadcast_to((3 * rows[:, None] + axis)[:, :, None], values.shape)
        column = np.broadcast_to((3 * columns[:, None] + axis)[:, None, :], values.shape)
        found.append((values, row, column))
    return found


def _jacobians(
    edges: Edges, poses: Float[np.ndarray, "3 N"]
) -> tuple[Float[np.ndarray, "E 3 3"], Float[np.ndarray, "E 3 3"]]:
    """How the errors change with the first and with the second pose, each in world axes."""
    x, y, angle = poses[:, edges.first]
    dx, dy = poses[0, edges.second] - x, poses[1, edges.second] - y
    turned = angle + edges.displacement[2]
    cos, sin, zero = np.cos(turned), np.sin(turned), np.zeros_like(x)
    # The error is R(turned)^T (p_second - p_first) - R(measured turn)^T (measured shift).
    by_angle_x, by_angle_y = -sin * dx + cos * dy, -cos * dx - sin * dy
    first = [[-cos, -sin, by_angle_x], [sin, -cos, by_angle_y], [zero, zero, zero - 1]]
    second = [[cos, sin, zero], [-sin, cos, zero], [zero, zero, zero + 1]]
    return np.moveaxis(np.array(first), -1, 0), np.moveaxis(np.array(second), -1, 0)
