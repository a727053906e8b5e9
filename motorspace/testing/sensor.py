"""What any sensor must satisfy."""

from typing import Any

import jax
import jax.numpy as jnp
import numpy as np

from motorspace.testing.require import require, require_equal
from motorspace.worlds.catalog import SENSORS
from motorspace.worlds.scenario import WorldLike, world_of
from motorspace.worlds.sensors.base import AbstractSensor

NUM = 32


def check_sensor(sensor: AbstractSensor[Any], world: WorldLike = "paper") -> None:
    """Check a sensor: its options, its space, and what it senses.

    Args:
        sensor: An object of the class to check.
        world: A world that it can sense.

    Raises:
        AssertionError: Naming what is wrong.

    Example:
        >>> from motorspace.worlds.sensors.range_fan import RangeFan
        >>> check_sensor(RangeFan(num_rays=3), "empty")  # doctest: +SKIP
    """
    part = SENSORS.part_of(sensor)
    require_equal(
        SENSORS.build(part), sensor, "a sensor built from its own options differs from it"
    )
    place = world_of(world)
    space = sensor.space(place)
    poses = jax.vmap(lambda key: place.place(key=key), out_axes=-1)(
        jax.random.split(jax.random.key(0), NUM)
    )
    readings = np.asarray(sensor.sense(place, poses))
    require(
        readings.shape == (space.size, NUM),
        f"readings of {NUM} agents have the shape {readings.shape}, their space says "
        f"({space.size}, {NUM})",
    )
    require(bool(np.isfinite(readings).all()), "readings must be finite")
    low, high = (np.asarray(bound)[:, None] for bound in (space.low, space.high))
    inside = (readings >= low - 1e-4) & (readings <= high + 1e-4)
    channel = int(np.argmin(inside.all(axis=1)))
    require(bool(inside.all()), f"channel {space.names[channel]!r} leaves the bounds of its space")
    one = jax.tree.map(lambda field: field[3], poses)
    alone = np.asarray(sensor.sense(place, one))
    np.testing.assert_allclose(alone, readings[:, 3], atol=1e-4, err_msg="one and many differ")
    compiled = jax.jit(lambda pose: sensor.sense(place, pose))(poses)
    np.testing.assert_allclose(compiled, readings, atol=1e-4, err_msg="jit changes the readings")
    rays = sensor.rays(place, one)
    require(np.ndim(rays) == 3 and rays.shape[1:] == (2, 2), "`rays` must be segments [R, 2, 2]")
    require(bool(jnp.isfinite(jnp.asarray(rays)).all()), "`rays` must be finite")
