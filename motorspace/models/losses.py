"""What training minimises: one function per loss, on a batch."""

import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Float

from motorspace._types import Key, Scalar
from motorspace.models.model import Model
from motorspace.trajectories.transitions import Experience

Codes = Float[Array, "N C"]

BLURS = (1.5, 4.0)
"""Standard deviations over which views are blurred, pixels."""

REDUNDANCY = 0.04
"""Weight of features that say the same, beside features that say nothing: 1 / 25, as VICReg."""

DISCOUNT = 0.7
"""How much less variance counts that a single direction holds."""


def prediction_loss(model: Model, batch: Experience, codes: Codes) -> Scalar:
    """Mean squared error of the predicted sensors, as shares of the sensors' scale.

    mean || s_{t+T} - prediction(s_t, h^m) ||^2 / K (section 3).
    """
    predicted = jax.vmap(model.predict)(batch.sensors, codes)
    error = (predicted - batch.later_sensors) / jnp.array(model.scaling.sensors)[None]
    return jnp.mean(error**2)


def blurred_loss(model: Model, batch: Experience, codes: Codes, view: tuple[int, ...]) -> Scalar:
    """Mean squared errors of the prediction as seen without sharp eyes, summed over `BLURS`.

    What is fine in a view is nearly impossible to predict; what is coarse shows gradients from
    farther off. `view` is how the sensors are arranged: neighbours along every axis but that of
    colours, the last of several, are mixed.
    """
    predicted = jax.vmap(model.predict)(batch.sensors, codes)
    error = (predicted - batch.later_sensors) / jnp.array(model.scaling.sensors)[None]
    arranged = error.reshape(-1, *view)
    return sum((jnp.mean(_blurred(arranged, width) ** 2) for width in BLURS), jnp.zeros(()))


def _blurred(views: Float[Array, "N *view"], width: float) -> Float[Array, "N *view"]:
    """Views mixed by a Gaussian of `width` neighbours along each axis but the first and last."""
    spatial = range(1, max(2, views.ndim - 1))
    for axis in spatial:
        places = np.arange(views.shape[axis])
        near = np.exp(-(((places[:, None] - places) / width) ** 2) / 2)
        kernel = jnp.asarray(near / near.sum(axis=1, keepdims=True), jnp.float32)
        views = jnp.moveaxis(jnp.tensordot(views, kernel, (axis, 1)), -1, axis)
    return views


def latent_loss(model: Model, batch: Experience, codes: Codes) -> Scalar:
    """Mean squared error of the predicted features, and a guard against features that collapse.

    mean || f(s_{t+T}) - P(f(s_t), h^m) ||^2 / F + V + 0.04 C, as VICReg (Bardes, Ponce and LeCun,
    2022): V is how far each feature's standard deviation is below 1, C the squared covariance of
    features with each other.
    """
    if model.latent is None:
        return jnp.zeros(())
    scale = jnp.array(model.scaling.sensors)[None]
    now = jax.vmap(model.latent.features)(batch.sensors / scale)
    later = jax.vmap(model.latent.features)(batch.later_sensors / scale)
    predicted = jax.vmap(model.latent)(now, codes)
    guard = sum((_collapse(features) for features in (now, later)), jnp.zeros(())) / 2
    return jnp.mean((predicted - later) ** 2) + guard


def _collapse(features: Float[Array, "N F"]) -> Scalar:
    """How far features are from having a standard deviation of 1, and from being independent."""
    centred = features - jnp.mean(features, axis=0, keepdims=True)
    covariance = centred.T @ centred / (len(features) - 1)
    variance = jnp.diagonal(covariance)
    missing = jnp.mean(jax.nn.relu(1 - jnp.sqrt(variance + 1e-4)))
    shared = (jnp.sum(covariance**2) - jnp.sum(variance**2)) / len(variance)
    return missing + REDUNDANCY * shared


def inverse_loss(model: Model, batch: Experience, codes: Codes) -> Scalar:
    """Mean squared distance of the code from what the inverse model makes of the sensors.

    mean || h^m - inverse(s_t, s_{t+T}) ||^2, relative to the `spread` of the codes, so that
    shrinking them to a constant does not lower it (section 4.1 gives no normalisation).
    """
    if model.inverse is None:
        return jnp.zeros(())
    scale = jnp.array(model.scaling.sensors)[None]
    inferred = jax.vmap(model.inverse)(batch.sensors / scale, batch.later_sensors / scale)
    return jnp.mean(jnp.sum((codes - inferred) ** 2, axis=1)) / spread(codes)


def slowness_loss(codes: Codes, earlier: Codes) -> Scalar:
    """Mean squared change of the code with the last command, relative to the codes' `spread`.

    mean || h_T - h_{T-1} ||^2: slow feature analysis (Wiskott and Sejnowski, 2002). Of all
    that can be told of a random walk's end, where it lies changes least with one step relative
    to how widely it varies, so that displacement becomes the codes' main directions.
    """
    return jnp.mean(jnp.sum((codes - earlier) ** 2, axis=1)) / spread(codes)


def composition_loss(model: Model, batch: Experience, codes: Codes) -> Scalar:
    """Mean squared distance of the code from what the codes of both halves make of it.

    mean || h(a b) - C(h(a), h(b)) ||^2, relative to the codes' `spread`, over the sequences of at
    least two commands.
    """
    if model.composition is None:
        return jnp.zeros(())
    num_first = (batch.num_steps + 1) // 2
    num_second = jnp.maximum(1, batch.num_steps - num_first)
    encode = jax.vmap(model.encode)
    later = jax.vmap(lambda motors, num: jnp.roll(motors, -num, axis=0))(batch.motors, num_first)
    composed = jax.vmap(model.composition)(
        encode(batch.motors, num_first), encode(later, num_second)
    )
    errors = jnp.sum((codes - composed) ** 2, axis=1)
    return jnp.mean(jnp.where(batch.num_steps > 1, errors, 0.0)) / spread(codes)


def penalty_loss(model: Model, batch: Experience) -> Scalar:
    """The encoder's own penalty on the batch's commands; see `AbstractMotorEncoder.penalty`."""
    return model.encoder.penalty(batch.motors / jnp.array(model.scaling.motors)[None, None])


def noisy(codes: Codes, amount: Scalar, *, key: Key) -> Codes:
    """The codes with Gaussian noise of `amount` times each unit's standard deviation.

    No scale of the codes escapes it; only what is spread out widely can still be told apart.
    """
    deviation = jnp.sqrt(jnp.var(codes, axis=0) + 1e-10)
    return codes + amount * deviation[None] * jax.random.normal(key, codes.shape)


def spread(codes: Codes) -> Scalar:
    """The codes' total variance, discounted where few directions hold it: tr S (PR)^(a/2).

    S is the codes' covariance, PR = (tr S)^2 / || S ||_F^2 its participation ratio, a =
    `DISCOUNT`. Relative to the total variance alone, a loss is lowered most by inflating the
    one direction that suits it best.
    """
    centred = codes - jnp.mean(codes, axis=0, keepdims=True)
    covariance = centred.T @ centred / len(codes)
    total = jnp.trace(covariance) + 1e-5
    return total * (total / jnp.sqrt(jnp.sum(covariance**2) + 1e-10)) ** DISCOUNT


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
