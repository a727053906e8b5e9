"""What a table says of itself beside its columns: a comment of a text, a key of a Parquet file.

The comment is `# motorspace: {"planar": true, "sensor_scale": [10.0, 10.0], "judged": true}`.
"""

import json
import math
from collections.abc import Iterable
from dataclasses import dataclass, fields
from typing import Any

from motorspace._errors import UserError

KEY = "motorspace"
PREFIX = f"# {KEY}:"
LONGEST = 1_000_000
"""Signs of the longest description that is read."""
FLAGS = ("planar", "judged", "odometry_poses")


@dataclass(frozen=True)
class About:
    """What the columns of a table alone do not say."""

    planar: bool = False
    """Whether the motors are increments (longitudinal, lateral, rotation)."""
    sensor_scale: tuple[float, ...] | None = None
    """Largest magnitude of each sensor; None stands for the largest in its column."""
    judged: bool = False
    """Whether what is no transition is left out already."""
    odometry_poses: bool = False
    """Whether the poses are where odometry leads."""
    shape: tuple[int, ...] | None = None
    """How the sensors are arranged, for instance (height, width, 3); None stands for a list."""

    def text(self) -> str:
        """The description as JSON; `read_about` gives it back."""
        return json.dumps({name: value for name, value in vars(self).items() if value is not None})

    def check(self, motors: int, sensors: int, *, where: object) -> None:
        """Raise `UserError` unless it fits so many columns."""
        scales = sensors if self.sensor_scale is None else len(self.sensor_scale)
        arranged = sensors if self.shape is None else math.prod(self.shape)
        if (self.planar and motors != 3) or scales != sensors or arranged != sensors:
            raise _wrong(f"it does not fit {motors} motor and {sensors} sensor columns", where)


def about_in(lines: Iterable[str], *, where: object) -> About:
    """The description in the comments at the head of a text table."""
    for line in lines:
        if not line.startswith("#"):
            break
        if line.startswith(PREFIX):
            return read_about(line.removeprefix(PREFIX), where=where)
    return About()


def read_about(text: str, *, where: object) -> About:
    """The description that `About.text` wrote. Raises `UserError` for another one."""
    try:
        found = json.loads(text) if len(text) <= LONGEST else None
    except (ValueError, RecursionError):
        found = None
    if not isinstance(found, dict):
        raise _wrong("it is no JSON object", where)
    if unknown := found.keys() - {field.name for field in fields(About)}:
        raise _wrong(f"it names {', '.join(sorted(unknown))}", where)
    for name in FLAGS:
        if not isinstance(found.get(name, False), bool):
            raise _wrong(f"{name} is true or false", where)
    scales, shape = _scales(found.get("sensor_scale"), where), _shape(found.get("shape"), where)
    return About(**found | {"sensor_scale": scales, "shape": shape})


def _scales(value: Any, where: object) -> tuple[float, ...] | None:
    if value is None:
        return None
    if not isinstance(value, list) or not all(map(_is_scale, value)):
        raise _wrong("sensor_scale is a list of numbers above 0", where)
    return tuple(map(float, value))


def _shape(value: Any, where: object) -> tuple[int, ...] | None:
    if value is None:
        return None
    if not isinstance(value, list) or not value or not all(map(_is_size, value)):
        raise _wrong("shape is a list of whole numbers above 0", where)
    return tuple(value)


def _is_size(value: Any) -> bool:
    return isinstance(value, int) and not isinstance(value, bool) and value > 0


def _is_scale(value: Any) -> bool:
    number = isinstance(value, int | float) and not isinstance(value, bool)
    return number and 0 < value < math.inf


def _wrong(why: str, where: object) -> UserError:
    return UserError(
        f"the line that begins with {PREFIX!r} cannot be read ({why})",
        where=where,
        remedy="correct it or leave it out",
    )
