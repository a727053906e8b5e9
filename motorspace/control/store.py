"""A controller in the folder of its run.

```
RUN/controller.json         how it has learned
RUN/controller.safetensors  what it has learned
```
"""

import dataclasses
import json
from pathlib import Path

from motorspace._errors import UserError
from motorspace._files import write_atomically, write_json
from motorspace.control.codes import Probe
from motorspace.control.composing import Remainder
from motorspace.control.controller import Controller, blank_controller
from motorspace.control.decoder import Decoder
from motorspace.control.learning import ControlConfig
from motorspace.training.checkpoint import packed, unpacked
from motorspace.training.run import load_run

FORMAT_VERSION = 2
CONFIG, WEIGHTS = "controller.json", "controller.safetensors"
LEARN = "learn it with: motorspace control RUN"


def save_controller(controller: Controller, config: ControlConfig, folder: str | Path) -> None:
    """Write a controller into the folder of its run; one that is there is replaced.

    Args:
        controller: The controller.
        config: How it has learned.
        folder: The folder of its run.

    Raises:
        UserError: When the folder cannot be written.
    """
    write_atomically(Path(folder) / WEIGHTS, packed(_learned(controller)))
    described = {"format_version": FORMAT_VERSION, "config": dataclasses.asdict(config)}
    write_json(Path(folder) / CONFIG, described)


def load_controller(folder: str | Path) -> Controller:
    """Return the controller in the folder of a run.

    Args:
        folder: A run's folder that `save_controller` or `motorspace control` has written to.

    Raises:
        UserError: When there is no finished run or no controller, or one of them is broken.
    """
    folder = Path(folder)
    run, config = load_run(folder), stored_config(folder)
    blank = blank_controller(run, config)
    decoder, probe, remainder = unpacked(_learned(blank), folder / WEIGHTS)
    return dataclasses.replace(blank, decoder=decoder, probe=probe, remainder=remainder)


def stored_config(folder: Path) -> ControlConfig:
    """How the controller in a run's folder has learned. Raises `UserError` if there is none."""
    path = folder / CONFIG
    try:
        written = json.loads(path.read_bytes())
        if (version := int(written["format_version"])) != FORMAT_VERSION:
            raise UserError(
                f"the controller is of format version {version}, and this program reads version "
                f"{FORMAT_VERSION}",
                where=path,
                remedy=LEARN if version < FORMAT_VERSION else "update motorspace",
            )
        return ControlConfig(**written["config"])
    except (FileNotFoundError, NotADirectoryError):
        raise UserError("this run has no controller", where=folder, remedy=LEARN) from None
    except (OSError, ValueError, KeyError, TypeError, AttributeError):
        raise UserError("the controller cannot be read", where=path, remedy=LEARN) from None


def _learned(controller: Controller) -> tuple[Decoder, Probe, Remainder | None]:
    """What is kept; bank and whitening follow from the run's network and the seed."""
    return controller.decoder, controller.probe, controller.remainder
