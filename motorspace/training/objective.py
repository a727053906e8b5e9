"""What training minimises: the prediction loss, and weighted terms that each have a schedule."""

from collections.abc import Callable
from typing import NamedTuple

import equinox as eqx
import jax.numpy as jnp

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
from motorspace.trajectories.transitions import Experience


class EpochRecord(eqx.Module):
    """What is logged of one epoch: means over its updates."""

    prediction_loss: Scalar
    inverse_loss: Scalar
    code_variance: Scalar


class Encoded(NamedTuple):
    """The codes of a batch, and those of its sequences without their last command."""

    codes: Codes
    earlier: Codes


Schedule = Callable[[TrainingConfig, Count], Scalar | float]


class Term(NamedTuple):
    """One addend of the objective."""

    weight: float
    schedule: Schedule
    loss: Callable[[Model, Experience, Encoded], Scalar]


def constant(config: TrainingConfig, epoch: Count) -> float:
    """1 at every epoch."""
    del config, epoch
    return 1.0


def post_curriculum_ramp(config: TrainingConfig, epoch: Count) -> Scalar:
    """From 0 at the end of the curriculum to 1 after as many epochs again."""
    return jnp.clip(epoch / max(1, config.curriculum_epochs) - 1, 0.0, 1.0)


def curriculum_noise_scale(config: TrainingConfig, epoch: Count) -> Scalar:
    """From 1 to 0 over the epochs of the curriculum."""
    return jnp.maximum(0.0, 1 - (epoch + 1) / (config.curriculum_epochs + 1))


def terms(config: TrainingConfig) -> tuple[Term, ...]:
    """The terms beside the prediction loss whose weight is above 0."""
    everything = (
        Term(config.inverse_weight, constant, lambda m, b, e: inverse_loss(m, b, e.codes)),
        Term(config.slowness_weight, constant, lambda m, b, e: slowness_loss(*e)),
        # Full turns fold while sequences are short; isometric commands would hinder that.
        Term(config.isometry_weight, post_curriculum_ramp, lambda m, b, e: penalty_loss(m, b)),
        Term(config.composition_weight, constant, lambda m, b, e: composition_loss(m, b, e.codes)),
    )
    return tuple(term for term in everything if term.weight > 0)


def extras_for(config: TrainingConfig) -> Extras:
    """The networks that the terms need beside encoder and predictor."""
    return Extras(config.inverse_weight > 0, config.composition_weight > 0)


def objective(
    model: Model, batch: Experience, config: TrainingConfig, epoch: Count, *, key: Key
) -> tuple[Scalar, EpochRecord]:
    """The loss of a batch: prediction + sum of weight x schedule x term, and what is logged."""
    if config.slowness_weight > 0:
        encoded = Encoded(*encode_last_two(model, batch))
    else:
        encoded = Encoded(*[encode_all(model, batch)] * 2)
    codes = encoded.codes
    if config.code_noise > 0:
        amount = config.code_noise * curriculum_noise_scale(config, epoch)
        codes = noisy(codes, amount, key=key)
    prediction = total = prediction_loss(model, batch, codes)
    for term in terms(config):
        total += term.weight * term.schedule(config, epoch) * term.loss(model, batch, encoded)
    inverse = inverse_loss(model, batch, encoded.codes)
    return total, EpochRecord(prediction, inverse, code_variance(encoded.codes))
