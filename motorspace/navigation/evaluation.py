"""How well somebody solves problems, each of them once."""

from typing import Any, NamedTuple

import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Bool, Float, Int

from motorspace._types import Key, Pose
from motorspace.navigation.actors import AbstractActor
from motorspace.navigation.arena import Arena, State
from motorspace.navigation.problems import Problem
from motorspace.worlds.simulation import select, to_agents_last

Numbers = dict[str, float]


class Episodes(NamedTuple):
    """What came of P problems of each of N agents."""

    reached: Bool[Array, "P N"]
    steps: Int[Array, "P N"]
    """The agent's own commands."""
    decisions: Int[Array, "P N"]
    """How often it has decided: less often than that where an action is several commands."""
    walked: Float[Array, "P N"]
    """The length of its way, world units."""
    distance: Float[Array, "P N"]
    """The length of the shortest way from where it began to act, world units."""
    around: Bool[Array, "P N"]
    """Whether the shortest way leads around a wall."""
    cells: Int[Array, "P N"]
    """The cells it has been in, where the task asks for them."""


def evaluate_actor(arena: Arena, actor: AbstractActor, *, key: Key) -> Numbers:
    """Return how well somebody solves the problems of an arena, each of them once.

    Args:
        arena: The task, its worlds and problems.
        actor: Who acts.
        key: The source of what is random about it.

    Returns:
        For a goal: `success`, the share of goals reached; `success.around`, of those behind a wall;
        `spl`, success weighted by the shortest way over the one walked (Anderson et al., 2018);
        `steps` and `decisions`, how many commands and decisions that took on average where the goal
        was reached. For coverage: `cells`,
        the mean number of cells entered. And `num`, the number of problems.
    """
    return measures(arena, run_episodes(arena, actor, key=key))


def measures(arena: Arena, done: Episodes) -> Numbers:
    """The measures of episodes in an arena; see `evaluate_actor`."""
    num = {"num": float(done.reached.size)}
    if not arena.task.has_goal:
        return {"cells": float(done.cells.mean()), **num}
    return numbers(done, arena.task.radius) | num


def numbers(done: Episodes, radius: float) -> Numbers:
    """The measures of episodes that have a goal; NaN where no episode is of the kind."""
    reached, around = np.asarray(done.reached), np.asarray(done.around)
    # The way ends at the rim of the goal.
    shortest = np.maximum(np.asarray(done.distance) - radius, 0.0)
    share = shortest / np.maximum(np.maximum(np.asarray(done.walked), shortest), 1e-6)
    return {
        "success": float(reached.mean()),
        "success.around": _mean(reached[around]),
        "spl": float((reached * share).mean()),
        "steps": _mean(np.asarray(done.steps)[reached]),
        "decisions": _mean(np.asarray(done.decisions)[reached]),
    }


def _mean(values: np.ndarray) -> float:
    return float(values.mean()) if len(values) else float("nan")


@eqx.filter_jit
def run_episodes(arena: Arena, actor: AbstractActor, *, key: Key) -> Episodes:
    """Every problem of an arena, from its beginning to its end."""

    def one(given: tuple[Int[Array, ""], Key]) -> Episodes:
        row, key = given
        state = arena.begin_at(jnp.full(arena.num_agents, row))
        return run_episode(arena, actor, state, key=key)[0]

    rows = jnp.arange(arena.num_problems, dtype=jnp.int32)
    return jax.lax.map(one, (rows, jax.random.split(key, arena.num_problems)))


@eqx.filter_jit
def run_episode(
    arena: Arena, actor: AbstractActor, state: State, *, key: Key
) -> tuple[Episodes, Pose]:
    """One episode of each agent (fields [N]), and its poses [T + 1, N]; at the end it stays."""
    problem: Problem = state.problem

    def step(now: Any, key: Key) -> tuple[Any, Pose]:
        state, before, ended, reached = now
        act_key, _ = jax.random.split(key)
        hidden, action = actor(arena, state, before, key=act_key)
        after, outcome = arena.advance(state, arena.motors(to_agents_last(action)))
        state = select(ended, state, after)
        hidden = jnp.where(ended[:, None], before, hidden)
        reached |= ~ended & outcome.terminated
        ended |= outcome.terminated | outcome.truncated
        return (state, hidden, ended, reached), state.pose

    nobody = jnp.zeros(arena.num_agents, bool)
    first = (state, actor.initial(arena.num_agents), nobody, nobody)
    keys = jax.random.split(key, len(problem.wander) + arena.rules.max_steps)
    (last, hidden, _, reached), poses = jax.lax.scan(step, first, keys)
    decisions = actor.decisions(last, hidden)
    return _summary(last, reached, decisions), jax.tree.map(
        lambda begin, rest: jnp.concatenate([begin[None], rest]), state.pose, poses
    )


def _summary(last: State, reached: Bool[Array, " N"], decisions: Int[Array, " N"]) -> Episodes:
    problem = last.problem
    return Episodes(
        reached,
        last.steps - problem.num_wander,
        decisions,
        last.walked,
        problem.distance,
        problem.around,
        last.seen.sum(axis=0).astype(jnp.int32),
    )
