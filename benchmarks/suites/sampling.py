"""What drawing fresh trajectories costs of an epoch as the paper trains."""

import os
from collections.abc import Callable

import jax
import jax.numpy as jnp

from benchmarks.harness import Contender, Launch, report, take_turns
from motorspace._types import Count, Key
from motorspace.training.config import RunConfig
from motorspace.training.fit import horizon_of, init, train_epoch
from motorspace.training.settings import changed
from motorspace.training.sources import simulator, source_of
from motorspace.trajectories.transitions import Experience


def main() -> None:
    """Epochs with their sampling, and the sampling alone: the ratio of their rates is its share."""
    config = changed(RunConfig(), {"curriculum": 0.0})
    draw, key, epoch = sampler(config), jax.random.key(0), jnp.array(0)
    num = config.training.trajectories_per_epoch
    alone = Contender("sampling alone", lambda: jax.block_until_ready(draw(key, epoch)), num)
    rates, first, foreign = take_turns([motorspace(config), alone])
    threads = int(os.environ["BENCHMARK_THREADS"])
    report(Launch("an epoch of the paper", "samples", threads, rates, first, {}, foreign))


def sampler(config: RunConfig) -> Callable[[Key, Count], Experience]:
    """What draws an epoch's fresh transitions."""
    draw = simulator(config)
    return jax.jit(lambda key, epoch: draw(key, epoch).experience)


def motorspace(config: RunConfig) -> Contender:
    """Fresh trajectories and the updates on them."""
    data = source_of(config)
    state = init(config, data.scaling, horizon=horizon_of(data.experience))
    key = jax.random.key(0)

    def run() -> None:
        jax.block_until_ready(train_epoch(state, data.experience, config.training, key=key))

    return Contender("motorspace", run, config.training.trajectories_per_epoch)


if __name__ == "__main__":
    main()
