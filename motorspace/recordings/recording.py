"""One robot's log, whatever its format, and the transitions that it holds."""

from dataclasses import dataclass
from typing import Any

import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Float, Int

from motorspace._errors import UserError
from motorspace._types import Key
from motorspace.trajectories.transitions import Displacements, Experience, Trajectories


@dataclass(frozen=True)
class Recording:
    """N scans and the raw motor increments executed between them.

    `sensors` in the log's own unit; `increments` in order of time, `interval[l]` = i when
    increment l happened between scans i and i + 1. `poses` (x, y, heading; NaN where unknown)
    are for evaluation alone. `planar` says that increments are (longitudinal, lateral,
    rotation) in the robot's frame, so that they can be chained.
    """

    name: str
    time: Float[np.ndarray, " N"]
    sensors: Float[np.ndarray, "N K"]
    increments: Float[np.ndarray, "L M"]
    interval: Int[np.ndarray, " L"]
    poses: Float[np.ndarray, "N 3"]
    sensor_scale: tuple[float, ...]
    planar: bool

    def __len__(self) -> int:
        return len(self.sensors)


def windows(recording: Recording, *, horizon_scans: int, per_scan: bool) -> Trajectories:
    """Every transition from scan i to scan i + `horizon_scans`, in order of i.

    With `per_scan` the increments of each interval are chained into one command, so that
    T = `horizon_scans`; without, the sequence holds every raw increment and is padded with
    zeros beyond its own length. The nominal displacement is what the chained increments
    claim (NaN unless planar), the achieved one what the true poses say.

    Raises `UserError` when the recording is shorter than one transition.
    """
    num = len(recording) - horizon_scans
    if horizon_scans < 1 or num < 1:
        raise UserError(
            f"{len(recording)} scans hold no transition over {horizon_scans} scans",
            where=recording.name,
            remedy="give a longer log or a shorter horizon",
        )
    if per_scan:
        recording = _one_command_per_interval(recording)
    first = np.searchsorted(recording.interval, np.arange(num))
    last = np.searchsorted(recording.interval, np.arange(num) + horizon_scans)
    lengths = last - first
    horizon = max(int(lengths.max()), 1)
    rows = first[:, None] + np.arange(horizon)
    executed = np.arange(horizon) < lengths[:, None]
    padded = np.concatenate([recording.increments, np.zeros((horizon + 1, _size(recording)))])
    motors = np.where(executed[..., None], padded[np.minimum(rows, len(padded) - 1)], 0.0)
    experience = Experience(
        sensors=jnp.asarray(recording.sensors[:num], jnp.float32),
        motors=jnp.asarray(motors, jnp.float32),
        num_steps=jnp.asarray(lengths, jnp.int32),
        later_sensors=jnp.asarray(recording.sensors[horizon_scans:], jnp.float32),
    )
    achieved = relative_poses(recording.poses[:num], recording.poses[horizon_scans:])
    nominal = chained(motors) if recording.planar else np.full_like(achieved, np.nan)
    return Trajectories(
        experience,
        Displacements(jnp.asarray(nominal, jnp.float32), jnp.asarray(achieved, jnp.float32)),
    )


def split_blocks(
    recording: Recording,
    *,
    horizon: int,
    num_blocks: int,
    fractions: tuple[float, float, float] = (0.6, 0.2, 0.2),
    key: Key,
) -> tuple[Int[np.ndarray, " A"], Int[np.ndarray, " B"], Int[np.ndarray, " C"]]:
    """Transitions for training, validation and test, by their first scan.

    The recording is cut into `num_blocks` blocks of time, which are dealt out at random; a
    transition that crosses a border is left out, so that no scan is seen on both sides.
    """
    borders = np.linspace(0, len(recording), num_blocks + 1).astype(int)
    order = np.asarray(jax.random.permutation(key, num_blocks))
    cuts = np.round(np.cumsum(fractions)[:2] * num_blocks).astype(int)
    parts = []
    for blocks in np.split(order, cuts):
        starts = [np.arange(borders[b], borders[b + 1] - horizon) for b in sorted(blocks)]
        parts.append(np.concatenate(starts) if starts else np.arange(0))
    if min(len(part) for part in parts) == 0:
        raise UserError(
            f"{len(recording)} scans are too few for {num_blocks} blocks over {horizon} scans",
            where=recording.name,
            remedy="give a longer log",
        )
    return parts[0], parts[1], parts[2]


def describe(recording: Recording) -> dict[str, Any]:
    """What a person wants to know of a log before learning from it."""
    limit = np.asarray(recording.sensor_scale)
    per_interval = np.bincount(recording.interval, minlength=len(recording) - 1)
    described: dict[str, Any] = {
        "name": recording.name,
        "scans": len(recording),
        "duration in seconds": float(recording.time[-1] - recording.time[0]),
        "sensors per scan": recording.sensors.shape[1],
        "sensor range": [float(recording.sensors.min()), float(recording.sensors.max())],
        "share of sensors at their limit": float((recording.sensors >= limit).mean()),
        "motor increments": len(recording.increments),
        "increments per interval (median)": float(np.median(per_interval)),
        "increments, smallest": recording.increments.min(axis=0).round(4).tolist(),
        "increments, largest": recording.increments.max(axis=0).round(4).tolist(),
    }
    if np.isfinite(recording.poses).all():
        steps = np.diff(recording.poses[:, :2], axis=0)
        described["path length"] = float(np.hypot(*steps.T).sum())
        described["step between scans (median)"] = float(np.median(np.hypot(*steps.T)))
        if recording.planar:
            described["drift of chained increments at the end"] = end_drift(recording)
    return described


def end_drift(recording: Recording) -> float:
    """Distance from the last true position to where the chained increments end."""
    x, y, heading = recording.poses[0]
    dx, dy, _ = chained(recording.increments[None])[0]
    cos, sin = np.cos(heading), np.sin(heading)
    end = np.array([x + cos * dx - sin * dy, y + sin * dx + cos * dy])
    return float(np.hypot(*(end - recording.poses[-1, :2])))


def chained(increments: Float[np.ndarray, "N T 3"]) -> Float[np.ndarray, "N 3"]:
    """The displacement after T planar increments in a row."""
    headings = np.cumsum(increments[..., 2], axis=-1)
    before = headings - increments[..., 2]
    cos, sin = np.cos(before), np.sin(before)
    dx, dy = increments[..., 0], increments[..., 1]
    return np.stack(
        [
            (cos * dx - sin * dy).sum(-1),
            (sin * dx + cos * dy).sum(-1),
            wrapped(increments[..., 2].sum(-1)),
        ],
        axis=-1,
    )


def relative_poses(
    start: Float[np.ndarray, "N 3"], end: Float[np.ndarray, "N 3"]
) -> Float[np.ndarray, "N 3"]:
    """Displacements from poses to poses, in the frame of the first."""
    dx, dy = (end - start)[:, :2].T
    cos, sin = np.cos(start[:, 2]), np.sin(start[:, 2])
    turn = wrapped(end[:, 2] - start[:, 2])
    return np.stack([cos * dx + sin * dy, cos * dy - sin * dx, turn], axis=-1)


def wrapped(angle: Float[np.ndarray, "*batch"]) -> Float[np.ndarray, "*batch"]:
    """The same angle in (-pi, pi]."""
    return np.pi - np.mod(np.pi - angle, 2 * np.pi)


def _size(recording: Recording) -> int:
    return recording.increments.shape[1]


def _one_command_per_interval(recording: Recording) -> Recording:
    """The recording with the increments of each interval chained (or summed) into one."""
    num = len(recording) - 1
    first = np.searchsorted(recording.interval, np.arange(num))
    last = np.searchsorted(recording.interval, np.arange(num) + 1)
    commands = np.zeros((num, _size(recording)))
    for index, (a, b) in enumerate(zip(first, last, strict=True)):
        part = recording.increments[a:b]
        commands[index] = chained(part[None])[0] if recording.planar else part.sum(axis=0)
    return Recording(
        recording.name,
        recording.time,
        recording.sensors,
        commands,
        np.arange(num),
        recording.poses,
        recording.sensor_scale,
        recording.planar,
    )
