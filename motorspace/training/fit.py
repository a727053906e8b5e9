"""The one training loop: an epoch is one compiled program."""

import math
from collections.abc import Callable, Sequence
from dataclasses import replace
from functools import partial

import equinox as eqx
import jax
import jax.numpy as jnp
import optax
from jaxtyping import Array, Int

from motorspace._errors import UserError
from motorspace._types import Count, Key, Keys, Record, Scalar
from motorspace.models.config import ModelConfig
from motorspace.models.losses import (
    code_variance,
    composition_loss,
    encode_all,
    encode_last_two,
    inverse_loss,
    isometry_loss,
    noisy,
    prediction_loss,
    slowness_loss,
)
from motorspace.models.model import Model, Scaling, build_model
from motorspace.training.config import TrainingConfig
from motorspace.trajectories.transitions import Experience, ExperienceSource

COLLAPSED_BELOW = 1e-5
"""Codes in [0, 1] whose mean variance is below this carry nothing: they have collapsed."""


class TrainState(eqx.Module):
    """All that training carries from one epoch to the next."""

    model: Model
    optimiser: optax.OptState
    epoch: Int[Array, ""]
    average: Model | None = None
    """The weights averaged over updates, where that is asked for."""
    best: Model | None = None
    """What predicts the validation data best so far, where there are some."""
    best_error: Scalar | None = None

    @property
    def kept(self) -> Model:
        """The network that training has to show."""
        return self.best or self.average or self.model


class EpochRecord(eqx.Module):
    """What is logged of one epoch: means over its updates."""

    prediction_loss: Scalar
    inverse_loss: Scalar
    code_variance: Scalar


Carry = tuple[Model, optax.OptState, Model | None]


def optimiser(config: TrainingConfig) -> optax.GradientTransformation:
    """Adam with the configured schedule."""
    if config.schedule == "constant":
        return optax.adam(config.learning_rate)
    updates = config.epochs * _num_updates(config)
    warm_up = max(1, updates // 100)
    schedule = optax.warmup_cosine_decay_schedule(
        0.0, config.learning_rate, warm_up, max(updates, warm_up + 1)
    )
    return optax.adam(schedule)


def init(
    config: TrainingConfig,
    model: ModelConfig,
    scaling: Scaling,
    *,
    horizon: int,
    validated: bool = False,
    start: int = 0,
) -> TrainState:
    """The state before the first epoch; with `validated` it will keep its best network.

    Every `start` of a seed has other initial weights.
    """
    if config.starts < 1:
        raise UserError(
            f"{config.starts} starts are no training", remedy="ask for at least one start"
        )
    if config.epochs < 1 or not 1 <= config.batch_size <= config.trajectories_per_epoch:
        raise UserError(
            f"{config.epochs} epochs of {config.trajectories_per_epoch} trajectories in batches "
            f"of {config.batch_size} are no training",
            remedy="ask for at least one epoch, and a batch between 1 and the epoch's size",
        )
    weights_key, _ = jax.random.split(jax.random.key(config.seed))
    if start > 0:
        weights_key = jax.random.fold_in(weights_key, start)
    network = build_model(model, scaling, horizon=horizon, key=weights_key)
    moments = optimiser(config).init(eqx.filter(network, eqx.is_inexact_array))
    average = network if config.average > 0 else None
    best = (network, jnp.array(jnp.inf)) if validated else (None, None)
    return TrainState(network, moments, jnp.zeros((), jnp.int32), average, *best)


@eqx.filter_jit
def train_epoch(
    state: TrainState,
    source: ExperienceSource,
    config: TrainingConfig,
    model_config: ModelConfig,
    *,
    key: Key,
) -> tuple[TrainState, EpochRecord]:
    """The state after one more epoch, and its record.

    The epoch's randomness is a function of `key` and its number alone: a resumed run continues
    to the same weights.
    """
    epoch_key = jax.random.fold_in(key, state.epoch)
    adam, slow = optimiser(config), model_config.slowness_weight > 0
    batches = _batches(source, config, state.epoch, key=epoch_key)
    noise_keys = jax.random.split(jax.random.fold_in(epoch_key, 1), _num_updates(config))
    noise = config.code_noise * _youth(config, state.epoch)
    trainable, fixed = eqx.partition(state.model, eqx.is_inexact_array)

    def loss(trainable: Model, batch: Experience, key: Key) -> tuple[Scalar, EpochRecord]:
        model = eqx.combine(trainable, fixed)
        if not model_config.train_encoder:
            model = _with_fixed_encoder(model)
        if slow:
            codes, earlier = encode_last_two(model, batch)
        else:
            codes = earlier = encode_all(model, batch)
        seen = codes
        if config.code_noise > 0:
            seen = noisy(codes, noise, key=key)
        prediction = prediction_loss(model, batch, seen)
        inverse = inverse_loss(model, batch, codes)
        record = EpochRecord(prediction, inverse, code_variance(codes))
        total = prediction + model_config.inverse_weight * inverse
        if slow:
            total += model_config.slowness_weight * slowness_loss(codes, earlier)
        if model_config.isometry_weight > 0:
            # Whole turns fold while sequences are short; kept lengths would hinder that.
            weight = model_config.isometry_weight * _maturity(config, state.epoch)
            total += weight * isometry_loss(model, batch)
        total += model_config.composition_weight * composition_loss(model, batch, codes)
        return total, record

    def update(carry: Carry, given: tuple[Experience, Key]) -> tuple[Carry, EpochRecord]:
        trainable, moments, average = carry
        gradients, record = jax.grad(loss, has_aux=True)(trainable, *given)
        steps, moments = adam.update(gradients, moments)
        trainable = optax.apply_updates(trainable, steps)
        if average is not None:
            average = optax.incremental_update(trainable, average, 1 - config.average)
        return (trainable, moments, average), record

    average = eqx.filter(state.average, eqx.is_inexact_array)
    (trainable, moments, average), records = jax.lax.scan(
        update, (trainable, state.optimiser, average), (batches, noise_keys)
    )
    model = eqx.combine(trainable, fixed)
    averaged = None if state.average is None else eqx.combine(average, fixed)
    after = TrainState(model, moments, state.epoch + 1, averaged, state.best, state.best_error)
    return after, jax.tree.map(jnp.mean, records)


def _with_fixed_encoder(model: Model) -> Model:
    stop = jax.lax.stop_gradient
    encoder = jax.tree.map(lambda x: stop(x) if eqx.is_inexact_array(x) else x, model.encoder)
    return eqx.tree_at(lambda m: m.encoder, model, encoder)


def _youth(config: TrainingConfig, epoch: Count) -> Scalar:
    """From 1 to 0 over the epochs of the curriculum."""
    return jnp.maximum(0.0, 1 - (epoch + 1) / (config.curriculum_epochs + 1))


def _maturity(config: TrainingConfig, epoch: Count) -> Scalar:
    """From 0 at the end of the curriculum to 1 after as many epochs again."""
    return jnp.clip(epoch / max(1, config.curriculum_epochs) - 1, 0.0, 1.0)


def _num_updates(config: TrainingConfig) -> int:
    """Of an epoch."""
    return config.trajectories_per_epoch // config.batch_size


def _batches(
    source: ExperienceSource, config: TrainingConfig, epoch: Count, *, key: Key
) -> Experience:
    """One epoch's transitions, [updates, batch, ...]."""
    updates = _num_updates(config)
    if isinstance(source, Experience):
        rows = jax.random.choice(key, len(source), (updates, config.batch_size))
        return jax.tree.map(lambda leaf: leaf[rows], source)
    drawn = source(key, epoch)
    shape = (updates, config.batch_size)
    return jax.tree.map(
        lambda leaf: leaf[: updates * config.batch_size].reshape(*shape, *leaf.shape[1:]), drawn
    )


def fit(
    config: TrainingConfig,
    model: ModelConfig,
    state: TrainState,
    source: ExperienceSource,
    *,
    validation: Experience | None = None,
    watch: Callable[[TrainState, Record], None] = lambda state, record: None,
) -> TrainState:
    """Train from `state` to the configured number of epochs.

    Before the first of them the most promising of the seed's starts takes the place of `state`.
    `source` is a fixed `Experience` (batches are drawn with replacement) or a function from a key
    and the epoch to fresh transitions. With `validation` data the state keeps the network that
    has predicted them best after any epoch. `watch` is called after every epoch with the state
    and its record. Raises `UserError` when the loss stops being finite; what `watch` was given
    before stays valid.
    """
    # The key is an argument and no constant of the program: all seeds share one compiled epoch.
    key = _epochs_key(config.seed)
    state = most_promising(config, model, state, source)
    for epoch in range(int(state.epoch), config.epochs):
        state, record = train_epoch(state, source, config, model, key=key)
        logged = _logged(epoch + 1, record)
        if validation is not None:
            state, error = keep_best(state, validation)
            logged["validation_loss"] = float(error)
        watch(state, logged)
    return state


def most_promising(
    config: TrainingConfig, model: ModelConfig, state: TrainState, source: ExperienceSource
) -> TrainState:
    """Of the seed's starts, the first of which is `state`, the one to train.

    It is the one with the lowest prediction loss after the epochs of the trial, in which all
    learn from the same data. What they learn in it is forgotten. A `state` that has been trained
    already stays.
    """
    if config.starts == 1 or int(state.epoch) > 0:
        return state
    horizon, validated = horizon_of(source), state.best is not None
    begin = partial(init, config, model, state.model.scaling, horizon=horizon, validated=validated)
    others = [begin(start=start) for start in range(1, config.starts)]
    starts, key, losses = [state, *others], _epochs_key(config.seed), []
    for tried in starts:
        for _ in range(config.trial_epochs):
            tried, record = train_epoch(tried, source, config, model, key=key)
        losses.append(float(jnp.nan_to_num(record.prediction_loss, nan=jnp.inf)))
    return starts[losses.index(min(losses))]


def horizon_of(source: ExperienceSource) -> int:
    """Motor commands per transition (T)."""
    if isinstance(source, Experience):
        return source.motors.shape[1]
    epoch = jax.ShapeDtypeStruct((), jnp.int32)
    return int(eqx.filter_eval_shape(source, jax.random.key(0), epoch).motors.shape[1])


def fit_together(
    config: TrainingConfig,
    model: ModelConfig,
    states: Sequence[TrainState],
    source: ExperienceSource,
    *,
    seeds: Sequence[int],
    watches: Sequence[Callable[[TrainState, Record], None]],
) -> list[TrainState]:
    """Train the states of several seeds as one program, each as `fit` would train it alone.

    Pays on a device of many cores. States that are behind, as an interruption leaves them, catch
    up with the others first. `config` says all but the seed.
    """
    states = [
        most_promising(replace(config, seed=seed), model, state, source)
        for state, seed in zip(states, seeds, strict=True)
    ]
    while (now := min(int(state.epoch) for state in states)) < config.epochs:
        behind = [n for n, state in enumerate(states) if int(state.epoch) == now]
        ahead = [int(state.epoch) for state in states if int(state.epoch) > now]
        keys = jnp.stack([_epochs_key(seeds[n]) for n in behind])
        together = _stacked([states[n] for n in behind])
        for epoch in range(now, min(ahead, default=config.epochs)):
            together, records = train_epoch_together(together, source, config, model, keys=keys)
            for place, n in enumerate(behind):
                states[n], record = _nth((together, records), jnp.array(place))
                watches[n](states[n], _logged(epoch + 1, record))
    return states


@eqx.filter_jit
def train_epoch_together(
    states: TrainState,
    source: ExperienceSource,
    config: TrainingConfig,
    model_config: ModelConfig,
    *,
    keys: Keys,
) -> tuple[TrainState, EpochRecord]:
    """`train_epoch` for states whose arrays have one more axis, the first: seeds."""
    one = lambda state, key: train_epoch(state, source, config, model_config, key=key)  # noqa: E731
    return eqx.filter_vmap(one)(states, keys)


def _stacked(states: Sequence[TrainState]) -> TrainState:
    arrays, rest = zip(*(eqx.partition(state, eqx.is_array) for state in states), strict=True)
    return eqx.combine(jax.tree.map(lambda *leaves: jnp.stack(leaves), *arrays), rest[0])


@eqx.filter_jit
def _nth(stacked: tuple[TrainState, EpochRecord], place: Count) -> tuple[TrainState, EpochRecord]:
    return jax.tree.map(lambda leaf: leaf[place] if eqx.is_array(leaf) else leaf, stacked)


def _epochs_key(seed: int) -> Key:
    return jax.random.split(jax.random.key(seed))[1]


def _logged(epoch: int, record: EpochRecord) -> Record:
    logged = {name: float(value) for name, value in vars(record).items()}
    if not all(math.isfinite(value) for value in logged.values()):
        raise UserError(
            f"the loss is no longer finite after epoch {epoch}",
            remedy="lower the learning rate and resume, or check the data for extreme values",
        )
    return {"epoch": epoch, **logged}


@eqx.filter_jit
def keep_best(state: TrainState, validation: Experience) -> tuple[TrainState, Scalar]:
    """The state with the better of its best network and its present one, and the latter's loss."""
    assert state.best_error is not None, "the state was made by init(validated=True)"
    present = state.average or state.model
    error = prediction_loss(present, validation, encode_all(present, validation))
    better = error < state.best_error
    arrays, fixed = eqx.partition((present, error), eqx.is_array)
    kept = eqx.filter((state.best, state.best_error), eqx.is_array)
    best = jax.tree.map(lambda new, old: jnp.where(better, new, old), arrays, kept)
    return eqx.tree_at(lambda s: (s.best, s.best_error), state, eqx.combine(best, fixed)), error
