"""Trajectories: six random steps among twelve walls, scans before and after."""

import os

import jax
import numpy as np
import torch

from benchmarks.harness import Contender, Launch, report, take_turns
from benchmarks.sensing import FAN, MAX_RANGE, NUM_RAYS, vmas_world
from motorspace import ForwardAgent, RangeFan, WalledWorld, layout, sample

NUM, HORIZON = 65_536, 6
BATCHES = (1_024, 8_192)
"""What VMAS is tried with; the faster one counts."""


def main() -> None:
    """Ours, whose forbidden commands are drawn again, and a physics engine's."""
    threads = int(os.environ["BENCHMARK_THREADS"])
    world = layout("benchmarks/w12.layout")
    torch.set_num_threads(threads)
    contenders = [motorspace(world), *(vmas(world, num) for num in BATCHES)]
    rates, first, foreign = take_turns(contenders)
    report(Launch("trajectories", "trajectories", threads, rates, first, {}, foreign))


def motorspace(world: WalledWorld) -> Contender:
    agent, fan, key = ForwardAgent(), RangeFan(NUM_RAYS, MAX_RANGE), jax.random.key(0)

    def run() -> None:
        jax.block_until_ready(sample(world, agent, fan, num=NUM, horizon=HORIZON, key=key))

    return Contender("motorspace", run, NUM)


def vmas(world: WalledWorld, num: int) -> Contender:
    """VMAS: forces on a sphere that walls stop, where ours are displacements."""
    places, agent = vmas_world(world, num)
    rng = np.random.default_rng(0)
    agent.set_pos(torch.tensor(rng.uniform(1, 39, (num, 2))).float(), batch_index=None)

    def scan() -> torch.Tensor:
        angles = torch.tensor(FAN).float() + torch.rand(num, 1) * 6.28
        return places.cast_rays(
            agent, angles, max_range=MAX_RANGE, entity_filter=lambda e: e is not agent
        )

    def run() -> None:
        with torch.no_grad():
            scan()
            for _ in range(HORIZON):
                agent.action.u = torch.rand(num, 2) * 2 - 1
                places.step()
            scan()

    return Contender(f"VMAS, batch {num}", run, num)


if __name__ == "__main__":
    main()
