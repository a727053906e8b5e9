"""Files that are whole or not there, and folders that one process holds at a time."""

import fcntl
import json
import os
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

from motorspace._errors import UserError


@contextmanager
def locked(folder: Path) -> Iterator[None]:
    """Hold a folder for this process alone; the lock goes with the process, however it ends."""
    try:
        folder.mkdir(parents=True, exist_ok=True)
        handle = (folder / ".lock").open("w")
    except OSError as error:
        raise UserError(
            f"the folder cannot be written ({error.strerror})",
            where=folder,
            remedy="choose another folder",
        ) from None
    with handle:
        try:
            fcntl.flock(handle, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except BlockingIOError:
            raise UserError(
                "another process is training in this folder",
                where=folder,
                remedy="wait for it, or choose another folder",
            ) from None
        # What a process was writing when it was killed; with the lock, nobody writes now.
        for unfinished in folder.glob("*.part"):
            unfinished.unlink(missing_ok=True)
        yield


def write_atomically(path: Path, content: bytes) -> None:
    """Replace a file as a whole: a reader sees the old bytes or the new ones."""
    beside = path.with_name(f"{path.name}.{os.getpid()}.part")
    try:
        with beside.open("wb") as handle:
            handle.write(content)
            handle.flush()
            os.fsync(handle.fileno())
        beside.replace(path)
    finally:
        beside.unlink(missing_ok=True)


def write_json(path: Path, value: Any) -> None:
    """Replace a JSON file as a whole."""
    write_atomically(path, (json.dumps(value, indent=1) + "\n").encode())


def write_as_told(path: Path, content: bytes, *, what: str) -> None:
    """Replace a file that the user has named. Raises `UserError` when `what` cannot be written."""
    try:
        write_atomically(path, content)
    except OSError as error:
        raise UserError(
            f"the {what} cannot be written ({error.strerror})",
            where=path,
            remedy="give a file in a folder that exists and may be written to",
        ) from None
