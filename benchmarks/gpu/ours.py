"""How motorspace trains several runs at once: the only place here that knows of its interface."""

from collections.abc import Callable
from functools import lru_cache
from typing import Any

import equinox as eqx
import jax
import jax.numpy as jnp

from benchmarks.suites.sampling import sampler
from motorspace._types import Keys
from motorspace.training.config import RunConfig, TrainingConfig
from motorspace.training.fit import TrainState, horizon_of, init, train_epoch_together
from motorspace.training.settings import changed
from motorspace.training.sources import source_of
from motorspace.trajectories.transitions import Experience, ExperienceSource

PRECISION = "tensorfloat32"
"""Of matrix products, unless a part is about just that; PyTorch gets the same."""
SEEDS = 16
"""Different initial weights; more runs repeat them."""

Arguments = tuple[TrainState, ExperienceSource, TrainingConfig, Keys]


def ours(
    config: RunConfig, num_runs: int, epochs: int, *, fresh: bool, precision: str = PRECISION
) -> Callable[[], Any]:
    """What trains so many runs for so many epochs, and returns the last loss of each.

    Args:
        config: Of all runs, but for their seeds.
        num_runs: Runs that one program trains.
        epochs: Epochs from the initial weights; the schedule is that of the configuration.
        fresh: Sample anew in each epoch; otherwise all runs learn from the same transitions.
        precision: Of matrix products, as JAX names it.
    """
    states, source, training, keys = _arguments(config, num_runs, fresh=fresh)

    def run() -> Any:
        trained = states
        with jax.default_matmul_precision(precision):
            for _ in range(epochs):
                trained, record = train_epoch_together(trained, source, training, keys=keys)
        return record.prediction_loss

    return run


def compiled_update(config: RunConfig, num_runs: int) -> Any:
    """The compiled program of one update of so many runs on given transitions."""
    batch = config.training.batch_size
    once = changed(config, {"trajectories_per_epoch": batch})
    states, source, training, keys = _arguments(once, num_runs, fresh=False)
    with jax.default_matmul_precision(PRECISION):
        lowered = train_epoch_together.lower(  # type: ignore[attr-defined]
            states, source, training, keys=keys
        )
        return lowered.compile().compiled


def _arguments(config: RunConfig, num_runs: int, *, fresh: bool) -> Arguments:
    states = initial_states(config, min(num_runs, SEEDS))
    arrays = [eqx.filter(states[run % SEEDS], eqx.is_array) for run in range(num_runs)]
    together = eqx.combine(jax.tree.map(lambda *leaves: jnp.stack(leaves), *arrays), states[0])
    source = fresh_transitions(config) if fresh else transitions(config)
    return together, source, config.training, jax.random.split(jax.random.key(0), num_runs)


@lru_cache
def initial_states(config: RunConfig, num_seeds: int) -> list[TrainState]:
    """The states of so many seeds before their first epoch."""
    data = source_of(config)
    horizon = horizon_of(data.experience)
    seeded = [changed(config, {"seed": seed}) for seed in range(num_seeds)]
    return [init(one, data.scaling, horizon=horizon) for one in seeded]


@lru_cache
def fresh_transitions(config: RunConfig) -> ExperienceSource:
    """What samples an epoch's transitions; one function, so that it is compiled once."""
    return source_of(config).experience


@lru_cache
def transitions(config: RunConfig) -> Experience:
    """One epoch's transitions, to learn from again and again."""
    return sampler(config)(jax.random.key(0), jnp.array(0))
