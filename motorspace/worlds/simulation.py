"""Where time passes: one command, a sequence of commands."""

from functools import reduce
from operator import or_
from typing import TypeVar

import jax
import jax.numpy as jnp
from jaxtyping import Array

from motorspace._types import Count, Counts, Displacement, Flags, Motor, Motors, Pose
from motorspace.se2 import relative
from motorspace.worlds.agents import AbstractAgent
from motorspace.worlds.world import AbstractWorld

Tree = TypeVar("Tree")


def step(
    world: AbstractWorld, agent: AbstractAgent, pose: Pose, motor: Motor
) -> tuple[Pose, Flags]:
    """The pose after one command, and whether a wall took the translation away."""
    legs = agent.move(pose, motor)
    starts = (pose, *legs[:-1])
    blocked = reduce(or_, [world.blocked(a, b) for a, b in zip(starts, legs, strict=True)])
    return select(blocked, agent.turn(pose, motor), legs[-1]), blocked


def rollout(world: AbstractWorld, agent: AbstractAgent, start: Pose, motors: Motors) -> Pose:
    """Return the poses along a motor sequence, `start` first: fields of shape [T + 1].

    A command that a wall forbids turns the agent but does not move it.

    Args:
        world: Where it moves.
        agent: What moves.
        start: Its pose before the first command.
        motors: Commands, [T, M], in the agent's units.
    """

    def advance(pose: Pose, motor: Motor) -> tuple[Pose, Pose]:
        after, _ = step(world, agent, pose, motor)
        return after, after

    _, poses = jax.lax.scan(advance, start, motors)
    return jax.tree.map(lambda first, rest: jnp.concatenate([first[None], rest]), start, poses)


def nominal_displacement(
    agent: AbstractAgent, start: Pose, motors: Motors, num_steps: Counts
) -> Displacement:
    """The displacement that the first `num_steps` commands would give with no walls."""

    def advance(pose: Pose, command: tuple[Count, Motor]) -> tuple[Pose, None]:
        index, motor = command
        return select(index < num_steps, agent.move(pose, motor)[-1], pose), None

    steps = jnp.arange(motors.shape[0], dtype=num_steps.dtype)
    end, _ = jax.lax.scan(advance, start, (steps, motors))
    return relative(start.frame, end.frame)


def select(flag: Flags, yes: Tree, no: Tree) -> Tree:
    """Of every agent what it has in `yes` where its flag is set, else in `no`."""

    def chosen(a: Array, b: Array) -> Array:
        return jnp.where(flag.reshape((1,) * (a.ndim - flag.ndim) + flag.shape), a, b)

    return jax.tree.map(chosen, yes, no)


def to_rows(tree: Tree) -> Tree:
    """One row for each agent: from agents in the last axis, as they are simulated."""
    return jax.tree.map(lambda leaf: jnp.moveaxis(leaf, -1, 0), tree)


def to_agents_last(tree: Tree) -> Tree:
    """Agents in the last axis, as they are simulated: from one row for each agent."""
    return jax.tree.map(lambda leaf: jnp.moveaxis(leaf, 0, -1), tree)
