"""Prediction error over many fresh trajectories, beside what knows nothing of the motors."""

from collections.abc import Callable
from dataclasses import dataclass

import jax
import jax.numpy as jnp
from jaxtyping import Array, Float

from motorspace._types import Key
from motorspace.analysis.baselines import (
    mean_error,
    mean_squared_error,
    persistence_error,
    skill,
)
from motorspace.trajectories.transitions import Experience

CHUNK_SIZE = 8000
"""Trajectories measured at once; whoever draws as many shares the compiled sampler."""


@dataclass(frozen=True)
class PredictionErrors:
    """Mean squared errors per sensor, raw units squared, on the same trajectories."""

    num_trajectories: int
    model: float
    persistence: float
    """Predicting that the sensors stay as they are."""
    mean: float
    """Always predicting the sensors' mean, estimated on other trajectories."""
    skill: float
    """1 - model / persistence."""


def prediction_errors(
    predict: Callable[[Experience], Float[Array, "N K"]],
    draw: Callable[[Key, int], Experience],
    *,
    num: int,
    key: Key,
) -> PredictionErrors:
    """Errors of `predict` over at least `num` trajectories from `draw(key, count)`.

    Works through chunks, so that memory does not grow with `num`.
    """
    mean_key, test_key = jax.random.split(key)
    chunk = min(CHUNK_SIZE, num)
    mean = jnp.mean(draw(mean_key, chunk).later_sensors, axis=0)
    sums, chunks = [0.0, 0.0, 0.0], -(-num // chunk)
    for index in range(chunks):
        batch = draw(jax.random.fold_in(test_key, index), chunk)
        sums[0] += mean_squared_error(predict(batch), batch.later_sensors)
        sums[1] += persistence_error(batch)
        sums[2] += mean_error(batch, mean)
    model, persistence, level = (total / chunks for total in sums)
    return PredictionErrors(chunk * chunks, model, persistence, level, skill(model, persistence))
