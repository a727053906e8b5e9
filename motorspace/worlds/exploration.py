"""Free exploration: agents try random commands until each has executed as many as it should."""

from typing import NamedTuple, Protocol, runtime_checkable

import equinox as eqx
import jax
import jax.numpy as jnp
from jaxtyping import Array, Float, Int

from motorspace._types import Collision, Count, Flags, Key, Keys, Motor, Pose
from motorspace.worlds.agents import AbstractAgent
from motorspace.worlds.simulation import select, step
from motorspace.worlds.world import AbstractWorld

MAX_REFUSALS = 30
"""After so many refused commands in a row an agent begins anew elsewhere, as one would that
faces a wall from nearby and cannot turn away."""

MAX_ATTEMPTS = 256
"""So many places an agent tries to begin at; then its sequence ends early."""

STAGES = ((1, 1), (8, 2), (64, 8))
"""Agents keep step while more than 1 in 8 of them is under way, then those late ones among
themselves while more than 1 in 64 is, and so on: (one in how many, commands tried at once)."""

FEWEST = 16
"""A stage of fewer agents than this is not worth its compilation."""


@runtime_checkable
class Policy(Protocol):
    """What an agent explores with: one command for each key; walls may refuse it."""

    def __call__(self, *, key: Key) -> Motor:
        """The command [M] for this key."""


class Exploration(NamedTuple):
    """N agents on their way through motor sequences of their own."""

    start: Pose
    """Where the sequence began."""
    attempt: Int[Array, " N"]
    """How many other starts were given up, or were no free place."""
    pose: Pose
    motors: Float[Array, "T M N"]
    """Rows beyond the steps done are zero."""
    steps_done: Int[Array, " N"]
    refusals: Int[Array, " N"]
    """Commands refused in a row; `MAX_REFUSALS` as well where nobody can stand."""
    proposals: Int[Array, " N"]
    """Commands tried: number p of an agent depends on its key and p alone."""


class Assignment(NamedTuple):
    """What each of N agents has to do."""

    num_steps: Int[Array, " N"]
    start_keys: Keys
    motor_keys: Keys


def explore(
    world: AbstractWorld,
    agent: AbstractAgent,
    num_steps: Int[Array, " N"],
    *,
    horizon: int,
    collision: Collision,
    keys: Keys,
    policy: Policy | None = None,
) -> Exploration:
    """Agents that have executed `num_steps` commands each, at most `horizon`.

    The commands come from `policy`, by default uniformly from the agent's command space. An agent
    whose commands the walls refuse too often in a row begins anew elsewhere. With `"block"` nothing
    is refused. Agents that walls hold up do not hold up the others (`STAGES`), and nobody's
    trajectory depends on who else is there.
    """
    start_keys, motor_keys = jnp.moveaxis(jax.vmap(jax.random.split)(keys), 1, 0)
    zero = jnp.zeros((len(keys),), jnp.int32)
    nowhere = Pose(*jnp.zeros((4, len(keys)), jnp.float32))
    blank = Exploration(
        start=nowhere,
        attempt=zero - 1,
        pose=nowhere,
        motors=jnp.zeros((horizon, agent.commands.size, len(keys)), jnp.float32),
        steps_done=zero,
        refusals=zero + MAX_REFUSALS,
        proposals=zero,
    )
    assigned = Assignment(num_steps.astype(jnp.int32), start_keys, motor_keys)
    shared = Shared(world, agent, agent.commands.sample if policy is None else policy, collision)
    worth = [s for s in STAGES[1:] if len(keys) >= FEWEST * s[0] and collision == "resample"]
    stages = (STAGES[0], *worth)
    return _finish(shared, assigned, _begin_anew(shared, assigned, blank), stages)


class Shared(eqx.Module):
    """What all agents have in common."""

    world: AbstractWorld
    agent: AbstractAgent
    policy: Policy
    collision: Collision = eqx.field(static=True)


def _finish(
    shared: Shared,
    assigned: Assignment,
    now: Exploration,
    stages: tuple[tuple[int, int], ...],
) -> Exploration:
    """Everybody's exploration, done."""
    (share, at_once), *later = stages
    num_agents = len(assigned.num_steps)
    num_late = -(-num_agents * share // later[0][0]) if later else 0
    # While all are together, who is stuck waits for a later stage to begin anew.
    patient = share == 1 and bool(later)

    def together(now: Exploration) -> Exploration:
        if not patient:
            now = _begin_anew(shared, assigned, now)
        return _propose(shared, assigned, now, at_once=at_once)

    def some_late(now: Exploration) -> Exploration:
        late = jnp.nonzero(_unfinished(now, assigned), size=num_late, fill_value=num_agents)[0]
        rows = late.clip(max=num_agents - 1)
        few, their = jax.tree.map(lambda leaf: leaf[..., rows], (now, assigned))
        few = _finish(shared, their, few, tuple(later))
        return jax.tree.map(lambda a, b: a.at[..., late].set(b, mode="drop"), now, few)

    going = _under_way if patient else _unfinished
    now = jax.lax.while_loop(lambda now: going(now, assigned).sum() > num_late, together, now)
    if not later:
        return now
    return jax.lax.while_loop(lambda now: _unfinished(now, assigned).any(), some_late, now)


def _under_way(now: Exploration, assigned: Assignment) -> Flags:
    return (now.steps_done < assigned.num_steps) & (now.refusals < MAX_REFUSALS)


def _unfinished(now: Exploration, assigned: Assignment) -> Flags:
    may_begin_anew = (now.steps_done < assigned.num_steps) & (now.attempt < MAX_ATTEMPTS - 1)
    return _under_way(now, assigned) | may_begin_anew


def _begin_anew(shared: Shared, assigned: Assignment, now: Exploration) -> Exploration:
    """Unfinished agents that were refused too often stand at another place, if it is free."""

    def start(key: Key, attempt: Count) -> Pose:
        place_key, head_key = jax.random.split(jax.random.fold_in(key, attempt))
        return shared.agent.start(shared.world.random_pose(key=place_key), key=head_key)

    attempt = now.attempt + 1
    pose = jax.vmap(start)(assigned.start_keys, attempt)
    zero = jnp.zeros_like(now.steps_done)
    refusals = jnp.where(shared.world.free(pose), 0, MAX_REFUSALS)
    motors = jnp.zeros_like(now.motors)
    anew = Exploration(pose, attempt, pose, motors, zero, refusals, now.proposals)
    return select(_unfinished(now, assigned) & ~_under_way(now, assigned), anew, now)


def _propose(
    shared: Shared, assigned: Assignment, now: Exploration, *, at_once: int
) -> Exploration:
    """Agents under way try up to `at_once` commands each and execute the first possible one."""
    tried = jnp.arange(at_once, dtype=jnp.int32)[:, None]
    keys = jax.vmap(jax.vmap(jax.random.fold_in), (None, 0))(
        assigned.motor_keys, now.proposals[None] + tried
    )
    each = jax.vmap(jax.vmap(lambda key: shared.policy(key=key), out_axes=-1), out_axes=1)
    motors = each(keys)
    here = jax.tree.map(lambda field: jnp.broadcast_to(field, keys.shape), now.pose)
    after, blocked = step(shared.world, shared.agent, here, motors)
    possible = ~blocked if shared.collision == "resample" else jnp.ones_like(blocked)
    possible &= tried < (MAX_REFUSALS - now.refusals)[None]
    first = possible & (jnp.cumsum(possible, axis=0) == 1)
    taken = first.any(axis=0)

    def chosen(field: Float[Array, "... J N"]) -> Float[Array, "... N"]:
        of_each = first.reshape((1,) * (field.ndim - 2) + first.shape)
        return jnp.sum(jnp.where(of_each, field, 0.0), axis=-2)

    row = (jnp.arange(len(now.motors), dtype=jnp.int32)[:, None] == now.steps_done[None]) & taken[
        None
    ]
    used = jnp.where(taken, jnp.argmax(first, axis=0).astype(jnp.int32) + 1, at_once)
    used = jnp.minimum(used, MAX_REFUSALS - now.refusals)
    then = now._replace(
        pose=select(taken, jax.tree.map(chosen, after), now.pose),
        motors=jnp.where(row[:, None], chosen(motors)[None], now.motors),
        steps_done=now.steps_done + taken.astype(jnp.int32),
        refusals=jnp.where(taken, 0, now.refusals + used),
        proposals=now.proposals + used,
    )
    return select(_under_way(now, assigned), then, now)
