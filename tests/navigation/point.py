"""A task that every learner solves: a point on a plane must reach the middle."""

from typing import NamedTuple

import equinox as eqx
import jax
import jax.numpy as jnp

from motorspace.navigation.interface import Step

STEP, NEAR, LONGEST = 0.2, 0.15, 20


class Point(NamedTuple):
    place: jax.Array
    steps: jax.Array


class ToTheMiddle(eqx.Module):
    """A point on a plane that must reach the middle; it is cut off after 20 steps."""

    num_agents: int = eqx.field(static=True, default=64)
    action_size: int = eqx.field(static=True, default=2)
    commands_per_action: int = eqx.field(static=True, default=1)

    def begin(self, *, key):
        shape = (self.num_agents, 2)
        return Point(
            jax.random.uniform(key, shape, jnp.float32, -1.0, 1.0),
            jnp.zeros(self.num_agents, jnp.int32),
        )

    def observed(self, state):
        return state.place

    def step(self, state, action, *, key):
        place = state.place + STEP * jnp.clip(action, -1.0, 1.0)
        steps = state.steps + 1
        away = jnp.linalg.norm(place, axis=-1)
        terminated = away < NEAR
        truncated = ~terminated & (steps >= LONGEST)
        fresh, ended = self.begin(key=key), terminated | truncated
        then = Point(
            jnp.where(ended[:, None], fresh.place, place), jnp.where(ended, fresh.steps, steps)
        )
        acted = jnp.ones_like(ended)
        return then, Step(place, then.place, -away, terminated, truncated, acted)
