"""The compiled part of training: many epochs of a run, or of a batch of runs, in one call."""

import dataclasses
from contextlib import AbstractContextManager, nullcontext
from typing import Any

import equinox as eqx
import jax
import jax.numpy as jnp
import optax
from jaxtyping import Array, Float, Int

from motorspace._devices import on_accelerator
from motorspace._types import Count, Key, Keys, Scalar
from motorspace.models.losses import encode_all, prediction_loss
from motorspace.models.model import Model, Parts, Scaling, with_fixed, with_scaling
from motorspace.training.config import Precision
from motorspace.training.objective import EpochRecord, objective
from motorspace.training.recipe import Recipe
from motorspace.trajectories.transitions import Experience, ExperienceSource

MOST_EPOCHS = 500
"""Epochs of one call at most: so many records wait on the device."""

PRODUCTS: dict[Precision, str] = {
    "float32": "highest",
    "tf32": "TF32_TF32_F32",
    "bf16": "BF16_BF16_F32",
}
"""What JAX calls the ways to multiply matrices."""


class TrainState(eqx.Module):
    """All that training carries from one epoch to the next."""

    model: Model
    optimiser: optax.OptState
    epoch: Int[Array, ""]
    average: Model | None = None
    """The exponential moving average of the weights, with `ema_decay`."""
    best: Model | None = None
    """The network that predicts the validation data best so far, if there are any."""
    best_error: Scalar | None = None

    @property
    def selected(self) -> Model:
        """The model to save: best on validation, else the weight average, else the last."""
        return self.best or self.average or self.model

    def with_scaling(self, scaling: Scaling) -> "TrainState":
        """The same with other divisors in every network."""

        def scaled(model: Model | None) -> Model | None:
            return None if model is None else with_scaling(model, scaling)

        return TrainState(
            with_scaling(self.model, scaling),
            self.optimiser,
            self.epoch,
            scaled(self.average),
            scaled(self.best),
            self.best_error,
        )


class Task(eqx.Module):
    """What a run learns from, and how: the arguments of its program beside its state."""

    source: ExperienceSource
    recipe: Recipe
    scaling: Scaling
    key: Key
    """Of the epochs: the randomness of one is a function of this and its number."""
    validation: Experience | None = None
    frozen: Parts = eqx.field(static=True, default=())
    """Parts of the network that keep their weights."""


Carry = tuple[Model, optax.OptState, Model | None]


@eqx.filter_jit
def train_epochs(state: TrainState, task: Task, num: Count) -> tuple[TrainState, EpochRecord]:
    """The state after `num` more epochs, and their records [MOST_EPOCHS], the first `num`.

    The networks in `state` are `UNSCALED`. Since an epoch's randomness depends on its number
    alone, it does not matter how epochs are shared out among calls.
    """
    return _epochs(state, task, num)


@eqx.filter_jit
def train_epochs_together(
    states: TrainState, own: Task, shared: Task, num: Count
) -> tuple[TrainState, EpochRecord]:
    """`train_epochs` for R runs: arrays of `states`, `own` and what is returned have R rows.

    `own` holds what differs between the tasks, `shared` what does not.
    """

    def one(state: TrainState, own: Task) -> tuple[TrainState, EpochRecord]:
        return _epochs(state, eqx.combine(own, shared), num)

    return eqx.filter_vmap(one)(states, own)


def _epochs(state: TrainState, task: Task, num: Count) -> tuple[TrainState, EpochRecord]:
    changing, fixed = eqx.partition(state, eqx.is_array)
    nothing: Float[Array, " E"] = jnp.zeros(MOST_EPOCHS, jnp.float32)
    validated = None if task.validation is None else nothing
    records = EpochRecord(nothing, nothing, nothing, validated)

    def one_more(n: Count, carry: tuple[Any, EpochRecord]) -> tuple[Any, EpochRecord]:
        changing, records = carry
        after, record = _epoch(eqx.combine(changing, fixed), task)
        noted = jax.tree.map(lambda all, one: all.at[n].set(one), records, record)
        return eqx.filter(after, eqx.is_array), noted

    changing, records = jax.lax.fori_loop(0, num, one_more, (changing, records))
    return eqx.combine(changing, fixed), records


def _epoch(state: TrainState, task: Task) -> tuple[TrainState, EpochRecord]:
    """The state after one more epoch, and its record."""
    key = jax.random.fold_in(task.key, state.epoch)
    batches = _batches(task, state.epoch, key=key)
    noise_keys = jax.random.split(jax.random.fold_in(key, 1), task.recipe.num_updates)
    with _precise(task.recipe.precision):
        after, records = _updated(state, task, (batches, noise_keys))
        record = jax.tree.map(jnp.mean, records)
        if task.validation is None:
            return after, record
        after, error = keep_best(after, task.validation, task.scaling)
        return after, dataclasses.replace(record, validation_loss=error)


def _updated(
    state: TrainState, task: Task, given: tuple[Experience, Keys]
) -> tuple[TrainState, EpochRecord]:
    """The state after an update with each of the batches, and what is logged of these."""
    recipe = task.recipe
    trainable, fixed = eqx.partition(state.model, eqx.is_inexact_array)
    parts = task.frozen if recipe.train_encoder else (*task.frozen, "encoder")
    adam = recipe.optimiser

    def loss(trainable: Model, batch: Experience, key: Key) -> tuple[Scalar, EpochRecord]:
        model = with_scaling(eqx.combine(trainable, fixed), task.scaling)
        return objective(with_fixed(model, parts), batch, recipe, state.epoch, key=key)

    def update(carry: Carry, given: tuple[Experience, Key]) -> tuple[Carry, EpochRecord]:
        trainable, moments, average = carry
        gradients, record = jax.grad(loss, has_aux=True)(trainable, *given)
        # Optax raises its decay rates, Python floats, to the power of a count of whole numbers.
        with jax.numpy_dtype_promotion("standard"):
            steps, moments = adam.update(gradients, moments)
        trainable = optax.apply_updates(trainable, steps)
        if recipe.ema_decay is not None:
            average = optax.incremental_update(trainable, average, 1 - recipe.ema_decay)
        return (trainable, moments, average), record

    average = eqx.filter(state.average, eqx.is_inexact_array)
    (trainable, moments, average), records = jax.lax.scan(
        update, (trainable, state.optimiser, average), given
    )
    averaged = None if state.average is None else eqx.combine(average, fixed)
    model, epoch = eqx.combine(trainable, fixed), state.epoch + 1
    return TrainState(model, moments, epoch, averaged, state.best, state.best_error), records


def _batches(task: Task, epoch: Count, *, key: Key) -> Experience:
    """One epoch's transitions, [updates, batch, ...]."""
    shape = (task.recipe.num_updates, task.recipe.batch_size)
    if isinstance(task.source, Experience):
        rows = jax.random.choice(key, len(task.source), shape)
        return jax.tree.map(lambda leaf: leaf[rows], task.source)
    sampled = task.source(key, epoch)
    num = shape[0] * shape[1]
    return jax.tree.map(lambda leaf: leaf[:num].reshape(*shape, *leaf.shape[1:]), sampled)


def keep_best(
    state: TrainState, validation: Experience, scaling: Scaling
) -> tuple[TrainState, Scalar]:
    """The state with the better of its best network and its present one, and the latter's loss."""
    assert state.best_error is not None, "the state was made by init(validated=True)"
    present = state.average or state.model
    scaled = with_scaling(present, scaling)
    error = prediction_loss(scaled, validation, encode_all(scaled, validation))
    better = error < state.best_error
    arrays, fixed = eqx.partition((present, error), eqx.is_array)
    before = eqx.filter((state.best, state.best_error), eqx.is_array)
    best = jax.tree.map(lambda new, old: jnp.where(better, new, old), arrays, before)
    return eqx.tree_at(lambda s: (s.best, s.best_error), state, eqx.combine(best, fixed)), error


def _precise(precision: Precision) -> AbstractContextManager[Any]:
    """Products of matrices as asked for, where JAX runs on a device that has a choice."""
    return jax.default_matmul_precision(PRODUCTS[precision]) if on_accelerator() else nullcontext()
