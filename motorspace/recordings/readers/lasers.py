"""From rows of odometry and laser scans to a recording, whatever format they were written in."""

import abc
import math
from collections import Counter
from dataclasses import dataclass, field
from pathlib import Path
from typing import NamedTuple

import numpy as np
from jaxtyping import Bool, Float

from motorspace import se2
from motorspace._errors import UserError
from motorspace.recordings.readers.base import AbstractReader
from motorspace.recordings.readers.faults import Faults
from motorspace.recordings.readers.odometry import (
    Frame,
    Increments,
    Track,
    across_scans,
    in_order,
    is_one_frame,
    within_scans,
)
from motorspace.recordings.readers.ranges import (
    Beams,
    Invalid,
    Reading,
    interpret,
    kept_beams,
)
from motorspace.recordings.recording import Recording

Place = tuple[float, float, float]
"""(x, y, angle): world units and radians; NaN where unknown."""

NEEDS = "give a log with its rows of odometry"

NOWHERE: Place = (math.nan, math.nan, math.nan)


class Odometry(NamedTuple):
    """One row of the robot's own odometry."""

    pose: Place
    time: float


class Scan(NamedTuple):
    """One laser scan."""

    beams: Beams
    pose: Place
    """Where the laser is: corrected by whoever made the log, or by odometry."""
    odometry: Place
    """Where the robot is by odometry, as the row of the scan has it."""
    time: float
    limit: float = math.inf
    """The scan's own maximum range."""


class Log(NamedTuple):
    """The rows of a log that are read, in order, and notes on the others."""

    rows: list[Odometry | Scan]
    notes: list[str]
    gaps: tuple[tuple[float, float], ...] = ()
    """From when to when the motion is unknown: no transition goes through it."""


class Moved(NamedTuple):
    """How the robot moved."""

    increments: Increments
    poses: Float[np.ndarray, "N 3"]
    """Of every scan: true ones, or those of the odometry."""
    poses_known: bool
    """Whether they are true."""


@dataclass(frozen=True)
class LaserReader(AbstractReader):
    """Reads logs of laser scans and odometry; a format says how its rows are written."""

    num_rays: int = 9
    """Laser beams that are kept, evenly spread over the field of view; 1 looks straight ahead."""
    field_of_view: float = field(default=math.pi, metadata={"in_pi": True, "positive": True})
    """Angle that the kept beams span, at most what the laser sees."""
    max_range: float = field(default=10.0, metadata={"positive": True})
    """Longest distance; readings at or beyond it mean no return and become it, world units."""
    invalid: Invalid = "max_range"
    """Readings below 0 or not a number: max_range takes them as no return, leave_out leaves out
    the transitions of their scans, refuse refuses the log."""
    skip_bad: bool = False
    """Leave broken rows and messages out and count them, instead of refusing the log."""

    def __post_init__(self) -> None:
        super().__post_init__()
        if self.num_rays < 1:
            raise UserError(f"num_rays must be at least 1, got {self.num_rays}")

    @abc.abstractmethod
    def parse_rows(self, path: Path, faults: Faults) -> Log:
        """The rows of the file, in order of time, each with its pose by odometry.

        Faults go to `faults`, which raises `UserError` for them or counts them.
        """

    def parse(self, path: Path) -> Recording:
        """The scans and raw odometry increments. World units, radians, seconds."""
        faults = Faults(self.skip_bad)
        rows, notes, gaps = self.parse_rows(path, faults)
        notes = [*notes, *faults.notes()]
        scans = [row for row in rows if isinstance(row, Scan)]
        if len(scans) < 2:
            raise UserError(
                f"the log holds {len(scans)} scans",
                where=path,
                remedy="at least two are needed" + "".join(f" ({note})" for note in notes),
            )
        time = np.array([scan.time for scan in scans])
        if np.isnan(time).all():
            time = np.arange(len(scans), dtype=float)
            notes.append("the scans have no time stamps: they are numbered instead")
        moved = self._motion(rows, time, notes, where=path)
        sensed = self._sensed(scans, notes, where=path)
        refused = sensed.invalid & (self.invalid == "leave_out")
        return Recording(
            name=path.name,
            time=time,
            sensors=sensed.sensors,
            increments=moved.increments.values,
            interval=moved.increments.interval,
            poses=np.concatenate([moved.poses, np.zeros((len(scans), 1))], axis=1),
            odometry_poses=not moved.poses_known,
            sensor_scale=(sensed.limit,) * self.num_rays,
            planar=True,
            usable=~(refused[:-1] | refused[1:] | _within(gaps, time, notes)),
            notes=(*notes, *sensed.notes),
        )

    def _sensed(self, scans: list[Scan], notes: list[str], *, where: object) -> Reading:
        counts = Counter(len(scan.beams.ranges) for scan in scans)
        if len(counts) > 1:
            found = ", ".join(f"{beams} in {times} scans" for beams, times in counts.most_common(4))
            notes.append(
                f"the number of beams varies ({found}): each scan's rays are chosen by their angle"
            )
        if (fewest := min(counts)) < self.num_rays:
            notes.append(f"scans of {fewest} beams: some stand for more than one ray")
        raw = np.empty((len(scans), self.num_rays))
        for index, (beams, *_) in enumerate(scans):
            raw[index] = beams.ranges[kept_beams(beams, self.num_rays, self.field_of_view)]
        limits = np.array([scan.limit for scan in scans])
        return interpret(raw, limits, max_range=self.max_range, invalid=self.invalid, where=where)

    def _motion(
        self,
        rows: list[Odometry | Scan],
        time: Float[np.ndarray, " N"],
        notes: list[str],
        *,
        where: object,
    ) -> Moved:
        """The raw increments, and the true poses as far as they are known."""
        track, poses = _track(rows, time)
        return _raw(in_order(track), poses, track, notes)


@dataclass(frozen=True)
class FramedReader(LaserReader):
    """Reads logs whose poses may be raw or corrected, and whose scans may stand late."""

    odometry: Frame = "auto"
    """raw: all poses are in one frame, that of the odometry; corrected: the frame starts anew at
    every scan; auto: as the data say."""

    def _motion(
        self,
        rows: list[Odometry | Scan],
        time: Float[np.ndarray, " N"],
        notes: list[str],
        *,
        where: object,
    ) -> Moved:
        track, poses = _track(rows, time)
        if self._is_raw(track, poses):
            if track.scan.all() and np.isnan(track.pose).any():
                raise UserError(
                    "scans have no poses, and there is no odometry", where=where, remedy=NEEDS
                )
            return _raw(across_scans(track), poses, track, notes)
        increments = within_scans(track)
        if not len(increments.values):
            raise UserError(
                "the log holds no raw odometry: no two ODOM rows in a row between two scans",
                where=where,
                remedy=f"{NEEDS}, or set odometry to raw if the scans' poses are not corrected",
            )
        notes.append("corrected log; increments are taken between scans, never across one")
        return Moved(increments, poses, poses_known=True)

    def _is_raw(self, track: Track, poses: Float[np.ndarray, "N 3"]) -> bool:
        if self.odometry != "auto":
            return self.odometry == "raw"
        if track.scan.all():
            return _independent(track.pose, poses)
        return is_one_frame(track)


def _track(
    rows: list[Odometry | Scan], time: Float[np.ndarray, " N"]
) -> tuple[Track, Float[np.ndarray, "N 3"]]:
    """The rows as arrays, and the scans' own poses."""
    is_scan = np.array([isinstance(row, Scan) for row in rows])
    times = np.array([row.time for row in rows])
    times[is_scan] = time
    own = [row.odometry if isinstance(row, Scan) else row.pose for row in rows]
    poses = [row.pose for row in rows if isinstance(row, Scan)]
    return Track(np.array(own, float), times, is_scan), np.array(poses, float)


def _raw(
    moved: tuple[Increments, Float[np.ndarray, "N 3"]],
    poses: Float[np.ndarray, "N 3"],
    track: Track,
    notes: list[str],
) -> Moved:
    """Increments of raw odometry; its poses stand for the true ones where these are unknown."""
    increments, by_odometry = moved
    independent = _independent(track.pose[track.scan], poses)
    if not independent:
        notes.append("raw odometry; true poses are unknown, the odometry stands for them")
    complete = independent or np.isfinite(poses).all()
    return Moved(increments, poses if complete else by_odometry, poses_known=independent)


def _within(
    gaps: tuple[tuple[float, float], ...], time: Float[np.ndarray, " N"], notes: list[str]
) -> Bool[np.ndarray, " N-1"]:
    """The intervals between scans that share time with one of the gaps."""
    found = np.zeros(len(time) - 1, bool)
    gaps = tuple((start, end) for start, end in gaps if start < time[-1] and end > time[0])
    for start, end in gaps:
        found |= (time[:-1] < end) & (time[1:] > start)
    if gaps:
        longest = max(end - start for start, end in gaps)
        notes.append(
            f"the odometry is missing {len(gaps)} times, for up to {longest:.6g} s: "
            f"{found.sum()} intervals between scans are left out"
        )
    return found


def _independent(odometry: Float[np.ndarray, "N 3"], poses: Float[np.ndarray, "N 3"]) -> bool:
    """Whether the poses differ from the odometry by more than the constant offset of the laser."""
    known = np.isfinite(odometry).all(axis=1) & np.isfinite(poses).all(axis=1)
    if known.sum() < 2:
        return False
    odometry, poses = odometry[known], poses[known]
    offset = se2.relative(odometry.T, poses.T)
    spread = np.ptp(offset[:2], axis=1).max() + np.ptp(np.cos(offset[2]))
    return bool(spread > 0.01 + 1e-3 * np.ptp(odometry[:, :2], axis=0).max())
