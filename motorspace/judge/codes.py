"""What codes stand for: displacements in the frame and unit that calibration has made exact."""

from itertools import combinations_with_replacement
from typing import NamedTuple

import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Float

from motorspace._types import Key
from motorspace.mapping.calibration import Calibrated
from motorspace.training.data import simulated
from motorspace.training.run import Run

NUM_SEQUENCES = 3_000
"""Random sequences of each length, from one command to the horizon."""
DEGREE = 3
LEAST_SPREAD = 0.01
"""Directions of the code that vary less than this share of the largest are not blown up."""
RIDGE = 1e-3


class CodeBook(NamedTuple):
    """A polynomial from codes to displacements.

    Args:
        mean: [C], of the codes.
        spread: [C], what each unit is divided by.
        weights: [F, 4], from monomials to x, y, cos, sin.
        error: Root mean square of what is off: shift (the readings' unit) and turn (radians), [2].
    """

    mean: Float[np.ndarray, " C"]
    spread: Float[np.ndarray, " C"]
    weights: Float[np.ndarray, "F 4"]
    error: Float[np.ndarray, "2"]

    def read(self, codes: Float[Array | np.ndarray, "N C"]) -> Float[np.ndarray, "3 N"]:
        """The displacement of the sensors that each code stands for: x, y, angle."""
        known = _monomials((np.asarray(codes, np.float64) - self.mean) / self.spread)
        x, y, cos, sin = (known @ self.weights).T
        return np.stack([x, y, np.arctan2(sin, cos)])


def learn_codes(run: Run, body: Calibrated, *, key: Key) -> CodeBook:
    """What a run's codes stand for, from random sequences and the odometry of their commands."""
    data = simulated(run.config.data)
    commands = data.scenario().commands
    codes, displacements = [], []
    for length in range(1, data.horizon + 1):
        keys = jax.random.split(jax.random.fold_in(key, length), (NUM_SEQUENCES, data.horizon))
        motors = jax.vmap(jax.vmap(lambda k: commands.sample(key=k)))(keys)
        codes.append(run.encode(motors, jnp.full(NUM_SEQUENCES, length)))
        done = np.moveaxis(np.asarray(motors, np.float64)[:, :length], 0, 1)
        displacements.append(body.odometry.displacements(done))
    return fitted(np.concatenate(codes), np.concatenate(displacements, axis=1))


def fitted(
    codes: Float[Array | np.ndarray, "N C"], displacements: Float[np.ndarray, "3 N"]
) -> CodeBook:
    """The book that reads these codes as these displacements, by least squares."""
    codes = np.asarray(codes, np.float64)
    mean, spread = codes.mean(axis=0), codes.std(axis=0)
    spread = np.maximum(spread, LEAST_SPREAD * spread.max())
    x, y, angle = displacements
    targets = np.stack([x, y, np.cos(angle), np.sin(angle)], axis=-1)
    known = _monomials((codes - mean) / spread)
    normal = known.T @ known + RIDGE * np.eye(known.shape[1])
    book = CodeBook(mean, spread, np.linalg.solve(normal, known.T @ targets), np.zeros(2))
    off = book.read(codes) - displacements
    turn = np.angle(np.exp(1j * off[2]))
    error = [np.hypot(off[0], off[1]), turn]
    return book._replace(error=np.array([np.sqrt(np.mean(part**2)) for part in error]))


def _monomials(values: Float[np.ndarray, "N C"]) -> Float[np.ndarray, "N F"]:
    """Products of up to `DEGREE` units."""
    num, size = values.shape
    columns = [np.ones(num)]
    for degree in range(1, DEGREE + 1):
        for units in combinations_with_replacement(range(size), degree):
            columns.append(values[:, units].prod(axis=1))
    return np.stack(columns, axis=-1)
