"""Trajectories in a file: the arrays and, in the same file, the configuration behind them."""

import hashlib
import json
from pathlib import Path
from typing import Any

import jax.numpy as jnp
import numpy as np
from safetensors import SafetensorError
from safetensors.numpy import load, save

from motorspace._errors import UserError
from motorspace._files import write_atomically
from motorspace.trajectories.transitions import Displacements, Experience, Trajectories

EXPERIENCE = ("sensors", "motors", "num_steps", "later_sensors")
DISPLACEMENTS = ("nominal", "achieved")


def save_trajectories(
    path: str | Path, trajectories: Trajectories, *, config: dict[str, Any]
) -> None:
    """Write trajectories and what they were made with as one safetensors file.

    The file is replaced as a whole: a reader sees the old one or the new one.

    Args:
        path: The file.
        trajectories: What to save.
        config: What they were made with, as JSON-able data.

    Raises:
        UserError: When the file cannot be written.
    """
    arrays = {
        **{n: np.asarray(getattr(trajectories.experience, n)) for n in EXPERIENCE},
        **{n: np.asarray(getattr(trajectories.displacements, n)) for n in DISPLACEMENTS},
    }
    text = json.dumps(config)
    content = save(arrays, metadata={"config": text, "sha256": _digest(arrays, text)})
    write_atomically(Path(path), content)


def load_trajectories(path: str | Path) -> tuple[Trajectories, dict[str, Any]]:
    """The trajectories and the `config` that `save_trajectories` wrote.

    JSON has no tuples: those of the saved `config` come back as lists.

    Raises:
        UserError: When the file is missing, damaged or of another kind. A checksum finds changed
            values too, which the format itself would let pass.
    """
    path = Path(path)
    try:
        content = path.read_bytes()
        arrays = load(content)
    except OSError as error:
        raise _unreadable(path, error.strerror or "no reason given") from None
    except SafetensorError:
        raise _unreadable(path, "it is damaged or no safetensors file") from None
    # The format: the header's length in eight bytes, the header as JSON, the arrays.
    header = json.loads(content[8 : 8 + int.from_bytes(content[:8], "little")])
    metadata = header.get("__metadata__", {})
    if {"config", "sha256"} - set(metadata) or set(arrays) != {*EXPERIENCE, *DISPLACEMENTS}:
        raise _unreadable(path, "the file holds something else")
    if metadata["sha256"] != _digest(arrays, metadata["config"]):
        raise _unreadable(path, "its content does not match its checksum")
    experience = Experience(**{n: jnp.asarray(arrays[n]) for n in EXPERIENCE})
    displacements = Displacements(**{n: jnp.asarray(arrays[n]) for n in DISPLACEMENTS})
    return Trajectories(experience, displacements), json.loads(metadata["config"])


def _digest(arrays: dict[str, np.ndarray], config: str) -> str:
    """The checksum of every name, type, shape and value."""
    digest = hashlib.sha256(config.encode())
    for name in sorted(arrays):
        digest.update(f"{name} {arrays[name].dtype} {arrays[name].shape}".encode())
        digest.update(np.ascontiguousarray(arrays[name]).tobytes())
    return digest.hexdigest()


def _unreadable(path: Path, reason: str) -> UserError:
    return UserError(
        f"the trajectories cannot be read ({reason})",
        where=path,
        remedy="check the path, or write the file again",
    )
