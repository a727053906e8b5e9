"""What training minimises: one function per loss, on a batch."""

import jax
import jax.numpy as jnp
from jaxtyping import Array, Float

from motorspace._types import Scalar
from motorspace.models.model import Model
from motorspace.trajectories import Experience

Codes = Float[Array, "N C"]

SPREADING = 0.5
"""How strongly slowness prefers several slow directions to a single one."""


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


def slowness_loss(codes: Codes, earlier: Codes) -> Scalar:
    """How far the last command moves the code, relative to how widely the codes spread.

    (mean || h_T - h_{T-1} ||^2 / tr S) (|| S ||_F / tr S)^a, S the codes' covariance,
    a = `SPREADING`: slow features (Wiskott and Sejnowski, 2002). Of everything that a random
    walk can be asked about, where it stands changes slowest relative to how far it varies, so
    that the codes' main directions become the displacement's. The second factor, a power of
    the participation ratio, keeps the slowest direction from outgrowing the others.
    """
    centred = codes - jnp.mean(codes, axis=0)
    covariance = centred.T @ centred / len(codes)
    total = jnp.trace(covariance) + 1e-6
    moved = jnp.mean(jnp.sum((codes - earlier) ** 2, axis=1))
    concentration = jnp.sqrt(jnp.sum(covariance**2) + 1e-12) / total
    return moved / total * concentration**SPREADING


def code_variance(codes: Codes) -> Scalar:
    """Variance of the codes, averaged over their units: zero for a collapsed encoder."""
    return jnp.mean(jnp.var(codes, axis=0))


def encode_all(model: Model, experience: Experience) -> Codes:
    """The codes of every transition."""
    return jax.vmap(model.encode)(experience.motors, experience.num_steps)


def encode_last_two(model: Model, experience: Experience) -> tuple[Codes, Codes]:
    """The codes of every transition, and those of its sequence without the last command."""
    encode_at = jax.vmap(model.encode, in_axes=(None, 0))
    steps = jnp.stack([experience.num_steps, experience.num_steps - 1], axis=1)
    codes = jax.vmap(encode_at)(experience.motors, steps)
    return codes[:, 0], codes[:, 1]
