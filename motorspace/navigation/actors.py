"""Who acts: a learned policy, chance, or one who knows the map and where it is."""

import abc

import equinox as eqx
import jax
import jax.numpy as jnp
from jaxtyping import Array, Float, Int

from motorspace._types import Key, Pose
from motorspace.navigation.arena import Arena, State
from motorspace.navigation.coded import CodeCommands
from motorspace.navigation.planner import next_stop
from motorspace.navigation.policies import Hiddens, Policy
from motorspace.se2 import wrap
from motorspace.worlds.simulation import to_rows
from motorspace.worlds.walls import Point

Actions = Float[Array, "N A"]
"""A command of each agent, as a share of its range: [-1, 1]."""

CANDIDATES = 128
"""Commands among which one who knows the map chooses."""

LOOKING = 0.5
"""World units that a radian of facing away from where it heads is worth to it."""


class AbstractActor(eqx.Module):
    """What chooses the commands of N agents."""

    def initial(self, num_agents: int) -> Hiddens:
        """What is remembered before the first command; nothing by default."""
        return jnp.zeros((num_agents, 0), jnp.float32)

    @abc.abstractmethod
    def __call__(
        self, arena: Arena, state: State, hidden: Hiddens, *, key: Key
    ) -> tuple[Hiddens, Actions]:
        """What is remembered from here on, and the commands."""

    def decisions(self, state: State, hidden: Hiddens) -> Int[Array, " N"]:
        """How often each agent has decided since it acts itself; by default at every command."""
        del hidden
        return state.steps - state.problem.num_wander


class Learned(AbstractActor):
    """A policy: the middle of its distribution of commands, or commands sampled from it."""

    policy: Policy
    sampled: bool = eqx.field(static=True, default=False)

    def initial(self, num_agents: int) -> Hiddens:
        return self.policy.initial(num_agents)

    def __call__(
        self, arena: Arena, state: State, hidden: Hiddens, *, key: Key
    ) -> tuple[Hiddens, Actions]:
        answer = jax.vmap(self.policy)(hidden, arena.observed(state))
        action = self.policy.sampled(answer.mean, key=key) if self.sampled else answer.mean
        return answer.hidden, action


class LearnedInCodes(AbstractActor):
    """A policy whose actions are codes: it decides when the commands of the last one are over.

    It remembers what the policy does, the commands of the code as actions, how many of them it
    has carried out, and how often it has decided.
    """

    policy: Policy
    code_commands: CodeCommands
    sampled: bool = eqx.field(static=True, default=False)

    def initial(self, num_agents: int) -> Hiddens:
        horizon = self.code_commands.horizon
        size = self.policy.memory_size + horizon * self.code_commands.commands.size
        nothing = jnp.zeros((num_agents, size + 2), jnp.float32)
        return nothing.at[:, -2].set(float(horizon))

    def __call__(
        self, arena: Arena, state: State, hidden: Hiddens, *, key: Key
    ) -> tuple[Hiddens, Actions]:
        horizon, commands = self.code_commands.horizon, self.code_commands.commands
        own, at = state.steps - state.problem.num_wander, hidden[:, -2]
        decides = (at >= horizon) | (own == 0) | (state.bumped & (own > 0))
        answer = jax.vmap(self.policy)(hidden[:, : self.policy.memory_size], arena.observed(state))
        code = self.policy.sampled(answer.mean, key=key) if self.sampled else answer.mean
        motors = jax.vmap(self.code_commands)(code)
        shares = jnp.moveaxis(commands.shares(jnp.moveaxis(motors, -1, 0)), 0, -1)
        made = (2 * shares - 1).reshape(len(motors), -1)
        counted = (hidden[:, -1] + (own >= 0).astype(jnp.float32))[:, None]
        first = jnp.concatenate([answer.hidden, made, jnp.zeros_like(counted), counted], axis=1)
        hidden = jnp.where(decides[:, None], first, hidden)
        plan = hidden[:, self.policy.memory_size : -2].reshape(len(motors), horizon, -1)
        number = hidden[:, -2].astype(jnp.int32)[:, None, None]
        action = jnp.take_along_axis(plan, number, axis=1)[:, 0]
        return hidden.at[:, -2].add(1.0), action

    def decisions(self, state: State, hidden: Hiddens) -> Int[Array, " N"]:
        return hidden[:, -1].astype(jnp.int32)


class Chance(AbstractActor):
    """Uniformly random commands."""

    def __call__(
        self, arena: Arena, state: State, hidden: Hiddens, *, key: Key
    ) -> tuple[Hiddens, Actions]:
        return hidden, _random(key, (arena.num_agents, arena.action_size))


class Planner(AbstractActor):
    """The upper row: of many random commands the one that leads best along the shortest way."""

    def __call__(
        self, arena: Arena, state: State, hidden: Hiddens, *, key: Key
    ) -> tuple[Hiddens, Actions]:
        goal = state.problem.goal.x, state.problem.goal.y
        place = state.pose.x, state.pose.y
        stop = next_stop(
            arena.setting.walls, arena.setting.corners, state.problem.to_goal, goal, place
        )
        return hidden, best_command(arena, state, stop, key=key)


def best_command(arena: Arena, state: State, stop: Point, *, key: Key) -> Actions:
    """Of many random commands of each agent the one that leads best towards a place."""

    def cost(action: Float[Array, "A N"]) -> Float[Array, " N"]:
        after: Pose = arena.scenario.step(state.pose, arena.motors(action))[0]
        dx, dy = stop[0] - after.x, stop[1] - after.y
        facing = wrap(jnp.arctan2(dy, dx) - after.heading)
        return jnp.hypot(dx, dy) + LOOKING * jnp.abs(facing)

    tried = _random(key, (CANDIDATES, arena.action_size, arena.num_agents))
    best = jnp.argmin(jax.lax.map(cost, tried), axis=0)
    return to_rows(jnp.take_along_axis(tried, best[None, None], axis=0)[0])


def _random(key: Key, shape: tuple[int, ...]) -> Float[Array, "..."]:
    return jax.random.uniform(key, shape, jnp.float32, -1.0, 1.0)
