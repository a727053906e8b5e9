"""Senses: what an agent perceives from a pose in a world."""

import abc
import math
from typing import Generic, TypeVar

import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np

from motorspace._types import Pose, Scalar, Sensors
from motorspace.worlds.geometry import Batch, cast, cos_sin
from motorspace.worlds.world import AbstractWorld, LatticeWorld, WalledWorld

World = TypeVar("World", bound=AbstractWorld)


class AbstractSensor(eqx.Module, Generic[World]):
    """What a sense must answer."""

    @abc.abstractmethod
    def scale(self, world: World) -> tuple[float, ...]:
        """The largest magnitude of each sensor channel; its length is the sensor size."""

    @abc.abstractmethod
    def sense(self, world: World, pose: Pose) -> Sensors:
        """The sensors' values at a pose or a batch of poses, raw units."""


class RangeFan(AbstractSensor[WalledWorld]):
    """Distances to the nearest wall along rays spread evenly about the gaze.

    `field_of_view` in radians, both ends included, rightmost ray first; `max_range` in world
    units is also what a ray reads that meets nothing. With `sense_head` the head's angle
    (radians) is one more sensor.
    """

    num_rays: int = eqx.field(static=True, default=9)
    max_range: float = eqx.field(static=True, default=10.0)
    field_of_view: float = eqx.field(static=True, default=math.pi)
    sense_head: bool = eqx.field(static=True, default=False)

    def scale(self, world: WalledWorld) -> tuple[float, ...]:
        del world
        return (self.max_range,) * self.num_rays + (math.pi / 2,) * self.sense_head

    def sense(self, world: WalledWorld, pose: Pose) -> Sensors:
        half = self.field_of_view / 2
        fan = np.linspace(-half, half, self.num_rays)
        cos, sin = cos_sin(pose.gaze)

        def turned(ray: tuple[Scalar, Scalar]) -> tuple[Batch, Batch]:
            """One ray of the fan, turned to the gaze, so that only the gaze needs a sine."""
            ray_cos, ray_sin = ray
            return ray_cos * cos - ray_sin * sin, ray_sin * cos + ray_cos * sin

        # A loop, since in one expression the compiler takes the gaze's sine for every ray.
        rays = jax.lax.map(turned, (jnp.asarray(np.cos(fan)), jnp.asarray(np.sin(fan))))
        walls = world.walls_within(self.max_range)
        ranges = cast(walls, (pose.x, pose.y), rays, self.max_range)
        return jnp.concatenate([ranges, pose.head[None]]) if self.sense_head else ranges


class NodeIndex(AbstractSensor[LatticeWorld]):
    """One-hot index of the node, then one-hot absolute orientation."""

    def scale(self, world: LatticeWorld) -> tuple[float, ...]:
        return (1.0,) * (world.num_nodes + 4)

    def sense(self, world: LatticeWorld, pose: Pose) -> Sensors:
        node = jnp.round(pose.y * world.width + pose.x).astype(int)
        quarter = jnp.mod(jnp.round(pose.gaze * 2 / jnp.pi).astype(int), 4)
        return jnp.concatenate(
            [jax.nn.one_hot(node, world.num_nodes, axis=0), jax.nn.one_hot(quarter, 4, axis=0)]
        )
