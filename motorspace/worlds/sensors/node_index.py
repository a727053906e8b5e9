"""Where an agent is on the lattice, and which way it faces."""

import jax
import jax.numpy as jnp

from motorspace._types import Pose, Sensors
from motorspace.worlds.sensors.base import AbstractSensor, expect
from motorspace.worlds.spaces import SensorSpace
from motorspace.worlds.world import AbstractWorld, LatticeWorld


class NodeIndex(AbstractSensor[LatticeWorld]):
    """One-hot index of the node, then one-hot absolute orientation."""

    def space(self, world: AbstractWorld) -> SensorSpace:
        grid = expect(self, world, LatticeWorld, remedy="choose a layout such as lattice:6")
        nodes = [f"node_{x}_{y}" for y in range(grid.height) for x in range(grid.width)]
        names = (*nodes, "east", "north", "west", "south")
        return SensorSpace((0.0,) * len(names), (1.0,) * len(names), names)

    def sense(self, world: LatticeWorld, pose: Pose) -> Sensors:
        node = jnp.round(pose.y * world.width + pose.x).astype(jnp.int32)
        quarter = jnp.mod(jnp.round(pose.gaze * 2 / jnp.pi).astype(jnp.int32), 4)
        return jnp.concatenate(
            [
                jax.nn.one_hot(node, world.num_nodes, axis=0, dtype=jnp.float32),
                jax.nn.one_hot(quarter, 4, axis=0, dtype=jnp.float32),
            ]
        )
