"""Range scans in a large building: the index of walls beside visiting all of them."""

import os
import sys
from functools import partial

import equinox as eqx
import jax
import jax.numpy as jnp

from benchmarks.harness import Contender, Launch, report, take_turns
from motorspace.worlds.rooms import random_rooms
from motorspace.worlds.sensors.range_fan import RangeFan
from motorspace.worlds.world import WalledWorld

NUM_POSES, NUM_WALLS = 16_384, 10_000
SIDE = 800.0
"""World units; random rooms of 8 units fill this square with about so many walls."""


def main() -> None:
    """Time both, and check that they say the same."""
    threads = int(os.environ["BENCHMARK_THREADS"])
    indexed = random_rooms(size=SIDE, key=jax.random.key(0)).world()
    assert len(indexed.walls) >= NUM_WALLS
    plain = WalledWorld(indexed.walls, indexed.solids, indexed.bounds)
    keys = jax.random.split(jax.random.key(1), NUM_POSES)
    poses = jax.jit(jax.vmap(lambda key: indexed.random_pose(key=key)))(keys)
    fan = RangeFan()
    sense = eqx.filter_jit(lambda world: fan.sense(world, poses))
    contenders = [
        Contender(
            name, partial(lambda world: jax.block_until_ready(sense(world)), world), NUM_POSES
        )
        for name, world in (("motorspace", indexed), ("own brute force", plain))
    ]
    rates, first, foreign = take_turns(contenders)
    apart = float(jnp.max(jnp.abs(sense(indexed) - sense(plain))))
    if apart > 1e-4:
        sys.exit("benchmarks: the index of walls does not answer the same question")
    errors = {"motorspace": {"largest": apart}}
    report(Launch("scans among many walls", "scans", threads, rates, first, errors, foreign))


if __name__ == "__main__":
    main()
