"""A walk through time, simulated or read from a robot's log."""

import math
from dataclasses import dataclass
from typing import Any

import numpy as np
from jaxtyping import Bool, Float, Int

from motorspace import se2
from motorspace._errors import UserError


@dataclass(frozen=True)
class Recording:
    """N scans, the motor commands between them, and what evaluation may know.

    `increments` stand in order of time; `interval[l]` = i when command l was executed between
    scans i and i + 1. Commands are executed from one scan to the next, so none follow the last.
    """

    name: str
    """Where the walk is from: the file's name, or the scenario."""
    time: Float[np.ndarray, " N"]
    """Seconds; NaN where the log's own time stamp cannot be read."""
    sensors: Float[np.ndarray, "N K"]
    """Readings in the log's own unit; all finite."""
    increments: Float[np.ndarray, "L M"]
    """Motor commands, or increments of the robot's own odometry."""
    interval: Int[np.ndarray, " L"]
    """The scan before each command; sorted."""
    poses: Float[np.ndarray, "N 4"]
    """(x, y, heading, head): world units and radians, NaN where unknown. For evaluation alone."""
    sensor_scale: tuple[float, ...]
    """Largest magnitude of each sensor."""
    planar: bool
    """Whether increments are (longitudinal, lateral, rotation) in the robot's own frame."""
    usable: Bool[np.ndarray, " N-1"]
    """Whether transitions may go from scan i to scan i + 1."""
    odometry_poses: bool = False
    """Whether `poses` are where odometry leads, because the true ones are unknown."""
    judged: bool = False
    """Whether the rules that leave intervals out have been applied already."""
    notes: tuple[str, ...] = ()
    """What a person should know before learning from it, a sentence each."""
    shape: tuple[int, ...] = ()
    """How the K channels are arranged, for instance (height, width, 3); [K] where it is empty."""

    def __post_init__(self) -> None:
        object.__setattr__(self, "sensor_scale", tuple(map(float, self.sensor_scale)))
        object.__setattr__(self, "shape", tuple(map(int, self.shape)))
        channels = self.sensors.shape[1]
        if self.shape and math.prod(self.shape) != channels:
            raise UserError(
                f"{channels} channels cannot be arranged as {self.shape}", where=self.name
            )

    def __len__(self) -> int:
        return len(self.sensors)


def sensor_frames(recording: Recording) -> Float[np.ndarray, "3 N"]:
    """Where the sensors are at every scan, and which way they look: x, y, heading + head."""
    x, y, heading, head = recording.poses.T
    return np.stack([x, y, heading + head])


def transition_starts(recording: Recording, horizon: int) -> Int[np.ndarray, " W"]:
    """The first scan of every transition that goes through usable intervals alone.

    Args:
        recording: The walk.
        horizon: Scans from the first reading of a transition to the later one.

    Raises:
        UserError: There is none.
    """
    num = len(recording) - horizon
    if horizon < 1 or num < 1:
        raise UserError(
            f"{len(recording)} scans hold no transition over {horizon} scans",
            where=recording.name,
            remedy="give a longer log, or a horizon of at least 1 and below the number of scans",
        )
    left_out = np.concatenate([[0], np.cumsum(~recording.usable)])
    starts = np.flatnonzero(left_out[horizon:] == left_out[:num])
    if not len(starts):
        raise UserError(
            f"no transition over {horizon} scans is left: {left_out[-1]} of "
            f"{len(recording) - 1} intervals between scans are left out",
            where=recording.name,
            remedy="see why with `motorspace inspect`"
            + ", or choose a shorter horizon" * bool(recording.usable.any()),
        )
    return starts


def describe(recording: Recording) -> dict[str, Any]:
    """What a person wants to know of a log before learning from it.

    Args:
        recording: The log, or a simulated walk.

    Returns:
        Sizes, ranges and lengths by plain titles, JSON-able; world units, radians, seconds. Path
        and drift where every true pose is known. Last the recording's notes.
    """
    at_limit = recording.sensors >= np.asarray(recording.sensor_scale)
    per_interval = np.bincount(recording.interval, minlength=len(recording) - 1)
    seconds = np.diff(recording.time)[recording.usable]
    described: dict[str, Any] = {
        "name": recording.name,
        "scans": len(recording),
        "duration in seconds": float(np.nansum(seconds)),
        **_described_clock(recording),
        "sensors per scan": recording.sensors.shape[1],
        "sensor range": [float(recording.sensors.min()), float(recording.sensors.max())],
        "share of sensors at their limit": float(at_limit.mean()),
        "motor increments": len(recording.increments),
        "increments per interval (median)": float(np.median(per_interval)),
        "increments, smallest": _rounded(recording.increments, np.min),
        "increments, largest": _rounded(recording.increments, np.max),
        "intervals left out": int((~recording.usable).sum()),
    }
    return described | _described_path(recording) | {"notes": list(recording.notes)}


def _described_clock(recording: Recording) -> dict[str, float]:
    """Rate and longest gap, where time goes on."""
    seconds = np.diff(recording.time)
    seconds = seconds[np.isfinite(seconds) & (seconds > 0)]
    if not len(seconds):
        return {}
    return {
        "scans per second (median)": float(1 / np.median(seconds)),
        "longest time between scans in seconds": float(seconds.max()),
    }


def path_by_increments(recording: Recording) -> Float[np.ndarray, "N 3"]:
    """Where the planar increments alone lead, scan by scan: x, y, angle from (0, 0, 0) on."""
    steps = chained_per_interval(recording)
    before = np.concatenate([[0.0], np.cumsum(steps[:, 2])])
    cos, sin = np.cos(before[:-1]), np.sin(before[:-1])
    dx, dy, _ = steps.T
    moved = np.stack([cos * dx - sin * dy, sin * dx + cos * dy], axis=-1)
    return np.column_stack([np.concatenate([[[0.0, 0.0]], np.cumsum(moved, axis=0)]), before])


def _rounded(values: Float[np.ndarray, "L M"], of: Any) -> list[float]:
    found: list[float] = of(values, axis=0).round(4).tolist() if len(values) else []
    return found


def _described_path(recording: Recording) -> dict[str, float]:
    """Length, step and drift, where every true pose is known."""
    if not np.isfinite(recording.poses).all():
        return {}
    steps = np.hypot(*np.diff(recording.poses[:, :2], axis=0).T)[recording.usable]
    if not len(steps):
        return {}
    described = {
        "path length": float(steps.sum()),
        "step between scans (median)": float(np.median(steps)),
    }
    if recording.planar and recording.usable.all() and not recording.odometry_poses:
        described["drift of chained increments at the end"] = end_drift(recording)
    return described


def end_drift(recording: Recording) -> float:
    """Distance from the last true position to where the chained increments end, world units."""
    moved = se2.chain(recording.increments)
    end = se2.compose(recording.poses[0, :3], moved)
    return float(np.hypot(*(end[:2] - recording.poses[-1, :2])))


def chained_per_interval(recording: Recording) -> Float[np.ndarray, "I M"]:
    """One command for each of the N - 1 intervals: its increments chained, or summed."""
    num = len(recording) - 1
    borders = np.searchsorted(recording.interval, np.arange(num + 1))
    commands = np.zeros((num, recording.increments.shape[1]))
    for index in range(num):
        part = recording.increments[borders[index] : borders[index + 1]]
        commands[index] = se2.chain(part) if recording.planar else part.sum(axis=0)
    return commands
