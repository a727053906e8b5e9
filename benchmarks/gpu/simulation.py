"""Trajectories and range scans, on the device and on the CPU of the same machine."""

import os
from collections.abc import Callable, Iterator
from functools import cache, partial
from typing import Any, TypeVar

import equinox as eqx
import jax
import jax.numpy as jnp

from benchmarks.gpu.sizes import Sizes
from benchmarks.gpu.timing import Case, Row, rate, timed
from motorspace._types import Pose
from motorspace.trajectories.sampling import SamplingPlan, simulate
from motorspace.trajectories.transitions import Trajectories
from motorspace.worlds.layouts import layout
from motorspace.worlds.rooms import random_rooms
from motorspace.worlds.scenario import Scenario
from motorspace.worlds.sensors.range_fan import RangeFan
from motorspace.worlds.world import WalledWorld

HORIZON = 6
FEW_WALLS = "scans, 12 walls"
Tree = TypeVar("Tree")


def on_cpu(work: str) -> str:
    """What a row of some work is called that the CPU does."""
    return f"{work}, CPU of {len(os.sched_getaffinity(0))} cores"


def moved(tree: Tree, device: Any) -> Tree:
    """The same with its arrays on a device."""
    arrays, rest = eqx.partition(tree, eqx.is_array)
    return eqx.combine(jax.device_put(arrays, device), rest)


def default_device() -> Any:
    """Where JAX computes unless it is asked otherwise."""
    return jax.devices()[0]


def cpu() -> Any:
    """The CPU beside it, on as many cores as the process may use: `taskset -c 0,1` leaves two."""
    return jax.devices("cpu")[0]


def trajectories(sizes: Sizes) -> Iterator[Case]:
    """Trajectories of the forward agent in the paper's world, by how many at once."""
    slow = on_cpu("trajectories")
    for num in sizes.trajectories:
        yield partial(_trajectories, "trajectories", num, default_device(), sizes, beside=slow)
    yield partial(_trajectories, slow, sizes.trajectories[0], cpu(), sizes)


def _trajectories(work: str, num: int, device: Any, sizes: Sizes, **more: Any) -> list[Row]:
    with jax.default_device(device):
        lengths = jnp.array(HORIZON), jnp.array(HORIZON)
        scenario, lengths, key = moved((Scenario(), lengths, jax.random.key(0)), device)
        plan = SamplingPlan(num, HORIZON, "resample")

        def run() -> Trajectories:
            return simulate(scenario, plan, lengths, key=key)

        timing = timed(run, sizes)
    return rate(work, f"{num:,} at once", num, "trajectories/s", timing, **more)


def scans(sizes: Sizes) -> Iterator[Case]:
    """Scans of nine rays among few walls and many, these with their index and without."""
    few, slow = layout("paper"), on_cpu(FEW_WALLS)
    for num in sizes.poses:
        yield partial(scanned, FEW_WALLS, few, num, default_device(), sizes, beside=slow)
    yield partial(scanned, slow, few, sizes.poses[0], cpu(), sizes)
    walls = f"scans, {len(many_walls(sizes.side).walls):,} walls"
    for num in sizes.poses:
        yield partial(_scans_among_many, walls, num, sizes)


def _scans_among_many(walls: str, num: int, sizes: Sizes) -> list[Row]:
    """Both ways to look for the walls; raises `ValueError` where they find other distances."""
    indexed = many_walls(sizes.side)
    plain = WalledWorld(indexed.walls, indexed.solids, indexed.bounds)
    device, given = default_device(), poses(indexed, num)
    apart = float(jnp.max(jnp.abs(sensing(indexed, given)() - sensing(plain, given)())))
    if apart > 1e-3:
        raise ValueError(f"the index and all walls give distances that are {apart} apart")
    visited = f"{walls}, all visited"
    return [
        *scanned(f"{walls}, index", indexed, num, device, sizes, beside=visited, apart=apart),
        *scanned(visited, plain, num, device, sizes),
    ]


def scanned(
    work: str, world: WalledWorld, num: int, device: Any, sizes: Sizes, **more: Any
) -> list[Row]:
    """The row of scans from so many poses at once in a world, on a device."""
    with jax.default_device(device):
        world = moved(world, device)
        timing = timed(sensing(world, poses(world, num)), sizes)
    return rate(work, f"{num:,} poses", num, "scans/s", timing, **more)


def sensing(world: WalledWorld, given: Pose) -> Callable[[], Any]:
    """What scans from all the poses at once."""
    fan = RangeFan()
    sense = eqx.filter_jit(lambda world, poses: fan.sense(world, poses))
    return lambda: sense(world, given)


def poses(world: WalledWorld, num: int) -> Pose:
    """Random poses, on the device that computes by default."""
    keys = jax.random.split(jax.random.key(1), num)
    return jax.jit(jax.vmap(lambda key: world.random_pose(key=key)))(keys)


@cache
def many_walls(side: float) -> WalledWorld:
    """Random rooms in a square, with the index of their walls."""
    return random_rooms(size=side, key=jax.random.key(0)).world()
