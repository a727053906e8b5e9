"""Sensed steps of many agents at once: one command and one scan each."""

import os
from typing import Any

import gymnasium
import jax
import numpy as np
import torch

import motorspace.environments  # noqa: F401, which registers the environments
from benchmarks.harness import Contender, Launch, report, take_turns
from benchmarks.suites.sensing import LAYOUT, MAX_RANGE, NUM_RAYS
from benchmarks.suites.trajectories import vmas_moves
from motorspace.worlds.layouts import layout
from motorspace.worlds.world import WalledWorld

STEPS = 20


def main() -> None:
    """Everybody at two sizes of the batch: the faster one counts."""
    threads, world = int(os.environ["BENCHMARK_THREADS"]), layout(LAYOUT)
    torch.set_num_threads(threads)
    contenders = [
        through_gymnasium(8192, "motorspace"),
        through_gymnasium(1024, "own, batch 1024"),
        *(jaxnav(num) for num in (256, 2048)),
        *(vmas(world, num) for num in (1024, 8192)),
    ]
    rates, first, foreign = take_turns(contenders)
    report(Launch("many agents' sensed steps", "steps", threads, rates, first, {}, foreign))


def through_gymnasium(num: int, name: str) -> Contender:
    """The vector environment: NumPy arrays in and out, agents of a finished episode begin anew."""
    env = gymnasium.make_vec(
        "motorspace/Forward-v0",
        num_envs=num,
        vectorization_mode="vector_entry_point",
        layout=LAYOUT,
        max_episode_steps=10 * STEPS,
    )
    actions = np.random.default_rng(0).uniform(-1, 1, (STEPS, num, 2)).astype(np.float32)
    env.reset(seed=0)

    def run() -> None:
        for action in actions:
            env.step(action)

    return Contender(name, run, STEPS * num)


def jaxnav(num: int) -> Contender:
    """JaxNav: discs that accelerate in a random grid of cells, beams probed every 5 cm."""
    from jaxmarl.environments.jaxnav.jaxnav_env import JaxNav

    env = JaxNav(
        num_agents=1,
        map_params={"map_size": (40, 40), "fill": 0.1, "valid_path_check": False},
        lidar_num_beams=NUM_RAYS,
        lidar_max_range=MAX_RANGE,
        lidar_angle_factor=0.5,
    )
    _, state = jax.jit(jax.vmap(env.reset))(jax.random.split(jax.random.key(0), num))

    @jax.jit
    def steps(state: Any, key: jax.Array) -> Any:
        def advance(state: Any, key: jax.Array) -> Any:
            action = {"agent_0": jax.random.uniform(key, (num, 2), minval=-1.0)}
            seen, state, *_ = jax.vmap(env.step_env)(jax.random.split(key, num), state, action)
            return state, seen["agent_0"][:, 0]

        return jax.lax.scan(advance, state, jax.random.split(key, STEPS))

    run = lambda: jax.block_until_ready(steps(state, jax.random.key(1)))  # noqa: E731
    return Contender(f"JaxNav, batch {num}", run, STEPS * num)


def vmas(world: WalledWorld, num: int) -> Contender:
    """VMAS: a step of its physics and a scan."""
    scan, step = vmas_moves(world, num)

    def run() -> None:
        step()
        scan()

    return Contender(f"VMAS, batch {num}", run, num)


if __name__ == "__main__":
    main()
