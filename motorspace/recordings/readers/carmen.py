"""CARMEN text logs."""

import math
from collections import Counter
from dataclasses import dataclass, field
from pathlib import Path
from typing import ClassVar, Literal

import numpy as np

from motorspace._errors import UserError
from motorspace.recordings.readers.faults import Faults
from motorspace.recordings.readers.lasers import NOWHERE, FramedReader, Log, Odometry, Place, Scan
from motorspace.recordings.readers.ranges import Beams
from motorspace.recordings.readers.text import finite, is_number, numbers, read_text

Laser = Literal["front", "rear", "third", "fourth"]

LASERS: dict[str, tuple[str, ...]] = {
    "front": ("FLASER", "ROBOTLASER1", "REMISSIONFLASER", "RAWLASER1"),
    "rear": ("RLASER", "ROBOTLASER2", "REMISSIONRLASER", "RAWLASER2"),
    "third": ("LASER3", "ROBOTLASER3", "REMISSIONLASER3", "RAWLASER3"),
    "fourth": ("LASER4", "ROBOTLASER4", "REMISSIONLASER4", "RAWLASER4"),
}
"""The rows of each laser; where a log has more than one kind, the first is read."""

WORDS = {
    "ODOM",
    "PARAM",
    "SYNC",
    "TRUEPOS",
    "NEFF",
    *(row for rows in LASERS.values() for row in rows),
}

NEW = ("ROBOTLASER", "RAWLASER")
HEADER = 8
"""Words of a new row before its ranges: type, first angle, field of view, resolution, maximum
range, accuracy, remission mode, number of beams."""


@dataclass(frozen=True)
class CarmenReader(FramedReader):
    """Reads CARMEN logs: `ODOM` rows, and `FLASER`, `ROBOTLASER1` or `RAWLASER1` rows of scans.

    Metres, radians, seconds. Motor increments are (longitudinal, lateral, rotation).
    """

    endings: ClassVar[tuple[str, ...]] = (".log", ".clf")

    laser: Laser = "front"
    """The laser whose scans are read."""
    laser_view: float = field(default=math.pi, metadata={"in_pi": True, "positive": True})
    """What the laser sees where its rows do not say, as old FLASER rows."""

    @classmethod
    def recognises(cls, name: str, head: bytes) -> bool:
        """Whether a line begins with the name of a CARMEN message."""
        lines = head.decode("latin-1").removeprefix("\xef\xbb\xbf").splitlines()
        return any(words[0] in WORDS for line in lines if len(words := line.split(maxsplit=2)) > 1)

    def parse_rows(self, path: Path, faults: Faults) -> Log:
        """The odometry and the scans of one laser."""
        lines = [line.split() for line in read_text(path, faults).splitlines()]
        counts = Counter(words[0] for words in lines if words and not words[0].startswith("#"))
        kind = self._kind(counts, path)
        rows: list[Odometry | Scan] = []
        notes = []
        last = max(number for number, words in enumerate(lines) if words)
        for number, words in enumerate(lines):
            if not words or words[0] not in ("ODOM", kind):
                continue
            place = f"{path}, line {number + 1}"
            try:
                rows.append(
                    _odometry(words, place) if words[0] == "ODOM" else self._scan(words, place)
                )
            except UserError as error:
                if number == last and len(rows) > 1:
                    notes.append(f"line {number + 1}, the last one, is cut off: left out")
                else:
                    faults.add(error)
        ignored = [(n, word) for word, n in counts.items() if word not in ("ODOM", kind)]
        if ignored:
            found = ", ".join(f"{n} {word}" for n, word in sorted(ignored, reverse=True)[:8])
            notes.append(f"rows that are not read: {found}")
        return Log(rows, notes)

    def _kind(self, counts: Counter[str], path: Path) -> str:
        """The kind of the rows to read. Raises `UserError` when this laser has none."""
        if found := [kind for kind in LASERS[self.laser] if counts[kind]]:
            return found[0]
        others = [laser for laser, kinds in LASERS.items() if any(counts[kind] for kind in kinds)]
        raise UserError(
            f"the log holds no scans of the {self.laser} laser",
            where=path,
            remedy=f"it has those of the {' and the '.join(others)} laser: choose that one"
            if others
            else f"give a log with {LASERS[self.laser][0]} rows",
        )

    def _scan(self, words: list[str], place: str) -> Scan:
        if words[0].startswith(NEW):
            return _new_scan(words, place)
        step = 2 if words[0].startswith("REMISSION") else 1
        _, end = _beams(words, 1, place, step)
        ranges = numbers(words[2:end:step], place)
        pose, odometry, time = _after_ranges(words[end:], place)
        beams = Beams(-self.laser_view / 2, self.laser_view, np.array(ranges))
        return Scan(beams, pose, odometry, time)


def _odometry(words: list[str], place: str) -> Odometry:
    if len(words) < 4:
        raise UserError("an ODOM row needs x, y and theta", where=place, remedy="correct the row")
    x, y, theta = finite(words[1:4], place)
    return Odometry((x, y, theta), _time(words[7:8]))


def _beams(words: list[str], at: int, place: str, step: int = 1) -> tuple[int, int]:
    """The number of beams, which word `at` says, and where they end."""
    count = _count(words, at, place)
    if count is None or count < 1:
        raise UserError(
            f"a {words[0]} row begins with its number of beams", where=place, remedy="correct it"
        )
    end = at + 1 + step * count
    if len(words) < end:
        raise UserError(
            f"a {words[0]} row of {count} beams ends after {len(words)} words",
            where=place,
            remedy="correct or remove the row",
        )
    return count, end


def _count(words: list[str], at: int, place: str) -> int | None:
    """The whole number that word `at` says, None where there is none."""
    found = numbers(words[at : at + 1], place)
    return int(found[0]) if found and 0 <= found[0] < 1e9 and found[0] % 1 == 0 else None


def _after_ranges(words: list[str], place: str) -> tuple[Place, Place, float]:
    """The laser's pose, the odometry and the time of an old row; oldest rows have fewer of them."""
    if len(words) > 3 and not is_number(words[-2]):
        # Two time stamps with a host between them; before the poses some write a maximum range.
        values, time = finite(words[:-3], place)[-6:], _time(words[-3:-2])
    else:
        values, time = finite(words[:6], place), _time(words[6:7])
    if len(values) not in (0, 3, 6):
        raise UserError(
            f"a pose of {len(values)} numbers follows the ranges", where=place, remedy="correct it"
        )
    pose = _place(values[:3])
    return pose, _place(values[3:]) if len(values) == 6 else pose, time


def _new_scan(words: list[str], place: str) -> Scan:
    """A ROBOTLASER row, or a RAWLASER row, which has no poses."""
    if len(words) <= HEADER:
        raise UserError(f"the {words[0]} row is too short", where=place, remedy="correct the row")
    first, view, resolution, limit = finite(words[2:6], place)
    count, end = _beams(words, HEADER, place)
    ranges = np.array(numbers(words[HEADER + 1 : end], place))
    span = resolution * (count - 1) if resolution > 0 else view
    remissions = _count(words, end, place)
    rest = words[end + 1 + (remissions or 0) :]
    beams, limit = Beams(first, span, ranges), limit if limit > 0 else math.inf
    if words[0].startswith("RAWLASER"):
        return Scan(beams, NOWHERE, NOWHERE, _time(rest[:1]), limit)
    if len(rest) < 6:
        raise UserError(f"the {words[0]} row has no poses", where=place, remedy="correct the row")
    poses = finite(rest[:6], place)
    return Scan(beams, _place(poses[:3]), _place(poses[3:]), _time(rest[11:12]), limit)


def _place(values: list[float]) -> Place:
    x, y, theta = values or NOWHERE
    return x, y, theta


def _time(words: list[str]) -> float:
    """Seconds; NaN where there is no time stamp, or one that is no number."""
    return float(words[0]) if words and is_number(words[0]) else math.nan
