"""What every reader of logs answers."""

import abc
from dataclasses import dataclass
from pathlib import Path
from typing import Any, ClassVar

from motorspace._errors import UserError
from motorspace._kinds import Registry, parameters_of
from motorspace.recordings.catalog import READERS, reader_for
from motorspace.recordings.recording import Recording
from motorspace.recordings.rules import Clock, leave_out, refuse_overflow


@dataclass(frozen=True)
class AbstractReader(abc.ABC):
    """Reads one format of logs. Its fields are its options, and flags of the command line.

    A reader of one's own is a frozen dataclass with defaults for all fields, registered with
    `@motorspace.register("NAME")`. It implements `recognises` and `parse`.
    """

    registry: ClassVar[Registry[Any]] = READERS

    endings: ClassVar[tuple[str, ...]] = ()
    """Endings of file names, tried where no reader recognises the content."""

    max_gap: float | None = None
    """Longest time between two scans of a transition, seconds (default: 10 times the median)."""
    max_jump: float | None = None
    """Longest movement between two scans of a transition, world units (default: 10 times the upper
    quartile of all movements)."""
    clock: Clock = "check"
    """ignore: leave no interval out because of its time stamps."""

    def __post_init__(self) -> None:
        for option in parameters_of(type(self)):
            option.check(getattr(self, option.name))
        for name in ("max_gap", "max_jump"):
            value = getattr(self, name)
            if value is not None and not value > 0:
                raise UserError(f"{name} must be above 0, got {value}")

    @classmethod
    @abc.abstractmethod
    def recognises(cls, name: str, head: bytes) -> bool:
        """Whether a file is of this format, from its name and first bytes (decompressed)."""

    @abc.abstractmethod
    def parse(self, path: Path) -> Recording:
        """The recording as the file has it. Raises `UserError` for a broken file."""

    def read(self, path: Path | str) -> Recording:
        """The recording, with the intervals that are no transition left out.

        Raises `UserError` for a broken file, and for values beyond 32-bit numbers.
        """
        recording = self.parse(Path(path))
        refuse_overflow(recording, where=path)
        if recording.judged and self.max_gap is None and self.max_jump is None:
            return recording
        return leave_out(recording, max_gap=self.max_gap, max_jump=self.max_jump, clock=self.clock)


def read_log(
    path: Path | str, reader: str | AbstractReader | None = None, **options: Any
) -> Recording:
    """The recording in a log of any known format.

    Args:
        path: The file.
        reader: The reader, or its kind; by default the one that recognises the content.
        options: Options of the reader; its defaults for all others.

    Raises:
        UserError: The file is missing, broken or of no known format, or the reader has no such
            option.

    >>> read_log("robot.log.gz", num_rays=30, max_range=8.0)  # doctest: +SKIP
    """
    path = Path(path)
    if isinstance(reader, AbstractReader):
        if options:
            raise UserError(
                "a reader that is made already takes no options",
                remedy="give its kind, or make it with these options",
            )
        return reader.read(path)
    part = READERS.part(reader or reader_for(path), options, where=path)
    made: AbstractReader = READERS.build(part)
    return made.read(path)
