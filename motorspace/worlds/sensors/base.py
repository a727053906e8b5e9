"""What a sense must answer."""

import abc
from typing import Any, ClassVar, Generic, TypeVar

import equinox as eqx
import numpy as np
from jaxtyping import Array, Float

from motorspace._errors import UserError
from motorspace._kinds import Registry
from motorspace._types import Key, Pose, Sensors
from motorspace.worlds.catalog import SENSORS
from motorspace.worlds.spaces import SensorSpace
from motorspace.worlds.world import AbstractWorld

World = TypeVar("World", bound=AbstractWorld)


class AbstractSensor(eqx.Module, Generic[World]):
    """What a sense must answer; its fields are its options."""

    registry: ClassVar[Registry[Any]] = SENSORS

    @abc.abstractmethod
    def space(self, world: AbstractWorld) -> SensorSpace:
        """The bounds and names of the readings in a world.

        Raises:
            UserError: For a world that this sensor cannot sense.
        """

    @abc.abstractmethod
    def sense(self, world: World, pose: Pose) -> Sensors:
        """The readings [K, *batch] at a pose or a batch of poses, raw units."""

    def perturbed(
        self, sensors: Float[Array, " K"], later: Float[Array, " K"], *, key: Key
    ) -> tuple[Float[Array, " K"], Float[Array, " K"]]:
        """What is read at the beginning and the end of a trajectory, if it differs by chance.

        Args:
            sensors: What `sense` gives at the beginning.
            later: What it gives at the end.
            key: Of this trajectory; unused by default.

        Returns:
            Both, raw units.
        """
        del key
        return sensors, later

    def rays(self, world: World, pose: Pose) -> Float[np.ndarray, "R 2 2"]:
        """Line segments that show in a picture what is sensed at one pose; none by default."""
        del world, pose
        return np.zeros((0, 2, 2))


def expect(
    sensor: AbstractSensor[Any], world: AbstractWorld, kind: type[World], *, remedy: str
) -> World:
    """The world, if it is of the kind that a sensor senses. Raises `UserError` otherwise."""
    if not isinstance(world, kind):
        raise UserError(
            f"a {type(sensor).__name__} cannot sense a {type(world).__name__}", remedy=remedy
        )
    return world
