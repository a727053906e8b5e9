"""Files that are whole or not there, and folders that one process holds at a time."""

import fcntl
import hashlib
import json
import math
import os
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from pathlib import Path
from typing import Any

from motorspace._errors import UserError

PART = ".motorspace-part"
"""How the names of our own unfinished files end; others' files are left alone."""


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
        for unfinished in folder.glob(f".*{PART}"):
            unfinished.unlink(missing_ok=True)
        yield


def write_atomically(path: Path, content: bytes) -> None:
    """Replace a file as a whole: a reader sees the old bytes or the new ones.

    Raises `UserError` when it cannot be written, as in a read-only folder or on a full disk.
    """
    beside = path.with_name(f".{path.name}.{os.getpid()}{PART}")
    try:
        try:
            with beside.open("wb") as handle:
                handle.write(content)
                handle.flush()
                os.fsync(handle.fileno())
            beside.replace(path)
        finally:
            beside.unlink(missing_ok=True)
    except OSError as error:
        raise UserError(
            f"the file cannot be written ({error.strerror})",
            where=path,
            remedy="give a place in a folder that exists, may be written to and has room",
        ) from None


def write_json(path: Path, value: Any) -> None:
    """Replace a JSON file as a whole. Numbers that are not finite become null."""
    write_atomically(path, (json_text(value, indent=1) + "\n").encode())


def json_text(value: Any, *, indent: int | None = None) -> str:
    """A value as JSON, in which numbers that are not finite are null."""
    return json.dumps(_finite(value), indent=indent, allow_nan=False)


def _finite(value: Any) -> Any:
    if isinstance(value, Mapping):
        return {key: _finite(inner) for key, inner in value.items()}
    if isinstance(value, list | tuple):
        return [_finite(inner) for inner in value]
    return None if isinstance(value, float) and not math.isfinite(value) else value


def file_hash(path: Path) -> str:
    """SHA-256 of a log's content, or of all files in a folder. Raises `UserError` if it fails."""
    try:
        if not path.is_dir():
            return _digest(path)
        parts = sorted(part for part in path.iterdir() if part.is_file())
        listed = "".join(f"{_digest(part)} {part.name}\n" for part in parts)
        return hashlib.sha256(listed.encode()).hexdigest()
    except OSError as error:
        raise UserError(
            f"the log cannot be read ({error.strerror})", where=path, remedy="check the path"
        ) from None


def _digest(path: Path) -> str:
    with path.open("rb") as file:
        return hashlib.file_digest(file, "sha256").hexdigest()
