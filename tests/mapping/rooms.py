"""A walk through a room of straight walls, in NumPy: what a mapper is given, and the truth."""

import numpy as np

from motorspace import se2
from motorspace.mapping.mounting import Mounting

REACH = 10.0
WALLS = np.array(
    [
        [[0, 0], [12, 0]],
        [[12, 0], [12, 9]],
        [[12, 9], [0, 9]],
        [[0, 9], [0, 0]],
        [[4, 0], [4, 3]],
        [[8, 9], [8, 5]],
        [[2, 6], [5, 6]],
    ],
    float,
)


def mounting(num_rays: int = 61) -> Mounting:
    return Mounting(np.linspace(-np.pi / 2, np.pi / 2, num_rays), np.zeros(2), REACH)


def ranges(poses: np.ndarray, angles: np.ndarray) -> np.ndarray:
    """Distances to the nearest wall, [N, K]."""
    x, y, heading = poses
    direction = np.exp(1j * (heading[:, None] + angles))
    place = (x + 1j * y)[:, None, None]
    start, end = (WALLS[:, side, 0] + 1j * WALLS[:, side, 1] for side in (0, 1))
    along, ray = (end - start)[None, None], direction[..., None]
    to_start = start[None, None] - place
    cross = (np.conj(ray) * along).imag
    with np.errstate(divide="ignore", invalid="ignore"):
        distance = (np.conj(to_start) * along).imag / cross
        share = (np.conj(to_start) * ray).imag / cross
    hit = (distance > 0) & (share >= 0) & (share <= 1)
    return np.minimum(np.where(hit, distance, np.inf).min(axis=-1), REACH)


def walk(num_steps: int = 160) -> np.ndarray:
    """Twice around the room, [3, N]."""
    time = np.linspace(0, 4 * np.pi, num_steps + 1)
    x, y = 6 + 4.2 * np.cos(time), 4.2 + 3.2 * np.sin(time) - 0.4 * np.cos(2 * time)
    heading = np.arctan2(np.gradient(y), np.gradient(x)) + 0.6 * np.sin(7 * time)
    return np.stack([x, y, np.asarray(se2.wrap(heading))])


def steps_of(poses: np.ndarray) -> np.ndarray:
    return np.asarray(se2.relative(poses[:, :-1], poses[:, 1:]))
