"""The text of the Wean Hall recordings: `L` rows of scans and `O` rows of odometry."""

import math
import re
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from motorspace._errors import UserError
from motorspace.recordings.readers.faults import Faults
from motorspace.recordings.readers.lasers import FramedReader, Log, Odometry, Place, Scan
from motorspace.recordings.readers.ranges import Beams
from motorspace.recordings.readers.text import finite, numbers, read_text

METRE = 0.01
"""The rows are in centimetres."""

ROW = re.compile(rb"^[LO]([ \t]+[-+.\deE]+){4}", re.MULTILINE)


@dataclass(frozen=True)
class WeanReader(FramedReader):
    """Reads `O x y theta t` and `L x y theta x y theta ranges t` rows, in centimetres.

    The second pose of an `L` row is that of the laser, which sees 180 degrees. Recordings are in
    metres, radians and seconds; motor increments are (longitudinal, lateral, rotation).
    """

    @classmethod
    def recognises(cls, name: str, head: bytes) -> bool:
        """Whether a line begins with O or L and four numbers."""
        return ROW.search(head) is not None

    def parse_rows(self, path: Path, faults: Faults) -> Log:
        """The odometry and the scans."""
        rows: list[Odometry | Scan] = []
        for number, line in enumerate(read_text(path, faults).splitlines(), start=1):
            words = line.split()
            if not words or words[0] not in ("L", "O"):
                continue
            try:
                rows.append(_row(words, f"{path}, line {number}"))
            except UserError as error:
                faults.add(error)
        return Log(rows, [])


def _row(words: list[str], place: str) -> Odometry | Scan:
    if len(words) < (5 if words[0] == "O" else 9):
        raise UserError(f"the {words[0]} row is too short", where=place, remedy="correct the row")
    pose, (time,) = _place(words[1:4], place), numbers(words[-1:], place)
    if words[0] == "O":
        return Odometry(pose, time)
    ranges = METRE * np.array(numbers(words[7:-1], place))
    beams = Beams(-math.pi / 2, math.pi, ranges)
    return Scan(beams, _place(words[4:7], place), pose, time)


def _place(words: list[str], place: str) -> Place:
    x, y, theta = finite(words, place)
    return METRE * x, METRE * y, theta
