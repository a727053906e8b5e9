"""Where an agent may be, held over its commands and what it has sensed after them."""

from typing import NamedTuple

import numpy as np
from jaxtyping import Float

from motorspace.judge.judge import Judge
from motorspace.judge.places import Hypotheses
from motorspace.se2 import compose


class Belief(NamedTuple):
    """Where an agent may be, and what its sensors were last commanded to.

    Args:
        places: Where the rays may begin.
        motor: The last command, [M]; zeros at rest.
    """

    places: Hypotheses
    motor: Float[np.ndarray, " M"]

    @property
    def likeliest(self) -> Float[np.ndarray, "3"]:
        """The likeliest place."""
        return self.places.eyes[:, int(np.argmax(self.places.weight))]


def first_belief(
    judge: Judge, sensors: Float[np.ndarray, " K"], motor: Float[np.ndarray, " M"]
) -> Belief:
    """Where an agent may be that senses this after a command [M]; zeros at rest."""
    return Belief(judge.where(sensors), np.asarray(motor, np.float64))


def updated(
    judge: Judge,
    belief: Belief,
    motors: Float[np.ndarray, "T M"],
    sensors: Float[np.ndarray, " K"],
) -> Belief:
    """The belief after commands and the readings that follow.

    Args:
        judge: Of the layout.
        belief: The belief before.
        motors: The commands as they happened, [T, M]: without the translation of one that a wall
            has forbidden.
        sensors: The readings after them, [K], raw units.

    Returns:
        Places that sense the readings, likelier the nearer odometry leads to them.
    """
    body = judge.calibration.body
    motors = np.asarray(motors, np.float64)
    begun = body.at_rest(belief.places.eyes, belief.motor)
    moved = np.repeat(body.moved(motors[:, None]), begun.shape[1], axis=1)
    expected = Hypotheses(np.asarray(compose(begun, moved)), belief.places.weight)
    return Belief(judge.places.tracked(sensors, expected), motors[-1])
