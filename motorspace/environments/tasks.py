"""What an agent is rewarded for, and when an episode has reached its end."""

import abc
from typing import NamedTuple

import equinox as eqx
import jax.numpy as jnp
from jaxtyping import Array, Float

from motorspace._types import Flags, Pose, Sensors


class Transition(NamedTuple):
    """What came of one command, for one agent or a batch (agents in the last axis)."""

    before: Pose
    after: Pose
    blocked: Flags
    """Whether a wall took the translation away."""
    sensors: Sensors
    """What is sensed after the command."""


class AbstractTask(eqx.Module):
    """What a task must answer; both answers are part of the compiled step."""

    @abc.abstractmethod
    def reward(self, transition: Transition) -> Float[Array, "*batch"]:
        """The reward of each agent."""

    @abc.abstractmethod
    def terminated(self, transition: Transition) -> Flags:
        """Whether each agent's episode has reached its end."""


class Explore(AbstractTask):
    """No task: the reward is 0, and no episode ever reaches an end."""

    def reward(self, transition: Transition) -> Float[Array, "*batch"]:
        return jnp.zeros_like(transition.after.x)

    def terminated(self, transition: Transition) -> Flags:
        return jnp.zeros_like(transition.blocked)
