"""Draw trajectories from a world: same key, same trajectories."""

from typing import Any, NamedTuple

import equinox as eqx
import jax
import jax.numpy as jnp

from motorspace._errors import UserError
from motorspace._types import Collision, Count, Key, Pose
from motorspace.trajectories.trajectories import Displacements, Experience, Trajectories
from motorspace.worlds.agents import AbstractAgent
from motorspace.worlds.geometry import relative
from motorspace.worlds.sensors import AbstractSensor
from motorspace.worlds.simulation import explore, nominal_displacement
from motorspace.worlds.world import AbstractWorld

NUM_STARTS = 4
"""Places that a trajectory may begin at: the later ones are for agents that get stuck."""

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

    def begin(key: Key) -> Pose:
        place_key, head_key = jax.random.split(key)
        return agent.start(world.place(key=place_key), key=head_key)

    def one(key: Key) -> Trajectories:
        start_key, steps_key, motor_key = jax.random.split(key, 3)
        starts = jax.vmap(begin)(jax.random.split(start_key, NUM_STARTS))
        num_steps = jax.random.randint(steps_key, (), lengths[0], lengths[1] + 1)
        done = explore(
            world,
            agent,
            starts,
            num_steps=num_steps,
            horizon=plan.horizon,
            collision=plan.collision,
            key=motor_key,
        )
        start = jax.tree.map(lambda field: field[done.attempt], starts)
        experience = Experience(
            sensors=sensor.sense(world, start),
            motors=done.motors,
            num_steps=done.steps_done,
            later_sensors=sensor.sense(world, done.pose),
        )
        displacements = Displacements(
            nominal=nominal_displacement(agent, start, done.motors, done.steps_done),
            achieved=relative(start, done.pose),
        )
        return Trajectories(experience, displacements)

    keys = jax.random.split(key, plan.num)
    return jax.lax.map(one, keys, batch_size=min(CHUNK_SIZE, plan.num))
