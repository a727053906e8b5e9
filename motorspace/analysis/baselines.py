"""The reference rows of every error table."""

import jax.numpy as jnp
from jaxtyping import Array, Float

from motorspace.trajectories.transitions import Experience


def mean_squared_error(predicted: Float[Array, "*N K"], true: Float[Array, "N K"]) -> float:
    """Mean over trajectories and sensors of the squared error, raw units squared."""
    return float(jnp.mean((predicted - true) ** 2))


def persistence_error(experience: Experience) -> float:
    """Error of predicting that the sensors stay as they are."""
    return mean_squared_error(experience.sensors, experience.later_sensors)


def mean_error(experience: Experience, mean: Float[Array, " K"]) -> float:
    """Error of always predicting `mean`, the average sensors of the training data."""
    return mean_squared_error(mean, experience.later_sensors)


def skill(error: float, persistence: float) -> float:
    """1 - error / persistence: 1 is perfect, 0 no better than predicting no change."""
    return 1.0 - error / persistence
