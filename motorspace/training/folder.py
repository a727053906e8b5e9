"""The folder of a run: what determines it, what it has learned, and what it was measured at.

```
RUN/config.json             everything that determines the run
RUN/log.jsonl               one record per epoch
RUN/checkpoint.safetensors  the whole training state, replaced as one file
RUN/weights.safetensors     the network, once training is finished
RUN/evaluation.json         what `motorspace evaluate` measured
```
"""

import json
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from motorspace._errors import UserError
from motorspace._files import write_json
from motorspace.training.config import RunConfig, config_from_json
from motorspace.training.version_1 import config_of_version_1

FORMAT_VERSION = 2

CONFIG, LOG = "config.json", "log.jsonl"
CHECKPOINT, WEIGHTS = "checkpoint.safetensors", "weights.safetensors"
EVALUATION = "evaluation.json"

EPOCHS = "config.training.epochs"
PATHS = ("config.data.path", "config.data.base.path")
"""Where a log lies, which does not matter: it is known by its content."""


@dataclass(frozen=True)
class Description:
    """What a run's `config.json` says."""

    config: RunConfig
    sensor_scale: tuple[float, ...]
    """What each sensor is divided by."""
    motor_scale: tuple[float, ...]
    """What each command channel is divided by."""
    horizon: int
    """Motor commands of the longest transition."""

    def as_json(self) -> dict[str, Any]:
        """The same as JSON-able data."""
        return {
            "format_version": FORMAT_VERSION,
            "config": self.config.as_json(),
            "scaling": {"sensors": list(self.sensor_scale), "motors": list(self.motor_scale)},
            "horizon": self.horizon,
        }


def load_config(folder: str | Path) -> RunConfig:
    """The configuration of the run in a folder. Raises `UserError` if there is none."""
    return read_description(Path(folder)).config


def read_description(folder: Path) -> Description:
    """What the run's `config.json` says. Raises `UserError` where it is missing or broken."""
    path = folder / CONFIG
    try:
        written = json.loads(path.read_bytes())
        version = written["format_version"]
        if version not in (1, FORMAT_VERSION):
            raise UserError(
                f"the run is of format version {version!r}, and this program reads versions 1 "
                f"and {FORMAT_VERSION}",
                where=path,
                remedy="update motorspace",
            )
        sensors, motors = (tuple(written["scaling"][part]) for part in ("sensors", "motors"))
        if version == 1:
            config = config_of_version_1(written, where=path)
        else:
            config = config_from_json(written["config"], where=path)
        return Description(config, sensors, motors, written["horizon"])
    except (FileNotFoundError, NotADirectoryError):
        raise UserError(
            "there is no run here",
            where=folder,
            remedy="give a folder made by motorspace train",
        ) from None
    except (OSError, ValueError, KeyError, TypeError, AttributeError):
        raise UserError(
            "the run's configuration cannot be read", where=path, remedy="train the run anew"
        ) from None


def finished(folder: Path) -> bool:
    """Whether the run's training is finished."""
    return (folder / WEIGHTS).exists()


def claim(folder: Path, run: Description, *, resume: bool) -> None:
    """Make the folder this run's own, or make sure that it already is.

    A run may be lengthened, and its log may have moved: of all that determines it, `epochs` alone
    may have grown. Raises `UserError` for the folder of another run.
    """
    path = folder / CONFIG
    if not path.exists():
        write_json(path, run.as_json())
        return
    if not resume:
        raise UserError(
            "the folder already holds a run",
            where=folder,
            remedy="continue it with --resume, or choose another folder",
        )
    before = read_description(folder)
    changes = differences(*(json.loads(json.dumps(d.as_json())) for d in (before, run)))
    other = [name for name in changes if name not in PATHS]
    longer = other == [EPOCHS] and run.config.training.epochs > before.config.training.epochs
    if other and not longer:
        names = ", ".join(name.rpartition(".")[2] for name in other)
        raise UserError(
            f"the folder belongs to another configuration (different: {names})",
            where=folder,
            remedy="choose another folder, or the flags it was started with",
        )
    if changes:
        write_json(path, run.as_json())
    if longer:
        (folder / WEIGHTS).unlink(missing_ok=True)


def differences(before: Any, after: Any, name: str = "") -> dict[str, tuple[Any, Any]]:
    """{dotted name: both values} of everything that differs in two nested dictionaries.

    Parts of another kind, which have other fields, differ as a whole.
    """
    nested = isinstance(before, dict) and isinstance(after, dict)
    if nested and before.get("kind") == after.get("kind"):
        found: dict[str, tuple[Any, Any]] = {}
        for key in sorted(before.keys() | after.keys()):
            below = f"{name}.{key}" if name else key
            found |= differences(before.get(key), after.get(key), below)
        return found
    return {} if before == after else {name: (before, after)}


def read_log(folder: Path) -> list[dict[str, float | int]]:
    """The records of the epochs so far. Raises `UserError` where they cannot be read."""
    path = folder / LOG
    try:
        return [json.loads(line) for line in path.read_text().splitlines()]
    except FileNotFoundError:
        return []
    except (OSError, ValueError):
        raise UserError(
            "the run's log cannot be read", where=path, remedy="train the run anew"
        ) from None
