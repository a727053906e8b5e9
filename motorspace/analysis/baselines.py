"""The reference rows of every error table."""

import jax.numpy as jnp
from jaxtyping import Array, Float

from motorspace.trajectories.transitions import Experience, Trajectories


def mean_squared_error(predicted: Float[Array, "*N K"], true: Float[Array, "N K"]) -> float:
    """Returns the mean over trajectories and sensors of the squared error, raw units squared."""
    return float(jnp.mean((predicted - true) ** 2))


def persistence_error(experience: Experience) -> float:
    """Error of predicting that the sensors stay as they are."""
    return mean_squared_error(experience.sensors, experience.later_sensors)


def mean_error(experience: Experience, mean: Float[Array, " K"]) -> float:
    """Error of always predicting `mean`, the average sensors of the training data."""
    return mean_squared_error(mean, experience.later_sensors)


def skill(error: float, persistence: float) -> float:
    """Returns 1 - error / persistence: 1 is perfect, 0 no better than predicting no change."""
    return 1.0 - error / persistence


def with_displacement_as_motors(trajectories: Trajectories, reach: float) -> Experience:
    """The oracle's experience: one «command» that is the achieved displacement itself.

    (longitudinal / reach, lateral / reach, cos, sin of the orientation change): fitted with
    the identity encoder, it shows what the predictor could reach with a perfect code.
    """
    longitudinal, lateral, turn = trajectories.displacements.achieved.T
    features = jnp.stack(
        [longitudinal / reach, lateral / reach, jnp.cos(turn), jnp.sin(turn)], axis=-1
    )
    experience = trajectories.experience
    return Experience(
        sensors=experience.sensors,
        motors=features[:, None, :],
        num_steps=jnp.ones_like(experience.num_steps),
        later_sensors=experience.later_sensors,
    )
