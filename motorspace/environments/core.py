"""What single and vector environments share: the spaces and the compiled rules."""

import math
from collections.abc import Callable
from functools import cached_property
from typing import Any, Literal, NamedTuple

import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np
from gymnasium import spaces
from jaxtyping import Array, Float, Shaped

from motorspace._errors import UserError
from motorspace._types import Flags, Key, Keys, Motor, Pose
from motorspace.worlds.agents import AbstractAgent, ForwardAgent, HolonomicAgent, LatticeAgent
from motorspace.worlds.layouts import layout
from motorspace.worlds.sensors.base import AbstractSensor
from motorspace.worlds.sensors.node_index import NodeIndex
from motorspace.worlds.sensors.range_fan import RangeFan
from motorspace.worlds.simulation import step
from motorspace.worlds.world import AbstractWorld, LatticeWorld

AgentName = Literal["lattice", "forward", "holonomic"]

Action = Shaped[Array | np.ndarray, "*batch_action"]
"""Gymnasium's actions: agents first, then the channels of a command, if it has any."""

Outcome = Float[Array, "*batch O"]
"""Pose (x, y, heading, head), whether a wall was in the way, sensors: one row per agent, since
every array that enters or leaves the compiled step costs microseconds."""

Rows = Float[np.ndarray, "*batch K"]


class Setting(eqx.Module):
    """A world, an agent and a sensor, with the conversions between Gymnasium and commands."""

    world: AbstractWorld
    agent: AbstractAgent
    sensor: AbstractSensor[Any]

    @cached_property
    def action_space(self) -> spaces.Space[Any]:
        """Six commands on the lattice, else every motor channel in [-1, 1]."""
        size = len(self.agent.commands.scale)
        if isinstance(self.agent, LatticeAgent):
            return spaces.Discrete(size)
        return spaces.Box(-1.0, 1.0, (size,), np.float32)

    @cached_property
    def observation_space(self) -> spaces.Box:
        """The sensors in raw units."""
        scale = np.asarray(self.sensor.space(self.world).scale, np.float32)
        return spaces.Box(np.zeros_like(scale), scale, dtype=np.float32)

    def motor(self, action: Action) -> Motor:
        """The motor command behind an action; the forward agent's move fills [0, 1]."""
        if isinstance(self.agent, LatticeAgent):
            return jax.nn.one_hot(action, len(self.agent.commands.scale), axis=0)
        command = jnp.clip(action.T, -1.0, 1.0)
        if isinstance(self.agent, ForwardAgent):
            command = command.at[1].set((command[1] + 1.0) / 2.0)
        return (command.T * jnp.array(self.agent.commands.scale)).T

    def begin(self, key: Key) -> Outcome:
        """A random free pose and what is sensed there."""
        place_key, head_key = jax.random.split(key)
        pose = self.agent.start(self.world.place(key=place_key), key=head_key)
        return self._outcome(pose, jnp.zeros(pose.x.shape, bool))

    def advance(self, before: Outcome, action: Action) -> Outcome:
        """What comes of an action after what came of the one before, for one agent or a batch."""
        pose = Pose(*jnp.moveaxis(before, -1, 0)[:4])
        after, blocked = step(self.world, self.agent, pose, self.motor(action))
        return self._outcome(after, blocked)

    def _outcome(self, pose: Pose, blocked: Flags) -> Outcome:
        facts = jnp.stack([pose.x, pose.y, pose.heading, pose.head, blocked.astype(float)])
        return jnp.concatenate([facts, self.sensor.sense(self.world, pose)]).T

    @staticmethod
    def told(outcome: Outcome) -> tuple[Rows, dict[str, Any]]:
        """Observation and info in an outcome, as NumPy arrays of their own."""
        row = np.array(outcome, np.float32)
        return row[..., 5:], {"pose": row[..., :4], "blocked": row[..., 4] > 0}


class Rules(NamedTuple):
    """A setting's rules, compiled."""

    begin: Callable[[Key], Outcome]
    begin_all: Callable[[Keys], Outcome]
    advance: Callable[[Outcome, Action], Outcome]


def compiled(setting: Setting) -> Rules:
    """The rules with the setting as a constant: as an argument it costs twice a single step."""
    return Rules(
        jax.jit(lambda key: setting.begin(key)),
        jax.jit(lambda keys: jax.vmap(setting.begin)(keys)),
        jax.jit(lambda before, action: setting.advance(before, action)),
    )


def build_setting(
    agent: AgentName,
    *,
    layout_name: str = "paper",
    max_rotation: float = 0.8,
    lattice_size: int = 6,
) -> Setting:
    """The setting of a registered environment; `max_rotation` in units of pi."""
    if not max_rotation > 0:
        raise UserError(
            f"the largest rotation must be above 0, not {max_rotation}",
            remedy="give it in units of pi",
        )
    if agent == "lattice":
        if lattice_size < 1:
            raise UserError(f"a lattice of {lattice_size} nodes has no place to stand")
        return Setting(LatticeWorld(lattice_size, lattice_size), LatticeAgent(), NodeIndex())
    body: AbstractAgent = (
        ForwardAgent(max_rotation * math.pi)
        if agent == "forward"
        else HolonomicAgent(max_rotation * math.pi)
    )
    return Setting(layout(layout_name), body, RangeFan())


def jax_key(random: np.random.Generator) -> Key:
    """A JAX key from Gymnasium's own generator."""
    return jax.random.key(int(random.integers(2**31)))
