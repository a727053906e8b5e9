"""What a controller is asked to reach: a displacement, a code, or readings."""

import math
from collections.abc import Iterable
from dataclasses import dataclass
from typing import Literal, get_args

from motorspace._errors import UserError

Numbers = tuple[float, ...]

Method = Literal["amortised", "hybrid", "shooting", "cross_entropy", "descent"]
"""How a goal is planned for: decoded, decoded and refined, or searched for."""
METHODS: tuple[Method, ...] = get_args(Method)


@dataclass(frozen=True)
class DisplacementGoal:
    """Move to a place and a direction given in the frame of the sensors now.

    Attributes:
        longitudinal: How far ahead, world units.
        lateral: How far to the left, world units.
        turn: How far to turn to the left, radians; full turns make no difference.

    Raises:
        UserError: For a number that is not finite.

    Example:
        >>> DisplacementGoal(1.0, 0.5, math.pi / 2).turn
        1.5707963267948966
    """

    longitudinal: float
    lateral: float
    turn: float = 0.0

    def __post_init__(self) -> None:
        _check_finite("displacement", (self.longitudinal, self.lateral, self.turn))


@dataclass(frozen=True)
class CodeGoal:
    """Carry out some motor sequence with this code.

    Attributes:
        code: The code h^m, [C].

    Raises:
        UserError: For a number that is not finite.
    """

    code: Numbers

    def __init__(self, code: Iterable[float]) -> None:
        object.__setattr__(self, "code", _check_finite("code", code))


@dataclass(frozen=True)
class SensorGoal:
    """Sense these readings.

    Attributes:
        sensors: The readings [K], raw units.

    Raises:
        UserError: For a number that is not finite.
    """

    sensors: Numbers

    def __init__(self, sensors: Iterable[float]) -> None:
        object.__setattr__(self, "sensors", _check_finite("sensors", sensors))


Goal = DisplacementGoal | CodeGoal | SensorGoal


def _check_finite(what: str, values: Iterable[float]) -> Numbers:
    numbers = tuple(float(value) for value in values)
    if not all(map(math.isfinite, numbers)):
        raise UserError(f"a goal must be finite, and this {what} holds {numbers}")
    return numbers
