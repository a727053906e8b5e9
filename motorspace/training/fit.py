"""The one training loop: an epoch is one compiled program."""

import math
from collections.abc import Callable, Sequence
from dataclasses import replace

import equinox as eqx
import jax
import jax.numpy as jnp
import optax
from jaxtyping import Int

from motorspace._errors import UserError
from motorspace._types import Count, Key, Keys, Record, Scalar
from motorspace.models.losses import encode_all, prediction_loss
from motorspace.models.model import Model, Parts, Scaling, build_model, with_fixed, with_parts
from motorspace.training.config import RunConfig, TrainingConfig
from motorspace.training.objective import EpochRecord, extras_for, objective
from motorspace.trajectories.transitions import Experience, ExperienceSource

COLLAPSED_BELOW = 1e-5
"""Codes in [0, 1] whose mean variance is below this carry nothing: they have collapsed."""


class TrainState(eqx.Module):
    """All that training carries from one epoch to the next."""

    model: Model
    optimiser: optax.OptState
    epoch: Int[jax.Array, ""]
    average: Model | None = None
    """The exponential moving average of the weights, with `ema_decay`."""
    best: Model | None = None
    """The network that predicts the validation data best so far, if there are any."""
    best_error: Scalar | None = None

    @property
    def selected(self) -> Model:
        """The model to save: best on validation, else the weight average, else the last."""
        return self.best or self.average or self.model


Carry = tuple[Model, optax.OptState, Model | None]
Callback = Callable[[TrainState, Record], None]


def optimiser(config: TrainingConfig) -> optax.GradientTransformation:
    """Adam with the configured schedule."""
    if config.schedule == "constant":
        return optax.adam(config.learning_rate)
    updates = config.epochs * config.num_updates
    warm_up = max(1, updates // 100)
    schedule = optax.warmup_cosine_decay_schedule(
        0.0, config.learning_rate, warm_up, max(updates, warm_up + 1)
    )
    return optax.adam(schedule)


def init(
    config: RunConfig,
    scaling: Scaling,
    *,
    horizon: int,
    validated: bool = False,
    restart: int = 0,
) -> TrainState:
    """The state before the first epoch; with `validated` it will keep its best network.

    Every `restart` of a seed has other initial weights. Raises `UserError` where JAX computes in
    double precision: weights and checkpoints are in single.
    """
    if jnp.zeros(()).dtype == jnp.float64:
        raise UserError(
            "JAX is set to double precision (jax_enable_x64), and networks are in single",
            remedy='switch it off: jax.config.update("jax_enable_x64", False)',
        )
    weights_key, _ = jax.random.split(jax.random.key(config.training.seed))
    if restart > 0:
        weights_key = jax.random.fold_in(weights_key, restart)
    extras = extras_for(config.training)
    network = build_model(config.model, scaling, horizon=horizon, extras=extras, key=weights_key)
    moments = optimiser(config.training).init(eqx.filter(network, eqx.is_inexact_array))
    average = network if config.training.ema_decay > 0 else None
    best = (network, jnp.array(jnp.inf)) if validated else (None, None)
    return TrainState(network, moments, jnp.zeros((), jnp.int32), average, *best)


@eqx.filter_jit
def train_epoch(
    state: TrainState,
    source: ExperienceSource,
    config: TrainingConfig,
    *,
    frozen: Parts = (),
    key: Key,
) -> tuple[TrainState, EpochRecord]:
    """The state after one more epoch, and its record; `frozen` parts of the network stay.

    The epoch's randomness is a function of `key` and its number alone: a resumed run continues
    to the same weights.
    """
    epoch_key = jax.random.fold_in(key, state.epoch)
    adam = optimiser(config)
    batches = _batches(source, config, state.epoch, key=epoch_key)
    noise_keys = jax.random.split(jax.random.fold_in(epoch_key, 1), config.num_updates)
    trainable, fixed = eqx.partition(state.model, eqx.is_inexact_array)

    def loss(trainable: Model, batch: Experience, key: Key) -> tuple[Scalar, EpochRecord]:
        model = eqx.combine(trainable, fixed)
        fixed_parts = frozen if config.train_encoder else (*frozen, "encoder")
        return objective(with_fixed(model, fixed_parts), batch, config, state.epoch, key=key)

    def update(carry: Carry, given: tuple[Experience, Key]) -> tuple[Carry, EpochRecord]:
        trainable, moments, average = carry
        gradients, record = jax.grad(loss, has_aux=True)(trainable, *given)
        # Optax raises its decay rates, Python floats, to the power of a count of whole numbers.
        with jax.numpy_dtype_promotion("standard"):
            steps, moments = adam.update(gradients, moments)
        trainable = optax.apply_updates(trainable, steps)
        if average is not None:
            average = optax.incremental_update(trainable, average, 1 - config.ema_decay)
        return (trainable, moments, average), record

    average = eqx.filter(state.average, eqx.is_inexact_array)
    (trainable, moments, average), records = jax.lax.scan(
        update, (trainable, state.optimiser, average), (batches, noise_keys)
    )
    model = eqx.combine(trainable, fixed)
    averaged = None if state.average is None else eqx.combine(average, fixed)
    after = TrainState(model, moments, state.epoch + 1, averaged, state.best, state.best_error)
    return after, jax.tree.map(jnp.mean, records)


def _batches(
    source: ExperienceSource, config: TrainingConfig, epoch: Count, *, key: Key
) -> Experience:
    """One epoch's transitions, [updates, batch, ...]."""
    shape = (config.num_updates, config.batch_size)
    if isinstance(source, Experience):
        rows = jax.random.choice(key, len(source), shape)
        return jax.tree.map(lambda leaf: leaf[rows], source)
    sampled = source(key, epoch)
    num = shape[0] * shape[1]
    return jax.tree.map(lambda leaf: leaf[:num].reshape(*shape, *leaf.shape[1:]), sampled)


def fit(
    config: RunConfig,
    state: TrainState,
    source: ExperienceSource,
    *,
    validation: Experience | None = None,
    frozen: Parts = (),
    callback: Callback = lambda state, record: None,
) -> TrainState:
    """Train from `state` to the configured number of epochs.

    Before the first of them the most promising of the seed's restarts takes the place of `state`.

    Args:
        config: The run's configuration.
        state: The state to go on from.
        source: A fixed `Experience` (batches are sampled with replacement), or a function from a
            key and the epoch to fresh transitions.
        validation: With these the state keeps the network that has predicted them best after any
            epoch.
        frozen: Parts of the network that keep the weights that they have in `state`.
        callback: Called after every epoch with the state and its record.

    Raises:
        UserError: When the loss stops being finite; what `callback` was given before stays valid.
    """
    # The key is an argument and no constant of the program: all seeds share one compiled epoch.
    training = config.training
    key = _epochs_key(training.seed)
    state = most_promising(config, state, source, frozen=frozen)
    for epoch in range(int(state.epoch), training.epochs):
        state, record = train_epoch(state, source, training, frozen=frozen, key=key)
        logged = _logged(epoch + 1, record)
        if validation is not None:
            state, error = keep_best(state, validation)
            logged["validation_loss"] = float(error)
        callback(state, logged)
    return state


def most_promising(
    config: RunConfig, state: TrainState, source: ExperienceSource, *, frozen: Parts = ()
) -> TrainState:
    """Of the seed's restarts, the first of which is `state`, the one to train.

    It is the one with the lowest prediction loss after the epochs of the trial, in which all
    learn from the same data. What they learn in it is forgotten. A `state` that has been trained
    already stays.
    """
    training = config.training
    if training.restarts == 1 or int(state.epoch) > 0:
        return state
    horizon, validated = horizon_of(source), state.best is not None
    scaling = state.model.scaling
    others = [
        init(config, scaling, horizon=horizon, validated=validated, restart=restart)
        for restart in range(1, training.restarts)
    ]
    shared = [
        eqx.tree_at(lambda s: s.model, other, with_parts(other.model, state.model, frozen))
        for other in others
    ]
    restarts, key, losses = [state, *shared], _epochs_key(training.seed), []
    for tried in restarts:
        for _ in range(training.trial_epochs):
            tried, record = train_epoch(tried, source, training, frozen=frozen, key=key)
        losses.append(float(jnp.nan_to_num(record.prediction_loss, nan=jnp.inf)))
    return restarts[losses.index(min(losses))]


def horizon_of(source: ExperienceSource) -> int:
    """Motor commands per transition (T)."""
    if isinstance(source, Experience):
        return source.motors.shape[1]
    epoch = jax.ShapeDtypeStruct((), jnp.int32)
    return int(eqx.filter_eval_shape(source, jax.random.key(0), epoch).motors.shape[1])


def fit_together(
    config: RunConfig,
    states: Sequence[TrainState],
    source: ExperienceSource,
    *,
    seeds: Sequence[int],
    callbacks: Sequence[Callback],
) -> list[TrainState]:
    """Train the states of several seeds as one program, each as `fit` would train it alone.

    Pays on a device of many cores. States that are behind, as an interruption leaves them, catch
    up with the others first. `config` says all but the seed.
    """
    training = config.training
    states = [
        most_promising(replace(config, training=replace(training, seed=seed)), state, source)
        for state, seed in zip(states, seeds, strict=True)
    ]
    while (now := min(int(state.epoch) for state in states)) < training.epochs:
        behind = [n for n, state in enumerate(states) if int(state.epoch) == now]
        ahead = [int(state.epoch) for state in states if int(state.epoch) > now]
        keys = jnp.stack([_epochs_key(seeds[n]) for n in behind])
        together = _stacked([states[n] for n in behind])
        for epoch in range(now, min(ahead, default=training.epochs)):
            together, records = train_epoch_together(together, source, training, keys=keys)
            for place, n in enumerate(behind):
                states[n], record = _nth((together, records), jnp.array(place))
                callbacks[n](states[n], _logged(epoch + 1, record))
    return states


@eqx.filter_jit
def train_epoch_together(
    states: TrainState, source: ExperienceSource, config: TrainingConfig, *, keys: Keys
) -> tuple[TrainState, EpochRecord]:
    """`train_epoch` for states whose arrays have one more axis, the first: seeds."""
    one = lambda state, key: train_epoch(state, source, config, key=key)  # noqa: E731
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
    before = eqx.filter((state.best, state.best_error), eqx.is_array)
    best = jax.tree.map(lambda new, old: jnp.where(better, new, old), arrays, before)
    return eqx.tree_at(lambda s: (s.best, s.best_error), state, eqx.combine(best, fixed)), error
