"""Networks of every kind with random weights: exporting needs no training."""

import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np

from motorspace.models.config import ModelConfig
from motorspace.models.model import Scaling, build_model
from motorspace.training.config import RunConfig
from motorspace.training.data import Simulated
from motorspace.training.run import Run
from motorspace.trajectories.transitions import Displacements, Experience, Trajectories

KINDS = (
    *("lstm", "gru", "linear", "attention", "matrix_product", "exponential"),
    *("sum", "mlp", "none", "identity"),
)
HORIZON, SCALING = 4, Scaling((10.0,) * 5, (2.5, 1.0))


def run_of(kind: str) -> Run:
    """A run whose every weight is random, also those that start at zero."""
    sizes = ModelConfig(encoder=kind, hidden_size=8, code_size=6, width_size=8, depth=1)
    model = build_model(sizes, SCALING, horizon=HORIZON, key=jax.random.key(0))
    rng = np.random.default_rng(1)
    arrays, rest = eqx.partition(model, eqx.is_array)
    shaken = jax.tree.map(
        lambda leaf: leaf + jnp.asarray(0.3 * rng.normal(size=leaf.shape), leaf.dtype), arrays
    )
    config = RunConfig(Simulated(layout="empty", horizon=HORIZON), sizes)
    return Run(config, eqx.combine(shaken, rest))


def sequences(num: int, horizon: int = HORIZON) -> tuple[np.ndarray, np.ndarray]:
    """Motors whose rows beyond the sequence are not zero, and the length of each sequence."""
    rng = np.random.default_rng(2)
    motors = rng.normal(size=(num, horizon, 2)).astype(np.float32)
    return motors, rng.integers(1, horizon, num, endpoint=True, dtype=np.int32)


def trajectories(num: int) -> Trajectories:
    """Random trajectories of the networks' shapes, not simulated."""
    motors, num_steps = sequences(num)
    rng = np.random.default_rng(3)
    sensors, later = rng.random((2, num, 5), np.float32) * 10
    moved = jnp.asarray(rng.random((num, 3), np.float32))
    experience = Experience(*map(jnp.asarray, (sensors, motors, num_steps, later)))
    return Trajectories(experience, Displacements(moved, moved))
