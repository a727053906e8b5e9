"""A system of the paper: 2,000 fresh trajectories, then 20 updates of 100, again and again."""

import os

import jax
import jax.numpy as jnp
import torch

from benchmarks.harness import Contender, Launch, report, take_turns
from benchmarks.roofline import fma_peak
from benchmarks.suites.sampling import motorspace, sampler
from benchmarks.suites.sensing import LAYOUT
from benchmarks.suites.training import Fused, Paper, Unrolled, pytorch
from benchmarks.suites.trajectories import vmas
from motorspace.training.config import RunConfig
from motorspace.training.settings import changed
from motorspace.worlds.layouts import layout
from motorspace.worlds.world import WalledWorld


def main() -> None:
    """Ours, and PyTorch's two ways on trajectories of the fastest peer simulator, VMAS."""
    threads, world = int(os.environ["BENCHMARK_THREADS"]), layout(LAYOUT)
    torch.set_num_threads(threads)
    config = changed(RunConfig(), {"layout": LAYOUT, "curriculum": 0.0})
    contenders = [
        motorspace(config),
        with_vmas("VMAS and nn.LSTM", Fused(), world, config),
        with_vmas("VMAS and torch.compile", torch.compile(Unrolled()), world, config),
        fma_peak(threads),
    ]
    rates, first, foreign = take_turns(contenders, seconds=1.5)
    report(Launch("a system of the paper", "samples", threads, rates, first, {}, foreign))


def with_vmas(name: str, network: Paper, world: WalledWorld, config: RunConfig) -> Contender:
    """What VMAS's epoch costs, then an epoch of updates on transitions of ours, alike in shape."""
    num, batch = config.training.trajectories_per_epoch, config.training.batch_size
    data = sampler(config)(jax.random.key(0), jnp.array(0))
    drawing = vmas(world, num)
    updates = pytorch(name, network, data, batch)

    def run() -> None:
        drawing.run()
        updates.run()

    return Contender(name, run, num)


if __name__ == "__main__":
    main()
