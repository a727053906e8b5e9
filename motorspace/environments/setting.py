"""What single and vector environments share: the spaces and the compiled rules."""

import math
from functools import cached_property
from typing import Any, Literal

import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np
from gymnasium import spaces
from jaxtyping import Array, Float

from motorspace._errors import UserError
from motorspace._types import Flag, Key, Keys, Motor, Pose, Sensors
from motorspace.worlds import (
    AbstractAgent,
    AbstractSensor,
    AbstractWorld,
    ForwardAgent,
    HolonomicAgent,
    LatticeAgent,
    LatticeWorld,
    NodeIndex,
    RangeFan,
    layout,
    step,
)

AgentName = Literal["lattice", "forward", "holonomic"]


class Setting(eqx.Module):
    """A world, an agent and a sensor, with the conversions between Gymnasium and commands."""

    world: AbstractWorld
    agent: AbstractAgent
    sensor: AbstractSensor[Any]

    @cached_property
    def action_space(self) -> spaces.Space[Any]:
        """Six commands on the lattice, else every motor channel in [-1, 1]."""
        size = len(self.agent.motor_scale)
        if isinstance(self.agent, LatticeAgent):
            return spaces.Discrete(size)
        return spaces.Box(-1.0, 1.0, (size,), np.float32)

    @cached_property
    def observation_space(self) -> spaces.Box:
        """The sensors in raw units."""
        scale = np.asarray(self.sensor.scale(self.world), np.float32)
        return spaces.Box(np.zeros_like(scale), scale, dtype=np.float32)

    def motor(self, action: Array) -> Motor:
        """The motor command behind an action; the forward agent's move fills [0, 1]."""
        if isinstance(self.agent, LatticeAgent):
            return jax.nn.one_hot(action, len(self.agent.motor_scale))
        command = jnp.clip(action, -1.0, 1.0) * jnp.array(self.agent.motor_scale)
        if isinstance(self.agent, ForwardAgent):
            return command.at[1].set((command[1] + 1.0) / 2.0)
        return command

    def begin(self, key: Key) -> tuple[Pose, Sensors]:
        """A random free pose and what is sensed there."""
        place_key, head_key = jax.random.split(key)
        pose = self.agent.start(self.world.place(key=place_key), key=head_key)
        return pose, self.sensor.sense(self.world, pose)

    def advance(self, pose: Pose, action: Array) -> tuple[Pose, Sensors, Flag]:
        """The pose after an action, what is sensed there, and whether a wall was in the way."""
        after, blocked = step(self.world, self.agent, pose, self.motor(action))
        return after, self.sensor.sense(self.world, after), blocked


@eqx.filter_jit
def begin_all(setting: Setting, keys: Keys) -> tuple[Pose, Float[Array, "N K"]]:
    """`Setting.begin` for every key."""
    return jax.vmap(setting.begin)(keys)


@eqx.filter_jit
def advance_all(
    setting: Setting, poses: Pose, actions: Array
) -> tuple[Pose, Float[Array, "N K"], Array]:
    """`Setting.advance` for every pose."""
    return jax.vmap(setting.advance)(poses, actions)


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


def pose_row(pose: Pose) -> Float[np.ndarray, "... 4"]:
    """(x, y, heading, head) as float32."""
    fields = (pose.x, pose.y, pose.heading, pose.head)
    return np.stack([np.asarray(f, np.float32) for f in fields], axis=-1)


def jax_key(random: np.random.Generator) -> Key:
    """A JAX key from Gymnasium's own generator."""
    return jax.random.key(int(random.integers(2**31)))
