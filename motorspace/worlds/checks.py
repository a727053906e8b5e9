"""Numbers that a person gave, checked: each failure is one `UserError` that names the option."""

import math
from numbers import Integral, Real
from typing import Any

from motorspace._errors import UserError


def whole(name: str, value: Any, *, at_least: int = 1) -> int:
    """The value as an `int`. Raises `UserError` unless it is a whole number, not too small.

    >>> whole("horizon", 6)
    6
    """
    if not isinstance(value, Integral) or isinstance(value, bool):
        raise UserError(f"{name} must be a whole number, got {value!r}")
    if value < at_least:
        raise UserError(f"{name} must be at least {at_least}, got {value}")
    return int(value)


def positive(name: str, value: Any, *, at_most: float = math.inf, unit: str = "") -> float:
    """The value as a `float`. Raises `UserError` unless it is a finite number above 0.

    >>> positive("max_range", 10)
    10.0
    """
    if not isinstance(value, Real) or isinstance(value, bool):
        raise UserError(f"{name} must be a number, got {value!r}")
    value = float(value)
    if not 0 < value < math.inf or value > at_most:
        limit = f"above 0 and at most {at_most:g}" if at_most < math.inf else "above 0 and finite"
        raise UserError(f"{name} must be {limit}{unit and ' ' + unit}, got {value:g}")
    return value


def within(name: str, value: Any, least: float, most: float) -> float:
    """The value as a `float`. Raises `UserError` unless it is finite and from `least` to `most`.

    >>> within("curriculum", 0, 0.0, 1.0)
    0.0
    """
    if not isinstance(value, Real) or isinstance(value, bool):
        raise UserError(f"{name} must be a number, got {value!r}")
    value = float(value)
    if not (math.isfinite(value) and least <= value <= most):
        limit = (
            f"from {least:g} to {most:g}" if most < math.inf else f"at least {least:g} and finite"
        )
        raise UserError(f"{name} must be {limit}, got {value:g}")
    return value


def flag(name: str, value: Any) -> bool:
    """The value. Raises `UserError` unless it is true or false."""
    if not isinstance(value, bool):
        raise UserError(f"{name} must be true or false, got {value!r}")
    return value


def one_of(name: str, value: Any, choices: tuple[str, ...]) -> str:
    """The value. Raises `UserError` unless it is one of the choices."""
    if value not in choices:
        raise UserError(f"{name} must be {' or '.join(map(repr, choices))}, got {value!r}")
    return str(value)
