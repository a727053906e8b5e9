"""What drawing fresh trajectories costs of an epoch as the paper trains."""

import os
from dataclasses import replace

import jax
import jax.numpy as jnp

from benchmarks.harness import Contender, Launch, report, take_turns
from motorspace import RunConfig, fresh_experience, simulation_scaling
from motorspace.experiments.paper import FORWARD
from motorspace.training.fit import init, train_epoch


def main() -> None:
    """Epochs with their sampling, and the sampling alone: the ratio of their rates is its share."""
    config = replace(FORWARD, training=replace(FORWARD.training, curriculum=0.0))
    draw, key, epoch = jax.jit(fresh_experience(config)), jax.random.key(0), jnp.array(0)
    num = config.training.trajectories_per_epoch
    alone = Contender("sampling alone", lambda: jax.block_until_ready(draw(key, epoch)), num)
    rates, first, foreign = take_turns([motorspace(config), alone])
    threads = int(os.environ["BENCHMARK_THREADS"])
    report(Launch("an epoch of the paper", "samples", threads, rates, first, {}, foreign))


def motorspace(config: RunConfig) -> Contender:
    """Fresh trajectories and the updates on them."""
    source, scaling = fresh_experience(config), simulation_scaling(config)
    state = init(config.training, config.model, scaling, horizon=config.simulation.horizon)
    key = jax.random.key(0)

    def run() -> None:
        jax.block_until_ready(train_epoch(state, source, config.training, config.model, key=key))

    return Contender("motorspace", run, config.training.trajectories_per_epoch)


if __name__ == "__main__":
    main()
