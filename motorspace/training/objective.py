"""What training minimises: the prediction loss, and weighted terms that each have a schedule."""

from collections.abc import Callable
from typing import NamedTuple

import equinox as eqx
import jax
import jax.numpy as jnp
from jaxtyping import Array, Float

from motorspace._types import Count, Key, Scalar
from motorspace.models.losses import (
    Codes,
    blurred_loss,
    code_variance,
    composition_loss,
    encode_all,
    encode_last_two,
    inverse_loss,
    latent_loss,
    noisy,
    penalty_loss,
    prediction_loss,
    slowness_loss,
)
from motorspace.models.model import Extras, Model
from motorspace.training.config import TrainingConfig
from motorspace.training.recipe import Recipe
from motorspace.trajectories.transitions import Experience


class EpochRecord(eqx.Module):
    """What is logged of an epoch, or of each of several: means over its updates."""

    prediction_loss: Float[Array, "*epochs"]
    inverse_loss: Float[Array, "*epochs"]
    code_variance: Float[Array, "*epochs"]
    validation_loss: Float[Array, "*epochs"] | None = None
    """After the epoch, where there are validation data."""


class Encoded(NamedTuple):
    """The codes of a batch, and those of its sequences without their last command."""

    codes: Codes
    earlier: Codes
    given: Codes
    """What the predictor is given: the codes, or these with noise."""


class Term(NamedTuple):
    """One addend of the objective."""

    schedule: Callable[[Recipe, Count], Scalar | float]
    loss: Callable[[Model, Experience, Encoded, Recipe], Scalar]


def constant(recipe: Recipe, epoch: Count) -> float:
    """1 at every epoch."""
    del recipe, epoch
    return 1.0


def post_curriculum_ramp(recipe: Recipe, epoch: Count) -> Scalar:
    """From 0 at the end of the curriculum to 1 after as many epochs again."""
    return jnp.clip(epoch / jnp.maximum(1, recipe.curriculum_epochs) - 1, 0.0, 1.0)


def curriculum_noise_scale(recipe: Recipe, epoch: Count) -> Scalar:
    """From 1 to 0 over the epochs of the curriculum."""
    return jnp.maximum(0.0, 1 - (epoch + 1) / (recipe.curriculum_epochs + 1))


TERMS = {
    "inverse": Term(constant, lambda m, b, e, r: inverse_loss(m, b, e.codes)),
    "slowness": Term(constant, lambda m, b, e, r: slowness_loss(e.codes, e.earlier)),
    # Full turns fold while sequences are short; isometric commands would hinder that.
    "isometry": Term(post_curriculum_ramp, lambda m, b, e, r: penalty_loss(m, b)),
    "composition": Term(constant, lambda m, b, e, r: composition_loss(m, b, e.codes)),
    "blur": Term(constant, lambda m, b, e, r: blurred_loss(m, b, e.given, r.view)),
    "latent": Term(constant, lambda m, b, e, r: latent_loss(m, b, e.given)),
}
"""The addends beside the prediction loss, by the name of their weight."""


def extras_for(config: TrainingConfig) -> Extras:
    """The networks that the terms need beside encoder and predictor."""
    weights = config.inverse_weight, config.composition_weight, config.latent_weight
    return Extras(*(weight > 0 for weight in weights))


def objective(
    model: Model, batch: Experience, recipe: Recipe, epoch: Count, *, key: Key
) -> tuple[Scalar, EpochRecord]:
    """The loss of a batch: prediction + sum of weight x schedule x term, and what is logged."""
    codes, earlier = (
        encode_last_two(model, batch)
        if "slowness" in recipe.weights
        else (encode_all(model, batch),) * 2
    )
    given = codes
    if recipe.code_noise is not None:
        amount = recipe.code_noise * curriculum_noise_scale(recipe, epoch)
        given = noisy(codes, amount, key=key)
    encoded = Encoded(codes, earlier, given)
    # Where features are predicted, codes learn from these alone, and sensors are read out.
    read = jax.lax.stop_gradient(given) if "latent" in recipe.weights else given
    prediction = total = prediction_loss(model, batch, read)
    for name, term in TERMS.items():
        if name in recipe.weights:
            weight = recipe.weights[name] * term.schedule(recipe, epoch)
            total += weight * term.loss(model, batch, encoded, recipe)
    inverse = inverse_loss(model, batch, encoded.codes)
    return total, EpochRecord(prediction, inverse, code_variance(encoded.codes))
