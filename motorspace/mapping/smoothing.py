"""The frames of one walk made consistent: the little that odometry still misses, from the walls.

A least-squares problem with three unknowns for each stretch of the walk (its shift and its turn),
which is sparse: rays tie a stretch to the walls, odometry ties it to the next one.
"""

from typing import NamedTuple

import numpy as np
import scipy.sparse as sparse
from jaxtyping import Float, Int
from scipy.sparse.linalg import spsolve

from motorspace.mapping.lines import fit_lines
from motorspace.mapping.mounting import SATURATED, Mounting
from motorspace.se2 import compose, relative


class Stretches(NamedTuple):
    """Rounds with stretches of one length; cells and tolerances in shares of the sensors' reach."""

    length: int
    """Steps of each stretch."""
    rounds: tuple[tuple[float, float], ...]
    """Side of the cells, and how far off a point is that counts a quarter."""
    slip: float
    """Standard deviation of what odometry misses over one stretch, share of the reach."""
    turn: float
    """The same for its rotation, radians."""


COARSE_TO_FINE = (
    Stretches(500, ((0.12, 0.04), (0.1, 0.03), (0.08, 0.02)), 0.01, 0.01),
    Stretches(100, ((0.1, 0.03), (0.08, 0.02), (0.06, 0.015), (0.06, 0.01)), 0.003, 0.003),
    Stretches(
        20,
        ((0.06, 0.015), (0.05, 0.01), (0.04, 0.01), (0.04, 0.005), *((0.03, 0.003),) * 4),
        0.001,
        0.001,
    ),
)
THIN = 10.0
FIRST, GROWTH = 500, 1.5
"""Steps that are made consistent first, and how many times as many next."""


def smoothed(
    eyes: Float[np.ndarray, "3 S"],
    sensors: Float[np.ndarray, "S K"],
    mounting: Mounting,
    levels: tuple[Stretches, ...] = COARSE_TO_FINE,
) -> Float[np.ndarray, "3 S"]:
    """Where the rays begin along one walk, so that the walls that they meet are thin.

    Args:
        eyes: The same as odometry has it, whose drift is small against the rooms.
        sensors: The readings there.
        mounting: Directions of the rays.
        levels: Stretches from long to short.
    """
    stop, num = min(FIRST, eyes.shape[1]), eyes.shape[1]
    while True:
        first = eyes[:, :stop]
        for level in levels:
            for cell, tolerance in level.rounds:
                sides = cell * mounting.reach, tolerance * mounting.reach
                step = _step(first, sensors[:stop], mounting, level, sides)
                first = _moved(first, step, level.length)
        # What follows goes on from where the walk is now known to have come.
        later = eyes[:, stop:]
        was, now = (np.broadcast_to(e[:, stop - 1, None], later.shape) for e in (eyes, first))
        eyes = np.concatenate([first, compose(now, relative(was, later))], axis=1)
        if stop == num:
            return eyes
        stop = min(round(GROWTH * stop), num)


def _step(
    eyes: Float[np.ndarray, "3 S"],
    sensors: Float[np.ndarray, "S K"],
    mounting: Mounting,
    level: Stretches,
    sides: tuple[float, float],
) -> Float[np.ndarray, "C 3"]:
    """Shift and turn of each stretch, about its middle."""
    cell, tolerance = sides
    met = sensors < SATURATED * mounting.reach
    points = mounting.ends(eyes, sensors)[:, met]
    lines = fit_lines(points, np.zeros(points.shape[1], int), cell=cell, tolerance=tolerance)
    weight = lines.weight * lines.usable(THIN) / tolerance**2
    stretch, middles = _stretches(eyes, level.length)
    of_point = stretch[np.nonzero(met)[0]]
    (dx, dy), normal = points - middles[:, of_point], lines.normal[:, lines.cells]
    rows = np.stack([*normal, normal[1] * dx - normal[0] * dy])
    num = middles.shape[1]

    def summed(values: Float[np.ndarray, " P"]) -> Float[np.ndarray, " C"]:
        return np.bincount(of_point, weight * values, num)

    blocks = np.array([[summed(a * b) for a in rows] for b in rows])
    downhill = np.stack([summed(row * lines.off) for row in rows], axis=-1)
    tied = _ties(eyes[:, level.length :: level.length], middles, level, mounting.reach)
    # Where a stretch sees no wall, and for the walk as a whole, nothing says where it is.
    normal_matrix = sparse.block_diag(list(np.moveaxis(blocks, -1, 0))) + tied.T @ tied
    normal_matrix = (normal_matrix + 1e-3 * sparse.eye(3 * num)).tocsc()
    return np.asarray(spsolve(normal_matrix, -downhill.reshape(-1))).reshape(-1, 3)


def _stretches(
    eyes: Float[np.ndarray, "3 S"], length: int
) -> tuple[Int[np.ndarray, " S"], Float[np.ndarray, "2 C"]]:
    """Which stretch each moment is in, and the middle of each."""
    stretch = np.arange(eyes.shape[1]) // length
    count = np.bincount(stretch)
    return stretch, np.stack([np.bincount(stretch, axis) / count for axis in eyes[:2]])


def _ties(
    joints: Float[np.ndarray, "3 J"],
    middles: Float[np.ndarray, "2 C"],
    level: Stretches,
    reach: float,
) -> sparse.csr_matrix:
    """Two stretches in a row move their joint alike, and turn alike."""
    num = middles.shape[1]
    joint = np.arange(num - 1)
    slip, turn = np.full(num - 1, 1 / (level.slip * reach)), np.full(num - 1, 1 / level.turn)
    entries = []
    for sign, stretch in ((1.0, joint + 1), (-1.0, joint)):
        dx, dy = joints[:2, : num - 1] - middles[:, stretch]
        entries += [
            (sign * slip, 3 * joint, 3 * stretch),
            (-sign * slip * dy, 3 * joint, 3 * stretch + 2),
            (sign * slip, 3 * joint + 1, 3 * stretch + 1),
            (sign * slip * dx, 3 * joint + 1, 3 * stretch + 2),
            (sign * turn, 3 * joint + 2, 3 * stretch + 2),
        ]
    values, rows, columns = (np.concatenate(part) for part in zip(*entries, strict=True))
    return sparse.csr_matrix((values, (rows, columns)), shape=(3 * (num - 1), 3 * num))


def _moved(
    eyes: Float[np.ndarray, "3 S"], steps: Float[np.ndarray, "C 3"], length: int
) -> Float[np.ndarray, "3 S"]:
    stretch, middles = _stretches(eyes, length)
    x, y, turn = steps[stretch].T
    dx, dy = eyes[:2] - middles[:, stretch]
    cos, sin = np.cos(turn), np.sin(turn)
    middle_x, middle_y = middles[:, stretch]
    return np.stack(
        [middle_x + x + cos * dx - sin * dy, middle_y + y + sin * dx + cos * dy, eyes[2] + turn]
    )
