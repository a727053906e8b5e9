"""Trajectories: six random steps among twelve walls, scans before and after."""

import ctypes
import math
import os
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor

import jax
import numpy as np
import torch

from benchmarks.harness import Contender, Launch, report, take_turns
from benchmarks.roofline import compiled
from benchmarks.suites.sensing import FAN, LAYOUT, MAX_RANGE, NUM_RAYS, vmas_world
from motorspace.trajectories.sampling import sample
from motorspace.worlds.agents import ForwardAgent
from motorspace.worlds.layouts import layout
from motorspace.worlds.scenario import Scenario
from motorspace.worlds.sensors.range_fan import RangeFan
from motorspace.worlds.world import WalledWorld

NUM, HORIZON = 65_536, 6
BATCHES = (1_024, 8_192)
"""What VMAS is tried with; the faster one counts."""


def main() -> None:
    """Ours, whose forbidden commands are drawn again, and a physics engine's."""
    threads = int(os.environ["BENCHMARK_THREADS"])
    world = layout(LAYOUT)
    torch.set_num_threads(threads)
    contenders = [
        motorspace(world),
        *(vmas(world, num) for num in BATCHES),
        by_hand(world, threads),
    ]
    rates, first, foreign = take_turns(contenders)
    report(Launch("trajectories", "trajectories", threads, rates, first, {}, foreign))


def motorspace(world: WalledWorld) -> Contender:
    agent, fan, key = ForwardAgent(), RangeFan(NUM_RAYS, MAX_RANGE), jax.random.key(0)

    def run() -> None:
        jax.block_until_ready(
            sample(Scenario(world, agent, fan), num=NUM, horizon=HORIZON, key=key)
        )

    return Contender("motorspace", run, NUM)


def vmas(world: WalledWorld, num: int) -> Contender:
    """VMAS: forces on a sphere that walls stop, where ours are displacements."""
    scan, step = vmas_moves(world, num)

    def run() -> None:
        scan()
        for _ in range(HORIZON):
            step()
        scan()

    return Contender(f"VMAS, batch {num}", run, num)


def vmas_moves(
    world: WalledWorld, num: int
) -> tuple[Callable[[], torch.Tensor], Callable[[], None]]:
    """What scans, and what takes one random step, in `num` of VMAS's worlds at once."""
    places, agent = vmas_world(world, num)
    rng = np.random.default_rng(0)
    agent.set_pos(torch.tensor(rng.uniform(1, 39, (num, 2))).float(), batch_index=None)

    @torch.no_grad()
    def scan() -> torch.Tensor:
        angles = torch.tensor(FAN).float() + torch.rand(num, 1) * 6.28
        return places.cast_rays(
            agent, angles, max_range=MAX_RANGE, entity_filter=lambda e: e is not agent
        )

    @torch.no_grad()
    def step() -> None:
        agent.action.u = torch.rand(num, 2) * 2 - 1
        places.step()

    return scan, step


def by_hand(world: WalledWorld, threads: int) -> Contender:
    """`sampler.c`, which draws into the same memory again and again."""
    draw, num = compiled("sampler.c").draw, NUM // threads
    draw.restype = ctypes.c_float
    walls = np.ascontiguousarray(world.walls, np.float32)
    fan = np.stack([np.cos(FAN), np.sin(FAN)], 1).astype(np.float32)
    outs = [aligned(num // 8 * 32 * 8) for _ in range(threads)]
    pool = ThreadPoolExecutor(threads)

    def part(thread: int) -> float:
        return draw(
            ctypes.c_long(num),
            pointer(walls),
            len(walls),
            pointer(fan),
            ctypes.c_float(0.8 * math.pi),
            ctypes.c_uint32(thread),
            pointer(outs[thread]),
        )

    run = lambda: list(pool.map(part, range(threads)))  # noqa: E731
    for rejected in run():
        assert 0.1 < rejected < 1.0, "about a third of the trajectories have a command drawn again"
    return Contender("sampler by hand", run, num * threads)


def aligned(size: int) -> np.ndarray:
    """Zeros that begin where vectors may."""
    zeros = np.zeros(size + 8, np.float32)
    first = -zeros.ctypes.data % 32 // 4
    return zeros[first : first + size]


def pointer(array: np.ndarray) -> ctypes.c_void_p:
    return ctypes.c_void_p(array.ctypes.data)


if __name__ == "__main__":
    main()
