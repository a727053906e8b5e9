"""The colours of the walls along a fan of rays: an eye in the plane."""

import math
from typing import Literal, get_args

import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Float

from motorspace._errors import UserError
from motorspace._types import Key, Pose, Sensors
from motorspace.worlds.checks import one_of, positive, whole
from motorspace.worlds.rays import FARTHEST, Met, fan_directions, first_met, segments_of
from motorspace.worlds.sensors.base import AbstractSensor, expect
from motorspace.worlds.spaces import SensorSpace
from motorspace.worlds.world import AbstractWorld, WalledWorld

Light = Literal["constant", "trajectory", "view"]

DIMMEST = 0.4
"""The least of the light that a random factor leaves."""


class Retina(AbstractSensor[WalledWorld]):
    """What colour the walls have, seen by pixels that share out the field of view, rightmost first.

    A pixel averages the colours that `samples` rays meet, evenly spread over it. Nothing tells how
    far away the walls are: no shading, no limit of sight. Readings are red, green and blue of each
    pixel, from -1 (black) to 1 (full light).

    Args:
        num_rays: Pixels.
        field_of_view: All they see, radians.
        samples: Rays of each pixel.
        light: What colours are multiplied by before they are read: 1, or a random factor from 0.4
            to 1, the same before and after a trajectory or one for each view. Agents in
            environments see in constant light.

    Example:
        >>> Retina(num_rays=2, samples=1).angles
        array([-0.78539816,  0.78539816])

    Raises:
        UserError: For numbers below 1, a field of view that is not above 0 and at most a full
            turn, and a light that does not exist.
    """

    num_rays: int = eqx.field(static=True, default=32, metadata={"positive": True})
    """Pixels of the retina."""
    field_of_view: float = eqx.field(
        static=True, default=math.pi, metadata={"in_pi": True, "positive": True}
    )
    """Field of view of the retina."""
    samples: int = eqx.field(static=True, default=4, metadata={"positive": True})
    """Rays whose colours a pixel averages."""
    light: Light = eqx.field(static=True, default="constant")
    """The light: constant, or a random factor for each trajectory or each view."""

    def __check_init__(self) -> None:
        whole("num_rays", self.num_rays)
        whole("samples", self.samples)
        positive("field_of_view", self.field_of_view, at_most=2 * math.pi, unit="radians")
        one_of("light", self.light, get_args(Light))

    @property
    def angles(self) -> Float[np.ndarray, " R"]:
        """The direction of each pixel's middle relative to the gaze, radians."""
        return self._spread(self.num_rays)

    def _spread(self, num: int) -> Float[np.ndarray, " R"]:
        """The middles of `num` equal parts of the field of view."""
        return ((np.arange(num) + 0.5) / num - 0.5) * self.field_of_view

    def space(self, world: AbstractWorld) -> SensorSpace:
        walled = expect(
            self, world, WalledWorld, remedy="choose a layout with walls, or node_index"
        )
        if walled.coat is None:
            raise UserError(
                "a Retina cannot see walls without paint",
                remedy="make the world of a layout, whose walls have some: layout('paper')",
            )
        names = tuple(f"{hue}_{ray}" for ray in range(self.num_rays) for hue in ("r", "g", "b"))
        size = len(names)
        return SensorSpace((-1.0,) * size, (1.0,) * size, names, shape=(self.num_rays, 3))

    def sense(self, world: WalledWorld, pose: Pose) -> Sensors:
        coat = world.coat
        assert coat is not None, "space() has made sure"
        rays = fan_directions(self._spread(self.num_rays * self.samples), pose.gaze)
        met = first_met(world.walls, world.tiles, (pose.x, pose.y), rays)
        ranges, wall = _ranges(met), jnp.maximum(met.wall, 0.0).astype(jnp.int32)
        x, y = pose.x[None] + rays[0] * ranges, pose.y[None] + rays[1] * ranges

        def one_more(
            light: Float[Array, "R 3 *batch"], place: tuple[Array, Array, Array]
        ) -> tuple[Float[Array, "R 3 *batch"], None]:
            """One ray of every pixel at a time: the colours of all would fill the cache."""
            return light + coat.colours(*place), None

        nothing = jnp.zeros((self.num_rays, 3, *pose.x.shape), jnp.float32)
        light, _ = jax.lax.scan(one_more, nothing, jax.tree.map(self._by_sample, (wall, x, y)))
        return light.reshape(-1, *pose.x.shape) * (2 / self.samples) - 1

    def _by_sample(self, rays: Array) -> Array:
        """[samples, pixels, ...] of all rays [pixels x samples, ...]."""
        return rays.reshape(self.num_rays, self.samples, *rays.shape[1:]).swapaxes(0, 1)

    def perturbed(
        self, sensors: Float[Array, " K"], later: Float[Array, " K"], *, key: Key
    ) -> tuple[Float[Array, " K"], Float[Array, " K"]]:
        if self.light == "constant":
            return sensors, later
        now, then = jax.random.uniform(key, (2,), jnp.float32, minval=DIMMEST)
        return _lit(sensors, now), _lit(later, now if self.light == "trajectory" else then)

    def rays(self, world: WalledWorld, pose: Pose) -> Float[np.ndarray, "R 2 2"]:
        rays = fan_directions(self.angles, pose.gaze)
        met = first_met(world.walls, world.tiles, (pose.x, pose.y), rays)
        return segments_of(pose, self.angles, np.asarray(_ranges(met)))


def _ranges(met: Met) -> Float[Array, "K *batch"]:
    return 1 / jnp.maximum(met.nearness, 1 / FARTHEST)


def _lit(sensors: Float[Array, " K"], light: Float[Array, ""]) -> Float[Array, " K"]:
    return (sensors + 1) * light - 1
