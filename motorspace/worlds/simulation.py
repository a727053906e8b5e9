"""The only place where time passes: one command, a sequence of commands, free exploration."""

from typing import NamedTuple

import jax
import jax.numpy as jnp

from motorspace._types import Collision, Count, Displacement, Flag, Key, Motor, Motors, Pose
from motorspace.worlds.agents import AbstractAgent
from motorspace.worlds.geometry import relative
from motorspace.worlds.world import AbstractWorld

MAX_REFUSALS = 30
"""After so many refused commands in a row an agent begins anew elsewhere, as one would that
faces a wall from nearby and cannot turn away."""


def step(world: AbstractWorld, agent: AbstractAgent, pose: Pose, motor: Motor) -> tuple[Pose, Flag]:
    """The pose after one command, and whether a wall took the translation away."""
    legs = agent.move(pose, motor)
    starts = (pose, *legs[:-1])
    blocked = jnp.stack([world.blocked(a, b) for a, b in zip(starts, legs, strict=True)]).any()
    return _select(blocked, agent.turn(pose, motor), legs[-1]), blocked


def rollout(world: AbstractWorld, agent: AbstractAgent, start: Pose, motors: Motors) -> Pose:
    """The poses along a motor sequence, `start` first: fields of shape [T + 1].

    A command that a wall forbids turns the agent but does not move it.
    """

    def advance(pose: Pose, motor: Motor) -> tuple[Pose, Pose]:
        after, _ = step(world, agent, pose, motor)
        return after, after

    _, poses = jax.lax.scan(advance, start, motors)
    return jax.tree.map(lambda first, rest: jnp.concatenate([first[None], rest]), start, poses)


def nominal_displacement(
    agent: AbstractAgent, start: Pose, motors: Motors, num_steps: Count
) -> Displacement:
    """The displacement that the first `num_steps` commands would give with no walls."""

    def advance(pose: Pose, command: tuple[Count, Motor]) -> tuple[Pose, None]:
        index, motor = command
        return _select(index < num_steps, agent.move(pose, motor)[-1], pose), None

    end, _ = jax.lax.scan(advance, start, (jnp.arange(motors.shape[0]), motors))
    return relative(start, end)


class Exploration(NamedTuple):
    """An agent on its way through a motor sequence that it draws itself."""

    attempt: Count
    pose: Pose
    motors: Motors
    steps_done: Count
    refusals: Count
    proposals: Count


def explore(
    world: AbstractWorld,
    agent: AbstractAgent,
    starts: Pose,
    *,
    num_steps: Count,
    horizon: int,
    collision: Collision,
    key: Key,
) -> Exploration:
    """An agent that has drawn and executed `num_steps` commands.

    It sets out from the first of `starts` (fields of shape [A]) and, when the walls refuse too
    many commands in a row, from the next; `attempt` tells from which it arrived. Should it
    fail from the last as well, its sequence ends early. Rows beyond the steps done are zero.

    Under `vmap` every agent keeps its own pace through one loop: one that must redraw a
    command holds up nobody else.
    """
    last = len(starts.x) - 1

    def unfinished(now: Exploration) -> Flag:
        lost = (now.refusals >= MAX_REFUSALS) & (now.attempt == last)
        return (now.steps_done < num_steps) & ~lost

    def propose(now: Exploration) -> Exploration:
        motor = agent.draw(key=jax.random.fold_in(key, now.proposals))
        after, blocked = step(world, agent, now.pose, motor)
        taken = ~blocked if collision == "resample" else jnp.array(True)
        row = (jnp.arange(horizon) == now.steps_done) & taken
        refusals = jnp.where(taken, 0, now.refusals + 1)
        anew = (refusals >= MAX_REFUSALS) & (now.attempt < last)
        attempt = now.attempt + anew
        elsewhere = jax.tree.map(lambda field: field[attempt], starts)
        motors = jnp.where(row[:, None], motor[None], now.motors)
        return Exploration(
            attempt=attempt,
            pose=_select(anew, elsewhere, _select(taken, after, now.pose)),
            motors=jnp.where(anew, 0.0, motors),
            steps_done=jnp.where(anew, 0, now.steps_done + taken),
            refusals=jnp.where(anew, 0, refusals),
            proposals=now.proposals + 1,
        )

    zero = jnp.zeros((), jnp.int32)
    begin = Exploration(
        attempt=zero,
        pose=jax.tree.map(lambda field: field[0], starts),
        motors=jnp.zeros((horizon, len(agent.motor_scale))),
        steps_done=zero,
        refusals=zero,
        proposals=zero,
    )
    return jax.lax.while_loop(unfinished, propose, begin)


def _select(flag: Flag, yes: Pose, no: Pose) -> Pose:
    return jax.tree.map(lambda a, b: jnp.where(flag, a, b), yes, no)
