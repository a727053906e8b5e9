"""The file of a robot's calibration: JSON, checked as a whole before anything heavy is loaded.

```
format_version   1
rig              frame: from the codes' twists to those of the rays' origin
                 per_scan: whether the commands between two scans count as one
odometry         step, gaze, step_twist, gaze_twist, has_gaze: from commands to displacements
mounting         angles of the rays, radians; origin; reach: the largest reading
motion           twist, strength: what odometry gets wrong, and how uncertain it is
```
"""

import json
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np

from motorspace._errors import UserError
from motorspace._files import write_json

FORMAT_VERSION = 1
LARGEST = 2**26
"""Bytes of a file that is read."""
SHAPES: dict[str, tuple[int | str, ...]] = {
    "odometry.step": ("F", 4),
    "odometry.gaze": ("F", 4),
    "odometry.step_twist": ("F", 3),
    "odometry.gaze_twist": ("F", 3),
    "rig.frame": (3, 3),
    "mounting.angles": ("K",),
    "mounting.origin": (2,),
    "mounting.reach": (),
    "motion.twist": (6, 3),
    "motion.strength": (12,),
}
"""Every array by section and name; equal letters are equal sizes."""
SWITCHES = ("odometry.has_gaze", "rig.per_scan")
REMEDY = "calibrate anew: motorspace map and odometry write such a file"

Sections = dict[str, dict[str, Any]]
"""What the file says: arrays, numbers and switches by section and name."""


def write_sections(path: Path, sections: Mapping[str, Mapping[str, Any]]) -> None:
    """Write a calibration. Raises `UserError` where that is not possible."""
    written = {
        section: {name: np.asarray(value).tolist() for name, value in fields.items()}
        for section, fields in sections.items()
    }
    write_json(path, {"format_version": FORMAT_VERSION} | written)


def read_sections(path: str | Path) -> Sections:
    """What `write_sections` has written.

    Args:
        path: The file.

    Raises:
        UserError: For a file that is missing, broken, of another version, or of other shapes.
    """
    path = Path(path)
    written = _written(path)
    version = written.get("format_version")
    if version != FORMAT_VERSION:
        raise UserError(
            f"the calibration is of format version {version!r}, and this program reads version "
            f"{FORMAT_VERSION}",
            where=path,
            remedy="calibrate anew, or update motorspace",
        )
    found: Sections = {}
    sizes: dict[str, int] = {}
    for name, shape in SHAPES.items():
        section, _, key = name.partition(".")
        found.setdefault(section, {})[key] = _array(_value(written, name, path), name, path)
        _check_shape(found[section][key], shape, sizes, name, path)
    for name in SWITCHES:
        section, _, key = name.partition(".")
        if not isinstance(value := _value(written, name, path), bool):
            raise UserError(f"{name} is neither true nor false", where=path, remedy=REMEDY)
        found[section][key] = value
    _check_values(found, path)
    return found


def _written(path: Path) -> dict[str, Any]:
    try:
        if path.stat().st_size > LARGEST:
            raise ValueError
        written = json.loads(path.read_bytes())
    except OSError as error:
        raise UserError(
            f"the calibration cannot be read ({error.strerror})",
            where=path,
            remedy="check the path",
        ) from None
    except (ValueError, RecursionError):
        written = None
    if not isinstance(written, dict) or "format_version" not in written:
        raise UserError("this is no calibration", where=path, remedy=REMEDY)
    return written


def _value(written: dict[str, Any], name: str, path: Path) -> Any:
    section, _, key = name.partition(".")
    fields = written.get(section)
    if not isinstance(fields, dict) or key not in fields:
        raise UserError(f"{name} is missing in the calibration", where=path, remedy=REMEDY)
    return fields[key]


def _array(value: Any, name: str, path: Path) -> np.ndarray:
    try:
        array = np.asarray(value)
    except ValueError:
        array = np.asarray(None)
    if array.dtype.kind not in "if":
        raise UserError(f"{name} does not hold numbers alone", where=path, remedy=REMEDY)
    if not np.isfinite(array).all():
        raise UserError(f"{name} holds numbers that are not finite", where=path, remedy=REMEDY)
    return array.astype(np.float64)


def _check_shape(
    array: np.ndarray, shape: tuple[int | str, ...], sizes: dict[str, int], name: str, path: Path
) -> None:
    """Refuse another shape. The first size that a letter stands for holds for all."""
    if array.ndim == len(shape):
        named = {letter: size for letter, size in zip(shape, array.shape, strict=True)}
        for letter, size in named.items():
            if isinstance(letter, str):
                sizes.setdefault(letter, size)
    wanted = tuple(sizes.get(part, 0) if isinstance(part, str) else part for part in shape)
    if array.shape != wanted or 0 in wanted:
        raise UserError(
            f"{name} is of shape {list(array.shape)}, not {list(shape)}",
            where=path,
            remedy=REMEDY,
        )


def _check_values(found: Sections, path: Path) -> None:
    """Refuse what has the right shape and makes no sense."""
    if (found["motion"]["strength"] < 0).any():
        raise UserError("motion.strength is below 0 in places", where=path, remedy=REMEDY)
    if found["mounting"]["reach"] <= 0:
        raise UserError("mounting.reach is not above 0", where=path, remedy=REMEDY)
