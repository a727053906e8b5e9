"""What training minimises: the prediction loss, and weighted terms that each have a schedule."""

from collections.abc import Callable
from typing import NamedTuple

import equinox as eqx
import jax.numpy as jnp
from jaxtyping import Array, Float

from motorspace._types import Count, Key, Scalar
from motorspace.models.losses import (
    Codes,
    code_variance,
    composition_loss,
    encode_all,
    encode_last_two,
    inverse_loss,
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


class Term(NamedTuple):
    """One addend of the objective."""

    schedule: Callable[[Recipe, Count], Scalar | float]
    loss: Callable[[Model, Experience, Encoded], Scalar]


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
    "inverse": Term(constant, lambda m, b, e: inverse_loss(m, b, e.codes)),
    "slowness": Term(constant, lambda m, b, e: slowness_loss(*e)),
    # Full turns fold while sequences are short; isometric commands would hinder that.
    "isometry": Term(post_curriculum_ramp, lambda m, b, e: penalty_loss(m, b)),
    "composition": Term(constant, lambda m, b, e: composition_loss(m, b, e.codes)),
}
"""The addends beside the prediction loss, by the name of their weight."""


def extras_for(config: TrainingConfig) -> Extras:
    """The networks that the terms need beside encoder and predictor."""
    return Extras(config.inverse_weight > 0, config.composition_weight > 0)


def objective(
    model: Model, batch: Experience, recipe: Recipe, epoch: Count, *, key: Key
) -> tuple[Scalar, EpochRecord]:
    """The loss of a batch: prediction + sum of weight x schedule x term, and what is logged."""
    if "slowness" in recipe.weights:
        encoded = Encoded(*encode_last_two(model, batch))
    else:
        encoded = Encoded(*[encode_all(model, batch)] * 2)
    codes = encoded.codes
    if recipe.code_noise is not None:
        amount = recipe.code_noise * curriculum_noise_scale(recipe, epoch)
        codes = noisy(codes, amount, key=key)
    prediction = total = prediction_loss(model, batch, codes)
    for name, term in TERMS.items():
        if name in recipe.weights:
            weight = recipe.weights[name] * term.schedule(recipe, epoch)
            total += weight * term.loss(model, batch, encoded)
    inverse = inverse_loss(model, batch, encoded.codes)
    return total, EpochRecord(prediction, inverse, code_variance(encoded.codes))
