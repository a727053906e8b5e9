"""A judge in a folder: what it has learned of its body, and the walk that it remembers.

```
FOLDER/judge.json         the version of the format
FOLDER/judge.safetensors  the calibration, where the rays began and what was sensed there
```
"""

import json
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np
from safetensors import SafetensorError
from safetensors.numpy import load, save

from motorspace._errors import UserError
from motorspace._files import write_atomically, write_json
from motorspace.judge.codes import CodeBook
from motorspace.judge.judge import Calibration, Judge
from motorspace.mapping.calibration import Calibrated
from motorspace.mapping.mounting import Mounting
from motorspace.mapping.odometry import Odometry

FORMAT_VERSION = 1
DESCRIPTION, ARRAYS = "judge.json", "judge.safetensors"


def save_judge(judge: Judge, folder: str | Path) -> None:
    """Write the calibration and the remembered walk into a folder: safetensors and JSON.

    Args:
        judge: What is written.
        folder: Is made where it does not exist; a judge that it holds is replaced.
    """
    body, codes = judge.calibration.body, judge.calibration.codes
    arrays = {
        **_named("odometry", body.odometry),
        **_named("mounting", body.mounting),
        **_named("codes", codes),
        "eyes": judge.eyes.astype(np.float32),
        "sensors": judge.sensors.astype(np.float32),
    }
    folder = Path(folder)
    folder.mkdir(parents=True, exist_ok=True)
    stored = {name: np.ascontiguousarray(array) for name, array in arrays.items()}
    write_atomically(folder / ARRAYS, save(stored))
    write_json(folder / DESCRIPTION, {"format_version": FORMAT_VERSION})


def load_judge(folder: str | Path) -> Judge:
    """The judge that `save_judge` has written into a folder.

    Args:
        folder: Holds `judge.json` and `judge.safetensors`.

    Returns:
        The judge; its map is made anew from the walk that it remembers.

    Raises:
        UserError: Where there is none, or its files are damaged.
    """
    folder = Path(folder)
    try:
        version = json.loads((folder / DESCRIPTION).read_bytes())["format_version"]
        arrays = load((folder / ARRAYS).read_bytes())
        if version != FORMAT_VERSION:
            raise UserError(
                f"the judge is of format version {version!r}, and this program reads version "
                f"{FORMAT_VERSION}",
                where=folder,
                remedy="update motorspace",
            )
        mounting = _of(Mounting, "mounting", arrays)
        odometry = _of(Odometry, "odometry", arrays)
        body = Calibrated(
            odometry._replace(has_gaze=bool(odometry.has_gaze.item())),
            mounting._replace(reach=float(mounting.reach.item())),
        )
        calibration = Calibration(body, _of(CodeBook, "codes", arrays))
        walked = [arrays[name].astype(np.float64) for name in ("eyes", "sensors")]
    except FileNotFoundError:
        raise UserError(
            "there is no judge here", where=folder, remedy="give a folder that a judge was saved to"
        ) from None
    except (OSError, ValueError, KeyError, TypeError, SafetensorError):
        raise UserError(
            "the judge cannot be read", where=folder, remedy="calibrate it anew"
        ) from None
    return Judge.remembering(calibration, *walked)


def _named(prefix: str, fields: Any) -> dict[str, np.ndarray]:
    return {f"{prefix}.{name}": np.asarray(value) for name, value in fields._asdict().items()}


def _of(kind: Any, prefix: str, arrays: Mapping[str, np.ndarray]) -> Any:
    return kind(**{name: arrays[f"{prefix}.{name}"] for name in kind._fields})
