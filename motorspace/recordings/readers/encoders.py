"""Text logs of wheel encoders and laser ranges: one row of numbers for each scan."""

import math
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np
from jaxtyping import Float

from motorspace._errors import UserError
from motorspace.recordings.readers.faults import Faults
from motorspace.recordings.readers.lasers import NOWHERE, LaserReader, Log, Scan
from motorspace.recordings.readers.motion import driven
from motorspace.recordings.readers.ranges import Beams
from motorspace.recordings.readers.table import PER_SECOND, TimeUnit
from motorspace.recordings.readers.text import is_number, numbers, read_text

FEWEST = 60
"""Numbers in a row by which such a log is recognised, at least."""


@dataclass(frozen=True)
class EncoderReader(LaserReader):
    """Reads rows of a time stamp, the counts of two wheel encoders, and laser ranges.

    The defaults are the robot and the laser of the CoreSLAM logs (Steux and El Hamzaoui, 2010):
    microseconds, millimetres, a Hokuyo URG-04LX. Columns count from 0. Recordings are in metres,
    radians, seconds; motor increments are (longitudinal, lateral, rotation).
    """

    time_column: int = 0
    """Column of the time stamps."""
    time_unit: TimeUnit = "us"
    """Unit of the time stamps."""
    left_column: int = 2
    """Column of the left wheel's count, which grows as the robot goes ahead."""
    right_column: int = 3
    """Column of the right wheel's count."""
    ranges_column: int = 25
    """First column of the laser ranges; they go on to the end of the row."""
    range_unit: float = field(default=0.001, metadata={"positive": True})
    """Metres in one unit of the laser ranges."""
    min_range: float = field(default=0.02, metadata={"positive": True})
    """Shorter readings are error codes of the laser, which count as no return, metres."""
    laser_view: float = field(default=math.radians(239.765625), metadata={"in_pi": True})
    """Angle from the first beam to the last, half of it on either side; negative where the first
    beam is the leftmost."""
    ticks_per_turn: float = field(default=2000.0, metadata={"positive": True})
    """Counts in one turn of a wheel."""
    wheel_radius: float = field(default=0.077, metadata={"positive": True})
    """Radius of the wheels, metres."""
    track: float = field(default=0.33, metadata={"positive": True})
    """Distance between the wheels, metres."""

    def __post_init__(self) -> None:
        super().__post_init__()
        columns = self._columns()
        if min(columns) < 0 or len(set(columns)) < len(columns):
            raise UserError(f"the columns are {', '.join(map(str, columns))}: they have to differ")
        if not 0 < abs(self.laser_view) <= 2 * math.pi:
            raise UserError("laser_view must be from -2 to 2 (in units of pi), and not 0")

    @classmethod
    def recognises(cls, name: str, head: bytes) -> bool:
        """Whether the first row holds nothing but numbers, and many of them."""
        words = head.lstrip().partition(b"\n")[0].decode("latin-1").split()
        return len(words) >= FEWEST and all(map(is_number, words))

    def parse_rows(self, path: Path, faults: Faults) -> Log:
        """The scans, each with the pose to which the wheels have carried the robot."""
        rows: list[list[float]] = []
        for number, line in enumerate(read_text(path, faults).splitlines(), start=1):
            words = line.split()
            if words and not words[0].startswith("#"):
                try:
                    rows.append(self._row(words, f"{path}, line {number}"))
                except UserError as error:
                    faults.add(error)
        if len(rows) < 2:
            return Log([], [])
        poses = self._poses(np.array([row[1:3] for row in rows]))
        return Log(
            [self._scan(row, pose) for row, pose in zip(rows, poses.tolist(), strict=True)],
            [f"motion by the counts in columns {self.left_column} and {self.right_column}"],
        )

    def _columns(self) -> tuple[int, int, int, int]:
        return self.time_column, self.left_column, self.right_column, self.ranges_column

    def _row(self, words: list[str], place: str) -> list[float]:
        """Time, both counts, and the ranges."""
        if len(words) <= max(self._columns()):
            raise UserError(
                f"the row ends after {len(words)} numbers",
                where=place,
                remedy=f"correct it, or choose columns below {len(words)}",
            )
        values = numbers(words, place)
        head = [values[column] for column in self._columns()[:3]]
        if not all(map(math.isfinite, head)):
            raise UserError("its time or a count is not finite", where=place, remedy="correct it")
        return [*head, *values[self.ranges_column :]]

    def _poses(self, counts: Float[np.ndarray, "N 2"]) -> Float[np.ndarray, "N 3"]:
        way = 2 * math.pi * self.wheel_radius / self.ticks_per_turn
        left, right = way * np.diff(counts, axis=0).T
        return driven(
            np.stack([(left + right) / 2, np.zeros_like(left), (right - left) / self.track], -1)
        )

    def _scan(self, row: list[float], pose: list[float]) -> Scan:
        ranges = self.range_unit * np.array(row[3:])
        ranges[(ranges >= 0) & (ranges < self.min_range)] = 0.0
        if self.laser_view < 0:
            ranges = ranges[::-1]
        view = abs(self.laser_view)
        x, y, angle = pose
        time = row[0] / PER_SECOND[self.time_unit]
        return Scan(Beams(-view / 2, view, ranges), NOWHERE, (x, y, angle), time)
