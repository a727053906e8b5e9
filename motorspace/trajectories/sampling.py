"""Draw trajectories from a world: same key, same trajectories."""

import os
from concurrent.futures import ThreadPoolExecutor
from typing import Any, NamedTuple

import equinox as eqx
import jax
import jax.numpy as jnp
from jaxtyping import Array
from jaxtyping import Key as KeyArray

from motorspace._errors import UserError
from motorspace._types import Collision, Count, Key, Keys
from motorspace.trajectories.transitions import Displacements, Experience, Trajectories
from motorspace.worlds.agents import AbstractAgent
from motorspace.worlds.exploration import explore
from motorspace.worlds.geometry import relative
from motorspace.worlds.sensors import AbstractSensor
from motorspace.worlds.simulation import nominal_displacement
from motorspace.worlds.world import AbstractWorld

CHUNK_SIZE = 8192
"""Trajectories simulated at once: what is needed beside the result stays bounded."""

COPIES = 2
"""How many times the result's size is in use at most while it is put together."""


def sample(
    world: AbstractWorld,
    agent: AbstractAgent,
    sensor: AbstractSensor[Any],
    *,
    num: int,
    horizon: int,
    min_horizon: int | None = None,
    collision: Collision = "resample",
    key: Key,
) -> Trajectories:
    """`num` trajectories of `horizon` random commands each, from random free places.

    With `min_horizon` every trajectory draws its length uniformly from `min_horizon` to
    `horizon`. `collision` says what becomes of a command that a wall forbids: `"resample"`
    draws another, so that the displacement is a function of the sequence (after 30 refusals
    in a row the trajectory begins anew elsewhere); `"block"` logs it and discards its
    translation. Trajectory i depends on `key` and i alone.

    Raises `UserError` for sizes below one, and, before anything is allocated, for a number of
    trajectories that does not fit into the machine's memory.
    """
    shortest = horizon if min_horizon is None else min_horizon
    if num < 1 or shortest < 1 or horizon < shortest:
        raise UserError(
            f"cannot sample {num} trajectories of {shortest} to {horizon} steps",
            remedy="ask for at least one trajectory of at least one step",
        )
    sizes = horizon, len(agent.motor_scale), len(sensor.scale(world))
    _refuse_what_does_not_fit(num, bytes_per_trajectory(*sizes))
    plan = SamplingPlan(min(num, CHUNK_SIZE), horizon, collision)
    lengths = jnp.array(shortest), jnp.array(horizon)
    if num <= CHUNK_SIZE:
        return simulate(world, agent, sensor, plan, lengths, key=key)

    def run(keys: Keys) -> Trajectories:
        return jax.block_until_ready(_each(world, agent, sensor, plan, lengths, keys))

    # A thread per core: within one chunk the compiler finds too little to share out.
    with ThreadPoolExecutor(os.cpu_count()) as pool:
        drawn = list(pool.map(run, _chunks(jax.random.split(key, num))))
    return jax.tree.map(lambda *leaves: jnp.concatenate(leaves)[:num], *drawn)


def bytes_per_trajectory(horizon: int, motor_size: int, sensor_size: int) -> int:
    """Size of one trajectory: commands, sensors before and after, length, two displacements."""
    return 4 * (horizon * motor_size + 2 * sensor_size + 1 + 2 * 3)


def _refuse_what_does_not_fit(num: int, size: int) -> None:
    memory = os.sysconf("SC_PHYS_PAGES") * os.sysconf("SC_PAGE_SIZE")
    fitting = memory // (COPIES * size)
    if num > fitting:
        raise UserError(
            f"{num:,} trajectories do not fit into {memory / 2**30:.0f} GiB of memory",
            remedy=f"ask for at most {fitting:,} at a time",
        )


class SamplingPlan(NamedTuple):
    """What is fixed when sampling is compiled."""

    num: int
    horizon: int
    collision: Collision


@eqx.filter_jit
def simulate(
    world: AbstractWorld,
    agent: AbstractAgent,
    sensor: AbstractSensor[Any],
    plan: SamplingPlan,
    lengths: tuple[Count, Count],
    *,
    key: Key,
) -> Trajectories:
    """What `sample` returns, compiled; the shortest and longest length may be traced."""

    def run(keys: Keys) -> Trajectories:
        return _each(world, agent, sensor, plan, lengths, keys)

    keys = jax.random.split(key, plan.num)
    if plan.num <= CHUNK_SIZE:
        return run(keys)
    drawn = jax.lax.map(run, _chunks(keys))
    return jax.tree.map(lambda leaf: leaf.reshape(-1, *leaf.shape[2:])[: plan.num], drawn)


def _chunks(keys: KeyArray[Array, " N"]) -> KeyArray[Array, "J C"]:
    """The keys in rows of `CHUNK_SIZE`, the last one filled up with the first ones."""
    return jnp.resize(keys, (-(-len(keys) // CHUNK_SIZE), CHUNK_SIZE))


@eqx.filter_jit
def _each(
    world: AbstractWorld,
    agent: AbstractAgent,
    sensor: AbstractSensor[Any],
    plan: SamplingPlan,
    lengths: tuple[Count, Count],
    keys: Keys,
) -> Trajectories:
    """One trajectory for each key."""
    steps_keys, keys = jnp.moveaxis(jax.vmap(jax.random.split)(keys), 1, 0)
    share = jax.vmap(jax.random.uniform)(steps_keys)
    num_steps = lengths[0] + jnp.floor(share * (lengths[1] - lengths[0] + 1)).astype(int)
    done = explore(
        world, agent, num_steps, horizon=plan.horizon, collision=plan.collision, keys=keys
    )
    nominal = nominal_displacement(agent, done.start, done.motors, done.steps_done)
    achieved = relative(done.start, done.pose)
    experience = Experience(
        sensors=sensor.sense(world, done.start).T,
        motors=jnp.moveaxis(done.motors, -1, 0),
        num_steps=done.steps_done,
        later_sensors=sensor.sense(world, done.pose).T,
    )
    return Trajectories(experience, Displacements(nominal.T, achieved.T))
