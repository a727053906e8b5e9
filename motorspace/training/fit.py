"""The one training loop, for a run or for several at once."""

import math
from collections.abc import Callable, Sequence
from typing import Any, TypeVar

import equinox as eqx
import jax
import jax.numpy as jnp

from motorspace._errors import UserError
from motorspace._types import Record
from motorspace.models.model import UNSCALED, Parts, Scaling, build_model, with_parts, with_scaling
from motorspace.training.calls import alike, calls
from motorspace.training.config import RunConfig
from motorspace.training.data import arrangement
from motorspace.training.objective import extras_for
from motorspace.training.program import MOST_EPOCHS, Task, TrainState
from motorspace.training.recipe import Recipe
from motorspace.trajectories.transitions import Experience, ExperienceSource

Source = TypeVar("Source")

COLLAPSED_BELOW = 1e-5
"""Codes in [0, 1] whose mean variance is below this carry nothing: they have collapsed."""

Callback = Callable[[TrainState, Sequence[Record]], None]
"""Called with a state and the records of the epochs since the last call, at least one."""


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
    weights = eqx.filter(with_scaling(network, UNSCALED), eqx.is_inexact_array)
    moments = Recipe.of(config.training).optimiser.init(weights)
    average = network if config.training.ema_decay > 0 else None
    best = (network, jnp.array(jnp.inf)) if validated else (None, None)
    return TrainState(network, moments, jnp.zeros((), jnp.int32), average, *best)


def task_of(
    config: RunConfig,
    scaling: Scaling,
    source: ExperienceSource,
    *,
    validation: Experience | None = None,
    frozen: Parts = (),
) -> Task:
    """What a run's program is given beside its state; every number in it is an argument."""
    divisors = Scaling(jnp.array(scaling.sensors), jnp.array(scaling.motors))
    key = jax.random.split(jax.random.key(config.training.seed))[1]
    view = _view(config, len(scaling.sensors)) if config.training.blur_weight > 0 else ()
    recipe = Recipe.of(config.training, view)
    return Task(_with_arguments(source), recipe, divisors, key, validation, frozen)


def _view(config: RunConfig, num_sensors: int) -> tuple[int, ...]:
    """How what is predicted is arranged; side by side where that is not what is sensed."""
    shape = arrangement(config.data)
    return shape if shape and math.prod(shape) == num_sensors else (num_sensors,)


def _with_arguments(source: Source) -> Source:
    """The source with arrays for its numbers, which would be constants of the program."""

    def argument(leaf: Any) -> Any:
        return jnp.float32(leaf) if isinstance(leaf, float) else leaf

    return jax.tree.map(argument, source)


def fit(
    config: RunConfig,
    state: TrainState,
    source: ExperienceSource,
    *,
    validation: Experience | None = None,
    frozen: Parts = (),
    callback: Callback = lambda state, records: None,
    every: int = MOST_EPOCHS,
) -> TrainState:
    """Train from `state` to the configured number of epochs.

    Before the first of them the most promising of the seed's restarts takes the place of `state`.

    Args:
        config: The run's configuration.
        state: The state to go on from.
        source: A fixed `Experience` (batches are sampled with replacement), or a function from a
            key and the epoch to fresh transitions. Numbers in an Equinox module are arguments of
            the program: modules that differ by them share it.
        validation: With these the state keeps the network that has predicted them best after any
            epoch.
        frozen: Parts of the network that keep the weights that they have in `state`.
        callback: Called about every second, with the state and the records since the last call.
        every: Epochs after which `callback` is called in any case.

    Raises:
        UserError: When the loss stops being finite; what `callback` was given before stays valid.
    """
    scaling = state.model.scaling
    task = task_of(config, scaling, source, validation=validation, frozen=frozen)
    (trained,) = fit_together([config], [state], [task], callbacks=[callback], every=every)
    return trained


def horizon_of(source: ExperienceSource) -> int:
    """Motor commands per transition (T)."""
    if isinstance(source, Experience):
        return source.motors.shape[1]
    epoch = jax.ShapeDtypeStruct((), jnp.int32)
    # As the program is given it, so that sampling is traced once for both.
    drawn = eqx.filter_eval_shape(_with_arguments(source), jax.random.key(0), epoch)
    return int(drawn.motors.shape[1])


def fit_together(
    configs: Sequence[RunConfig],
    states: Sequence[TrainState],
    tasks: Sequence[Task],
    *,
    callbacks: Sequence[Callback],
    every: int = MOST_EPOCHS,
) -> list[TrainState]:
    """Train several runs, each as `fit` would train it alone; those that are alike as one program.

    Runs are alike that differ by their seeds and by numbers. A batch of them pays on a device of
    many cores. States that are behind, as an interruption leaves them, catch up with the others.

    Raises:
        UserError: When a loss stops being finite, once the other runs are trained.
    """
    trained, failures = list(states), list[UserError]()
    for runs in alike(states, tasks):
        config, given = configs[runs[0]], [tasks[n] for n in runs]
        start = most_promising([configs[n] for n in runs], [states[n] for n in runs], given)
        found, failed = _fit_alike(
            start, given, config.training.epochs, [callbacks[n] for n in runs], every
        )
        for n, state in zip(runs, found, strict=True):
            trained[n] = state
        failures += failed
    if failures:
        raise failures[0]
    return trained


def _fit_alike(
    states: list[TrainState],
    tasks: Sequence[Task],
    epochs: int,
    callbacks: Sequence[Callback],
    every: int,
) -> tuple[list[TrainState], list[UserError]]:
    """The trained states, and the errors of those whose loss exploded."""
    failed: dict[int, UserError] = {}
    while (now := min(int(state.epoch) for state in states)) < epochs:
        behind = [n for n, state in enumerate(states) if int(state.epoch) == now]
        ahead = [int(state.epoch) for state in states if int(state.epoch) > now]
        start, given = [states[n] for n in behind], [tasks[n] for n in behind]
        for after, records in calls(start, given, min(ahead, default=epochs), every):
            for n, state, of_run in zip(behind, after, records, strict=True):
                states[n] = state
                if (exploded := _exploded(of_run)) is not None:
                    failed.setdefault(n, exploded)
                if n not in failed:
                    callbacks[n](state, of_run)
            if len(failed) == len(states):
                return states, [*failed.values()]
    return states, [*failed.values()]


def _exploded(records: Sequence[Record]) -> UserError | None:
    """What to say if a loss stopped being finite."""
    for record in records:
        if not all(math.isfinite(value) for value in record.values()):
            return UserError(
                f"the loss is no longer finite after epoch {record['epoch']}",
                remedy="lower the learning rate and resume, or check the data for extreme values",
            )
    return None


def most_promising(
    configs: Sequence[RunConfig], states: Sequence[TrainState], tasks: Sequence[Task]
) -> list[TrainState]:
    """Of the restarts of each seed, the first of which is in `states`, the one to train.

    It is the one with the lowest prediction loss after the epochs of the trial, in which all
    learn from the same data. What they learn in it is forgotten. A state that has been trained
    already stays.
    """
    tried = [
        (n, candidate)
        for n, (config, state, task) in enumerate(zip(configs, states, tasks, strict=True))
        for candidate in _candidates(config, state, task)
    ]
    if not tried:
        return list(states)
    # A run by itself tries its restarts one after another, by the program that trains it.
    teams = [tried] if len(states) > 1 else [[one] for one in tried]
    best: dict[int, tuple[float, TrainState]] = {}
    for team in teams:
        losses = _losses_after(team, tasks, configs[0].training.trial_epochs)
        for (n, candidate), loss in zip(team, losses, strict=True):
            if n not in best or loss < best[n][0]:
                best[n] = loss, candidate
    return [best[n][1] if n in best else state for n, state in enumerate(states)]


def _candidates(config: RunConfig, state: TrainState, task: Task) -> list[TrainState]:
    """The restarts of a seed that are to be tried, if there are any."""
    training, scaling = config.training, state.model.scaling
    if training.restarts == 1 or int(state.epoch) > 0:
        return []
    horizon, validated = horizon_of(task.source), state.best is not None
    others = [
        init(config, scaling, horizon=horizon, validated=validated, restart=restart)
        for restart in range(1, training.restarts)
    ]
    shared = [
        eqx.tree_at(lambda s: s.model, other, with_parts(other.model, state.model, task.frozen))
        for other in others
    ]
    return [state, *shared]


def _losses_after(
    team: Sequence[tuple[int, TrainState]], tasks: Sequence[Task], epochs: int
) -> list[float]:
    """The prediction losses of states after so many epochs, infinite for those that exploded."""
    *_, (_, last) = calls([state for _, state in team], [tasks[n] for n, _ in team], epochs)
    losses = [records[-1]["prediction_loss"] for records in last]
    return [loss if math.isfinite(loss) else math.inf for loss in losses]
