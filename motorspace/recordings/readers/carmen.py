"""CARMEN text logs, plain or gzip.

A FLASER row carries a scan and the *corrected* pose; the ODOM rows between two scans carry
raw odometry that starts anew from each corrected pose. So a raw increment is a difference
between neighbouring ODOM rows, never across a FLASER row, where the frame jumps.
"""

import gzip
import math
import zlib
from collections.abc import Iterator
from pathlib import Path

import numpy as np

from motorspace._errors import UserError
from motorspace.recordings.recording import Recording, relative_poses


def read_carmen(
    path: Path, *, num_rays: int = 9, field_of_view: float = math.pi, max_range: float = 10.0
) -> Recording:
    """The scans and raw odometry increments of a CARMEN log. Metres, radians, seconds.

    Beam i of n points to -pi/2 + i pi/n from the heading, rightmost first; `num_rays` of them,
    evenly spread over `field_of_view` (at most pi), are kept. Readings at or beyond
    `max_range` mean «no return» and are clipped to it. Motor increments are (longitudinal,
    lateral, rotation).

    Raises `UserError` naming the file and the line that is broken.
    """
    scans, truths, times = [], [], []
    increments, intervals = [], []
    last_odometry: list[float] | None = None
    for number, words in _rows(path):
        place = f"{path}, line {number}"
        if words[0] == "FLASER":
            count = _beams(words, place)
            values = _floats(words[1 : count + 9], place)
            kept = _kept_beams(count, num_rays, field_of_view)
            scans.append(np.clip(np.asarray(values[1 : count + 1])[kept], 0.0, max_range))
            truths.append(values[count + 1 : count + 4])
            times.append(values[count + 7])
            last_odometry = None
        elif words[0] == "ODOM":
            if len(words) < 4:
                raise _short(place, "an ODOM row needs x, y and theta")
            odometry = _floats(words[1:4], place)
            if last_odometry is not None and scans:
                increments.append((last_odometry, odometry))
                intervals.append(len(scans) - 1)
            last_odometry = odometry
    if len(scans) < 2:
        raise UserError(
            f"the log holds {len(scans)} FLASER rows",
            where=path,
            remedy="at least two are needed",
        )
    used = np.asarray(intervals, int) < len(scans) - 1
    if not used.any():
        raise UserError(
            "the log holds no raw odometry: no two ODOM rows in a row between two scans",
            where=path,
            remedy="give a log with its ODOM rows",
        )
    pairs = np.asarray(increments, np.float64)
    return Recording(
        name=path.name,
        time=np.asarray(times),
        sensors=np.asarray(scans),
        increments=relative_poses(pairs[:, 0], pairs[:, 1])[used],
        interval=np.asarray(intervals, int)[used],
        poses=np.asarray(truths),
        sensor_scale=(max_range,) * num_rays,
        planar=True,
    )


def _rows(path: Path) -> Iterator[tuple[int, list[str]]]:
    """Numbered rows split into words, empty ones left out."""
    number = 0
    try:
        with gzip.open(path, "rt") if path.suffix == ".gz" else path.open() as lines:
            for number, line in enumerate(lines, start=1):
                if words := line.split():
                    yield number, words
    except EOFError:
        raise UserError(
            "the gzip file is cut off",
            where=f"{path}, after line {number}",
            remedy="copy it again",
        ) from None
    except (OSError, UnicodeDecodeError, zlib.error) as error:
        reason = getattr(error, "strerror", None) or "it is damaged or not text"
        raise UserError(
            f"the log cannot be read ({reason})",
            where=path,
            remedy="check the path and the file",
        ) from None


def _beams(words: list[str], place: str) -> int:
    """The number of beams of a FLASER row that is long enough."""
    count = _floats(words[1:2], place)
    if not count or count[0] < 1 or count[0] != int(count[0]):
        raise _short(place, "a FLASER row begins with its number of beams")
    # After the beams: the corrected pose, the odometry pose, and a time stamp.
    if len(words) < count[0] + 9:
        raise _short(place, f"a FLASER row of {int(count[0])} beams ends after {len(words)} words")
    return int(count[0])


def _floats(words: list[str], place: str) -> list[float]:
    values = []
    for word in words:
        try:
            value = float(word)
        except ValueError:
            value = math.nan
        if not math.isfinite(value):
            raise UserError(
                f"{word!r} is not a number", where=place, remedy="mend or leave out the row"
            )
        values.append(value)
    return values


def _kept_beams(count: int, num_rays: int, field_of_view: float) -> np.ndarray:
    half = min(field_of_view / math.pi, 1.0) / 2
    return np.round((count - 1) * np.linspace(0.5 - half, 0.5 + half, num_rays)).astype(int)


def _short(place: str, what: str) -> UserError:
    return UserError(what, where=place, remedy="mend or leave out the row")
