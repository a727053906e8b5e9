"""What drawing fresh trajectories costs of an epoch as the paper trains."""

import os

import jax
import jax.numpy as jnp

from benchmarks.harness import Contender, Launch, report, take_turns
from benchmarks.programs import ONE_EPOCH, of_one, sampler
from motorspace.training.config import RunConfig
from motorspace.training.program import train_epochs
from motorspace.training.settings import changed


def main() -> None:
    """Epochs with their sampling, and the sampling alone: the ratio of their rates is its share."""
    config = changed(RunConfig(), {"curriculum": 0.0})
    draw, key, epoch = sampler(config), jax.random.key(0), jnp.array(0)
    num = config.training.trajectories_per_epoch
    alone = Contender("sampling alone", lambda: jax.block_until_ready(draw(key, epoch)), num)
    rates, first, foreign = take_turns([motorspace(config), alone])
    threads = int(os.environ["BENCHMARK_THREADS"])
    report(Launch("an epoch of the paper", "samples", threads, rates, first, {}, foreign))


def motorspace(config: RunConfig) -> Contender:
    """Fresh trajectories and the updates on them."""
    given = of_one(config)

    def run() -> None:
        jax.block_until_ready(train_epochs(*given, ONE_EPOCH))

    return Contender("motorspace", run, config.training.trajectories_per_epoch)


if __name__ == "__main__":
    main()
