"""Draw trajectories from a world: same key, same trajectories."""

from typing import Any, NamedTuple

import equinox as eqx
import jax
import jax.numpy as jnp

from motorspace._errors import UserError
from motorspace._types import Collision, Count, Key, Keys
from motorspace.trajectories.trajectories import Displacements, Experience, Trajectories
from motorspace.worlds.agents import AbstractAgent
from motorspace.worlds.exploration import explore
from motorspace.worlds.geometry import relative
from motorspace.worlds.sensors import AbstractSensor
from motorspace.worlds.simulation import nominal_displacement
from motorspace.worlds.world import AbstractWorld

CHUNK_SIZE = 8192
"""Trajectories simulated at once: memory stays bounded however many are asked for."""


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

    Raises `UserError` for sizes below one.
    """
    shortest = horizon if min_horizon is None else min_horizon
    if num < 1 or shortest < 1 or horizon < shortest:
        raise UserError(
            f"cannot sample {num} trajectories of {shortest} to {horizon} steps",
            remedy="ask for at least one trajectory of at least one step",
        )
    plan, lengths = (
        SamplingPlan(num, horizon, collision),
        (jnp.array(shortest), jnp.array(horizon)),
    )
    return simulate(world, agent, sensor, plan, lengths, key=key)


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

    keys = jax.random.split(key, plan.num)
    if plan.num <= CHUNK_SIZE:
        return run(keys)
    num_chunks = -(-plan.num // CHUNK_SIZE)
    chunks = jnp.resize(keys, (num_chunks, CHUNK_SIZE))
    drawn = jax.lax.map(run, chunks)
    return jax.tree.map(lambda leaf: leaf.reshape(-1, *leaf.shape[2:])[: plan.num], drawn)
