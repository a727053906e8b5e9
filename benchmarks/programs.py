"""What the compiled programs of training are given: of one run, and of many at once."""

from collections.abc import Callable
from functools import lru_cache

import jax
import jax.numpy as jnp

from motorspace._types import Count, Key
from motorspace.models.model import UNSCALED
from motorspace.training.calls import parted, stacked
from motorspace.training.config import RunConfig
from motorspace.training.fit import horizon_of, init, task_of
from motorspace.training.program import Task, TrainState
from motorspace.training.settings import changed
from motorspace.training.sources import simulation_scaling, simulator, source_of
from motorspace.trajectories.transitions import Experience

ONE_EPOCH = jnp.int32(1)
SEEDS = 16
"""Different seeds among many runs; more runs repeat them."""


def of_one(config: RunConfig, experience: Experience | None = None) -> tuple[TrainState, Task]:
    """The state and the task of a run that learns from given transitions or from fresh ones."""
    scaling, source = simulation_scaling(config), experience or source_of(config).experience
    state = init(config, scaling, horizon=horizon_of(source))
    return state.with_scaling(UNSCALED), task_of(config, scaling, source)


def of_many(config: RunConfig, num: int, *, fresh: bool) -> tuple[TrainState, Task, Task]:
    """The same of runs that differ by their seeds; those on given transitions share these."""
    experience = None if fresh else transitions(config)
    different = min(num, SEEDS)
    runs = [of_one(changed(config, {"seed": seed}), experience) for seed in range(different)]
    states, tasks = zip(*[runs[n % SEEDS] for n in range(num)], strict=True)
    return stacked(states), *parted(tasks)


def sampler(config: RunConfig) -> Callable[[Key, Count], Experience]:
    """What draws an epoch's fresh transitions."""
    draw = simulator(config)
    return jax.jit(lambda key, epoch: draw(key, epoch).experience)


@lru_cache
def transitions(config: RunConfig) -> Experience:
    """One epoch's transitions, to learn from again and again."""
    return sampler(config)(jax.random.key(0), jnp.array(0))
