"""What an export writes: named files, all of them complete before the first is written."""

from collections.abc import Iterator
from contextlib import contextmanager
from importlib.metadata import version
from pathlib import Path
from typing import Any

from motorspace._errors import UserError
from motorspace._files import write_atomically
from motorspace.training.run import Run

Files = dict[str, bytes]
"""The content of each file by its name."""


def write_files(out: Path, files: Files, *, force: bool = False) -> None:
    """Write an export's files into a folder, which is made if need be.

    Each file appears whole or not at all, in the given order: one that describes the others
    stands last. Files of other names are left alone.

    Args:
        out: The folder.
        files: The content of each file by its name.
        force: Replace files that are already there.

    Raises:
        UserError: A file is already there and `force` is false, or the folder cannot be written.
    """
    try:
        out.mkdir(parents=True, exist_ok=True)
        there = [name for name in files if (out / name).exists()]
        if there and not force:
            raise UserError(
                f"the folder already holds {', '.join(there)}",
                where=out,
                remedy="choose another folder, or replace them with --force",
            )
        for name, content in files.items():
            write_atomically(out / name, content)
    except OSError as error:
        raise UserError(
            f"the export cannot be written ({error.strerror})",
            where=out,
            remedy="give a folder that can be written to, on a disk with enough space",
        ) from None


@contextmanager
def needs(extra: str) -> Iterator[None]:
    """Turn a missing optional package into a sentence with the line that installs it.

    Raises:
        UserError: A module that the block imports is not installed.
    """
    try:
        yield
    except ModuleNotFoundError as error:
        raise UserError(
            f"{error.name} is not installed",
            remedy=f"install the extra: pip install 'motorspace[{extra}]'",
        ) from None


def made_by(run: Run) -> dict[str, Any]:
    """What every export says of its origin: the version of motorspace and the configuration."""
    return {"motorspace": version("motorspace"), "config": run.config.as_json()}
