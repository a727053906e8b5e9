"""What training minimises: one function per loss, on a batch."""

import jax
import jax.numpy as jnp
from jaxtyping import Array, Float

from motorspace._types import Scalar
from motorspace.models.model import Model
from motorspace.trajectories import Experience

Codes = Float[Array, "N C"]


def prediction_loss(model: Model, batch: Experience, codes: Codes) -> Scalar:
    """Mean squared error of the predicted sensors, as shares of the sensors' scale.

    mean || s_{t+T} - prediction(s_t, h^m) ||^2 / K (section 3).
    """
    predicted = jax.vmap(model.predict)(batch.sensors, codes)
    error = (predicted - batch.later_sensors) / jnp.array(model.scaling.sensors)
    return jnp.mean(error**2)


def inverse_loss(model: Model, batch: Experience, codes: Codes) -> Scalar:
    """Mean squared distance of the code from what the inverse model makes of the sensors.

    mean || h^m - inverse(s_t, s_{t+T}) ||^2 / C, relative to the codes' own variance, so that
    shrinking every code to a constant does not lower it (section 4.1 gives no normalisation).
    """
    if model.inverse is None:
        return jnp.zeros(())
    scale = jnp.array(model.scaling.sensors)
    inferred = jax.vmap(model.inverse)(batch.sensors / scale, batch.later_sensors / scale)
    return jnp.mean((codes - inferred) ** 2) / (code_variance(codes) + 1e-6)


def code_variance(codes: Codes) -> Scalar:
    """Variance of the codes, averaged over their units: zero for a collapsed encoder."""
    return jnp.mean(jnp.var(codes, axis=0))


def encode_all(model: Model, experience: Experience) -> Codes:
    """The codes of every transition."""
    return jax.vmap(model.encode)(experience.motors, experience.num_steps)
