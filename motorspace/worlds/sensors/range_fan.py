"""Distances to the walls along a fan of rays."""

import math

import equinox as eqx
import jax.numpy as jnp
import numpy as np
from jaxtyping import Float

from motorspace._types import Pose, Sensors
from motorspace.worlds.checks import positive, whole
from motorspace.worlds.rays import cast, fan_directions, segments_of
from motorspace.worlds.sensors.base import AbstractSensor, expect
from motorspace.worlds.spaces import SensorSpace
from motorspace.worlds.world import AbstractWorld, WalledWorld


class RangeFan(AbstractSensor[WalledWorld]):
    """Distances to the nearest wall along rays spread evenly about the gaze, rightmost first.

    Both ends of the field of view have a ray; a single ray looks straight ahead. A ray that meets
    nothing reads `max_range`. With `sense_head` the head's angle (radians) is one more sensor.

    Example:
        >>> RangeFan(num_rays=3).angles
        array([-1.57079633,  0.        ,  1.57079633])

    Raises:
        UserError: For a number of rays below 1, a range that is not finite and above 0, and a
            field of view that is not above 0 and at most a full turn.
    """

    num_rays: int = eqx.field(static=True, default=9, metadata={"positive": True})
    """Distance sensors."""
    max_range: float = eqx.field(static=True, default=10.0, metadata={"positive": True})
    """Range of the distance sensors, world units."""
    field_of_view: float = eqx.field(
        static=True, default=math.pi, metadata={"in_pi": True, "positive": True}
    )
    """Field of view of the distance sensors."""
    sense_head: bool = eqx.field(static=True, default=False)
    """Whether the head's angle is one more sensor."""

    def __check_init__(self) -> None:
        whole("num_rays", self.num_rays)
        positive("max_range", self.max_range)
        positive("field_of_view", self.field_of_view, at_most=2 * math.pi, unit="radians")

    @property
    def angles(self) -> Float[np.ndarray, " R"]:
        """The direction of each ray relative to the gaze, radians."""
        half = self.field_of_view / 2 if self.num_rays > 1 else 0.0
        return np.linspace(-half, half, self.num_rays)

    def space(self, world: AbstractWorld) -> SensorSpace:
        expect(self, world, WalledWorld, remedy="choose a layout with walls, or node_index")
        ranges, head = (self.max_range,) * self.num_rays, self.sense_head
        names = tuple(f"range_{ray}" for ray in range(self.num_rays))
        return SensorSpace(
            low=(0.0,) * self.num_rays + (-math.pi,) * head,
            high=ranges + (math.pi,) * head,
            names=names + ("head",) * head,
            # An agent that sets its head turns it by a quarter at most.
            divisors=ranges + (math.pi / 2,) * head,
        )

    def sense(self, world: WalledWorld, pose: Pose) -> Sensors:
        rays = fan_directions(self.angles, pose.gaze)
        walls = world.walls_within(self.max_range)
        ranges = cast(walls, (pose.x, pose.y), rays, self.max_range)
        return jnp.concatenate([ranges, pose.head[None]]) if self.sense_head else ranges

    def rays(self, world: WalledWorld, pose: Pose) -> Float[np.ndarray, "R 2 2"]:
        ranges = np.asarray(self.sense(world, pose))[: self.num_rays]
        return segments_of(pose, self.angles, ranges)
