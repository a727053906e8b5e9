"""Who acts: a learned policy, chance, or one who knows the map and where it is."""

import abc

import equinox as eqx
import jax
import jax.numpy as jnp
from jaxtyping import Array, Float

from motorspace._types import Key, Pose
from motorspace.navigation.arena import Arena, State
from motorspace.navigation.planner import next_stop
from motorspace.navigation.policies import Hiddens, Policy
from motorspace.se2 import wrap
from motorspace.worlds.simulation import to_rows

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

        def cost(action: Float[Array, "A N"]) -> Float[Array, " N"]:
            after: Pose = arena.scenario.step(state.pose, arena.motors(action))[0]
            dx, dy = stop[0] - after.x, stop[1] - after.y
            facing = wrap(jnp.arctan2(dy, dx) - after.heading)
            return jnp.hypot(dx, dy) + LOOKING * jnp.abs(facing)

        tried = _random(key, (CANDIDATES, arena.action_size, arena.num_agents))
        best = jnp.argmin(jax.lax.map(cost, tried), axis=0)
        chosen = jnp.take_along_axis(tried, best[None, None], axis=0)[0]
        return hidden, to_rows(chosen)


def _random(key: Key, shape: tuple[int, ...]) -> Float[Array, "..."]:
    return jax.random.uniform(key, shape, jnp.float32, -1.0, 1.0)
