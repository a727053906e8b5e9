"""Trajectories sampled in a scenario: same key, same trajectories."""

import os
from concurrent.futures import ThreadPoolExecutor
from typing import NamedTuple

import equinox as eqx
import jax
import jax.numpy as jnp
from jaxtyping import Array
from jaxtyping import Key as KeyArray

from motorspace._errors import UserError
from motorspace._types import Collision, Count, Key, Keys
from motorspace.se2 import relative
from motorspace.trajectories.transitions import Displacements, Experience, Trajectories
from motorspace.worlds.checks import one_of, whole
from motorspace.worlds.exploration import Policy, explore
from motorspace.worlds.scenario import Scenario, WorldLike
from motorspace.worlds.simulation import nominal_displacement, to_rows

CHUNK_SIZE = 8192
"""Trajectories simulated at once: what is needed beside the result stays bounded."""

PERTURBATION = 1
"""What the key of a trajectory is folded with for what a sensor reads by chance."""

COPIES = 2
"""How many times the result's size is in use at most while it is put together."""


def sample(
    scenario: Scenario | WorldLike = "paper",
    *,
    num: int,
    horizon: int,
    min_horizon: int | None = None,
    collision: Collision = "resample",
    policy: Policy | None = None,
    key: Key,
) -> Trajectories:
    """Trajectories of random commands from random free places.

    Trajectory i depends on `key` and i alone.

    Args:
        scenario: Where to sample; a world, layout, file or name stands for `Scenario(world)`.
        num: How many trajectories.
        horizon: Commands of each trajectory.
        min_horizon: Shortest trajectory, when lengths are uniform from `min_horizon` to `horizon`.
        collision: What becomes of a command that a wall forbids. `"resample"` tries another, so
            that the displacement is a function of the sequence (after 30 refusals in a row the
            trajectory begins anew elsewhere); `"block"` logs it and discards its translation.
        policy: Commands as a function of a key; uniform in the agent's command space by default.
        key: Source of randomness.

    Returns:
        `num` transitions with their displacements.

    Raises:
        UserError: For sizes below 1, and, before anything is allocated, for more trajectories than
            fit into the machine's memory.
    """
    if not isinstance(scenario, Scenario):
        scenario = Scenario(scenario)
    shortest = check_sizes(num, horizon, min_horizon)
    one_of("collision", collision, ("resample", "block"))
    sizes = horizon, scenario.commands.size, scenario.space.size
    _refuse_what_does_not_fit(num, bytes_per_trajectory(*sizes))
    plan = SamplingPlan(min(num, CHUNK_SIZE), horizon, collision, policy)
    lengths = jnp.array(shortest, jnp.int32), jnp.array(horizon, jnp.int32)
    if num <= CHUNK_SIZE:
        return simulate(scenario, plan, lengths, key=key)

    def run(keys: Keys) -> Trajectories:
        return jax.block_until_ready(_each(scenario, plan, lengths, keys))

    # A thread per core: within one chunk the compiler finds too little to share out.
    with ThreadPoolExecutor(os.cpu_count()) as pool:
        chunks = list(pool.map(run, _chunks(jax.random.split(key, num))))
    return jax.tree.map(lambda *leaves: jnp.concatenate(leaves)[:num], *chunks)


def check_sizes(num: int, horizon: int, min_horizon: int | None) -> int:
    """The shortest trajectory's length. Raises `UserError` for sizes that cannot be sampled."""
    whole("num", num)
    whole("horizon", horizon)
    if min_horizon is None:
        return horizon
    whole("min_horizon", min_horizon)
    if min_horizon > horizon:
        raise UserError(
            f"min_horizon {min_horizon} is above horizon {horizon}",
            remedy="give a min_horizon from 1 to horizon",
        )
    return min_horizon


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
    collision: Collision = "resample"
    policy: Policy | None = None


@eqx.filter_jit
def simulate(
    scenario: Scenario,
    plan: SamplingPlan,
    lengths: tuple[Count, Count],
    *,
    key: Key,
) -> Trajectories:
    """What `sample` returns, compiled; the shortest and longest length may be traced."""

    def run(keys: Keys) -> Trajectories:
        return _each(scenario, plan, lengths, keys)

    keys = jax.random.split(key, plan.num)
    if plan.num <= CHUNK_SIZE:
        return run(keys)
    chunks = jax.lax.map(run, _chunks(keys))
    return jax.tree.map(lambda leaf: leaf.reshape(-1, *leaf.shape[2:])[: plan.num], chunks)


def _chunks(keys: KeyArray[Array, " N"]) -> KeyArray[Array, "J C"]:
    """The keys in rows of `CHUNK_SIZE`, the last one filled up with the first ones."""
    return jnp.resize(keys, (-(-len(keys) // CHUNK_SIZE), CHUNK_SIZE))


@eqx.filter_jit
def _each(
    scenario: Scenario,
    plan: SamplingPlan,
    lengths: tuple[Count, Count],
    keys: Keys,
) -> Trajectories:
    """One trajectory for each key."""
    steps_keys, keys = jnp.moveaxis(jax.vmap(jax.random.split)(keys), 1, 0)
    share = jax.vmap(lambda key: jax.random.uniform(key, (), jnp.float32))(steps_keys)
    spread = (lengths[1] - lengths[0] + 1).astype(jnp.float32)
    num_steps = lengths[0] + jnp.floor(share * spread).astype(jnp.int32)
    done = explore(
        scenario.world,
        scenario.agent,
        num_steps,
        horizon=plan.horizon,
        collision=plan.collision,
        keys=keys,
        policy=plan.policy,
    )
    nominal = nominal_displacement(scenario.agent, done.start, done.motors, done.steps_done)
    achieved = relative(done.start.frame, done.pose.frame)
    sensors, later = jax.vmap(
        lambda before, after, key: scenario.sensor.perturbed(before, after, key=key)
    )(
        to_rows(scenario.sense(done.start)),
        to_rows(scenario.sense(done.pose)),
        jax.vmap(lambda key: jax.random.fold_in(key, PERTURBATION))(keys),
    )
    experience = Experience(
        sensors=sensors,
        motors=to_rows(done.motors),
        num_steps=done.steps_done,
        later_sensors=later,
    )
    return Trajectories(experience, Displacements(to_rows(nominal), to_rows(achieved)))
