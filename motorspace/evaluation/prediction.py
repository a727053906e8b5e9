"""Prediction error over many fresh transitions, beside baselines that ignore the motors."""

from collections.abc import Callable

import jax
import jax.numpy as jnp
from jaxtyping import Array, Float

from motorspace._types import Key
from motorspace.trajectories.transitions import Experience

CHUNK_SIZE = 8000
"""Transitions measured at once; whoever draws as many shares the compiled sampler."""

Metrics = dict[str, float | int]
"""{key of a measure: number}; counts are whole."""


def mean_squared_error(predicted: Float[Array, "*N K"], true: Float[Array, "N K"]) -> float:
    """Mean over transitions and sensors of the squared error, raw units squared."""
    return float(jnp.mean((predicted - true) ** 2))


def persistence_error(experience: Experience) -> float:
    """Error of predicting that the sensors stay as they are."""
    return mean_squared_error(experience.sensors, experience.later_sensors)


def mean_error(experience: Experience, mean: Float[Array, " K"]) -> float:
    """Error of always predicting `mean`, the average sensors of other data."""
    return mean_squared_error(mean[None], experience.later_sensors)


def with_skill(errors: Metrics) -> Metrics:
    """The same with the skill, 1 - error / persistence: 1 is perfect, 0 predicts no change.

    Without it where the sensors never change.
    """
    if errors["prediction.persistence"] == 0:
        return errors
    ratio = errors["prediction.error"] / errors["prediction.persistence"]
    return errors | {"prediction.skill": 1.0 - ratio}


def prediction_errors(
    predict: Callable[[Experience], Float[Array, "N K"]],
    draw: Callable[[Key, int], Experience],
    *,
    num: int,
    key: Key,
) -> Metrics:
    """Mean squared errors of `predict` and of baselines on the same fresh transitions.

    Works through chunks, so that memory does not grow with `num`.

    Args:
        predict: From transitions to the expected sensors, raw units.
        draw: `draw(key, count)` gives fresh transitions.
        num: At least so many are measured on.
        key: Randomness of what is drawn.

    Returns:
        `prediction.error`, `.persistence` (no change), `.mean` (the sensors' mean, estimated on
        other transitions), raw units squared; `.skill` and `.num`.
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
    names = ("prediction.error", "prediction.persistence", "prediction.mean")
    errors = {name: total / chunks for name, total in zip(names, sums, strict=True)}
    return with_skill(errors | {"prediction.num": float(chunk * chunks)})
