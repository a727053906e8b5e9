"""A controller in the folder of its run.

```
RUN/controller.json         how it has learned
RUN/controller.safetensors  what it has learned
```
"""

import dataclasses
import json
from pathlib import Path

import jax
import jax.numpy as jnp

from motorspace._errors import UserError
from motorspace._files import write_atomically, write_json
from motorspace.control.codes import Examples, Probe, Whitening
from motorspace.control.composing import Remainder, is_product
from motorspace.control.controller import Controller, commands_of
from motorspace.control.decoder import Decoder
from motorspace.control.learning import ControlConfig
from motorspace.training.checkpoint import packed, unpacked
from motorspace.training.data import simulated
from motorspace.training.run import Run, load_run

FORMAT_VERSION = 1
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
    blank = _blank(run, config)
    decoder, whitening, probe, bank, remainder = unpacked(_learned(blank), folder / WEIGHTS)
    return Controller(run.model, decoder, whitening, probe, bank, blank.commands, remainder)


def stored_config(folder: Path) -> ControlConfig:
    """How the controller in a run's folder has learned. Raises `UserError` if there is none."""
    path = folder / CONFIG
    try:
        written = json.loads(path.read_bytes())
        if written["format_version"] != FORMAT_VERSION:
            raise UserError(
                f"the controller is of format version {written['format_version']!r}, and this "
                f"program reads version {FORMAT_VERSION}",
                where=path,
                remedy="update motorspace",
            )
        return ControlConfig(**written["config"])
    except (FileNotFoundError, NotADirectoryError):
        raise UserError("this run has no controller", where=folder, remedy=LEARN) from None
    except (OSError, ValueError, KeyError, TypeError, AttributeError):
        raise UserError("the controller cannot be read", where=path, remedy=LEARN) from None


def _learned(
    controller: Controller,
) -> tuple[Decoder, Whitening, Probe, Examples, Remainder | None]:
    known = controller.decoder, controller.whitening, controller.probe, controller.bank
    return *known, controller.remainder


def _blank(run: Run, config: ControlConfig) -> Controller:
    """A controller of the same shapes that knows nothing."""
    commands, horizon = commands_of(run), simulated(run.config.data).horizon
    shape = jax.ShapeDtypeStruct((horizon, commands.size), jnp.float32)
    steps = jax.ShapeDtypeStruct((), jnp.int32)
    size = jax.eval_shape(run.model.encode, shape, steps).shape[0]
    decoder = config.decoder((size, horizon, commands.size), key=jax.random.key(0))
    return Controller(
        run.model,
        decoder,
        Whitening(jnp.zeros(size), jnp.zeros((size, size))),
        Probe(jnp.zeros(size), jnp.zeros((4, size))),
        Examples(jnp.zeros((config.bank, horizon, commands.size)), jnp.zeros((config.bank, size))),
        commands,
        None if is_product(run.model) else config.remainder(size, key=jax.random.key(0)),
    )
