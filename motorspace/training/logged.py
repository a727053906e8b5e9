"""Transitions of a robot's log, as data."""

from dataclasses import dataclass, replace
from functools import lru_cache
from pathlib import Path
from typing import TYPE_CHECKING, Any

from motorspace._errors import UserError
from motorspace._files import file_hash
from motorspace._kinds import Part
from motorspace.worlds.checks import flag, whole

if TYPE_CHECKING:
    from motorspace.recordings.recording import Recording


@dataclass(frozen=True, init=False)
class Logged:
    """Transitions of a robot's log, split into blocks of time for training and test.

    Args:
        path: The log.
        reader: Which reader reads it; by default the one that recognises its content.
        horizon: Scans from the beginning of a transition to its end.
        min_horizon: Training also sees transitions over fewer scans, down to these.
        per_scan: Whether the motor increments between two scans are chained into one command;
            otherwise a sequence holds every increment.
        num_blocks: Blocks of time that the log is cut into: 60 % are for training, 20 % for
            validation, 20 % for test.
        sha256: Hash of the log's content; by default that of the file as it is now.
        options: Options of the reader, such as `num_rays`.

    Raises:
        UserError: For a file that cannot be read, and options that the reader does not have.
    """

    path: str
    sha256: str
    reader: Part
    horizon: int
    min_horizon: int | None
    per_scan: bool
    num_blocks: int

    def __init__(
        self,
        path: str | Path,
        reader: str | Part | None = None,
        horizon: int = 6,
        min_horizon: int | None = None,
        per_scan: bool = True,
        num_blocks: int = 20,
        sha256: str | None = None,
        **options: Any,
    ) -> None:
        from motorspace.recordings.catalog import READERS, reader_for

        kind = reader_for(Path(path)) if reader is None else reader
        part = READERS.part(kind, options) if isinstance(kind, str) else kind
        set_fields(
            self,
            path=str(path),
            sha256=sha256 or file_hash(Path(path)),
            reader=part,
            horizon=horizon,
            min_horizon=min_horizon,
            per_scan=per_scan,
            num_blocks=whole("num_blocks", num_blocks),
        )
        flag("per_scan", per_scan)
        check_horizon(horizon, min_horizon)

    def at(self, path: str | Path) -> "Logged":
        """The same log, which now lies elsewhere. Raises `UserError` if it is another one."""
        moved = replace(self, path=str(path), sha256=self.sha256)
        moved.check_content()
        return moved

    def check_content(
        self, *, remedy: str = "give the original file, or train a new run on this one"
    ) -> None:
        """Raise `UserError` unless the file is there and still holds what it held."""
        try:
            content = file_hash(Path(self.path))
        except UserError as error:
            raise UserError(error.what, where=self.path, remedy=remedy) from None
        if content != self.sha256:
            raise UserError(
                "this is not the log that the run has learned from (its content differs)",
                where=self.path,
                remedy=remedy,
            )

    def recording(self) -> "Recording":
        """The log, read. Raises `UserError` if it is gone, has changed or cannot be read."""
        self.check_content()
        return _recording(self)

    def as_json(self) -> dict[str, Any]:
        """The same as JSON-able data."""
        return {"kind": "logged"} | vars(self) | {"reader": self.reader.as_json()}


@lru_cache(maxsize=1)
def _recording(data: Logged) -> "Recording":
    from motorspace.recordings.catalog import READERS

    read: Recording = READERS.build(data.reader).read(Path(data.path))
    return read


def set_fields(target: Any, **fields: Any) -> None:
    """Set fields of a frozen dataclass while it is made."""
    for name, value in fields.items():
        object.__setattr__(target, name, value)


def check_horizon(horizon: int, min_horizon: int | None) -> None:
    """Raise `UserError` unless these are a longest and a shortest number of steps."""
    whole("horizon", horizon)
    if min_horizon is not None and whole("min_horizon", min_horizon) > horizon:
        raise UserError(
            f"min_horizon {min_horizon} is above horizon {horizon}",
            remedy="give a min_horizon from 1 to horizon",
        )
