"""Raw increments from the odometry and the scans of a log, in one frame or in many.

In a raw log all poses are in the one frame of the odometry. In a corrected log the pose of a scan
is corrected, and the odometry after it starts anew from there: a difference across a scan would
hold the correction. The data say which it is: between two neighbouring rows of odometry with a scan
in between, a raw log moves on as it does elsewhere, a corrected one jumps.
"""

from typing import Literal, NamedTuple

import numpy as np
from jaxtyping import Bool, Float, Int

from motorspace import se2

Frame = Literal["auto", "raw", "corrected"]

FASTER = 3.0
"""A jump is faster than so many times the 90th percentile of the robot's speed."""
OFF_COURSE = 0.15
"""Without other evidence, a jump leaves the course by more than this share of the last step."""
LATE = np.arange(-8, 3)
"""Steps of odometry, counted from where a scan stands in the log, in which it may have been taken:
logs write a scan when it has arrived."""
DETOUR = 0.02
"""A scan's pose is on the way if it makes a step longer by at most this share."""


class Track(NamedTuple):
    """Rows of odometry and scans, in the order of the log."""

    pose: Float[np.ndarray, "E 3"]
    """(x, y, angle) by odometry; for scans what their rows say of it, NaN where they do not."""
    time: Float[np.ndarray, " E"]
    scan: Bool[np.ndarray, " E"]
    """Whether it is a scan."""


class Increments(NamedTuple):
    """Movements by odometry, and the scan before each."""

    values: Float[np.ndarray, "L 3"]
    interval: Int[np.ndarray, " L"]


def within_scans(track: Track) -> Increments:
    """Differences of neighbouring rows of odometry, never across a scan."""
    after, odometry = _after(track), track.pose[~track.scan]
    pairs = np.flatnonzero(after[1:] == after[:-1])
    pairs = pairs[(after[pairs] >= 0) & (after[pairs] < track.scan.sum() - 1)]
    return Increments(se2.relative(odometry[pairs].T, odometry[pairs + 1].T).T, after[pairs])


def across_scans(track: Track) -> tuple[Increments, Float[np.ndarray, "N 3"]]:
    """Differences along all rows, through the scans' own poses; and those poses.

    A scan belongs where its row's pose lies on the way of the odometry. Where most do not, or have
    none, the pose is interpolated by time between the rows before and after.
    """
    step, on_the_way = _places(track)
    pose, order = track.pose.copy(), np.arange(len(track.pose))
    unknown = track.scan & np.isnan(pose).any(axis=1)
    if on_the_way.mean() > 0.5:
        order = _order(track, step)
    else:
        unknown = track.scan
    if unknown.any():
        pose[unknown] = _interpolated(track)[unknown[track.scan]]
    return _chained(pose[order], track.scan[order]), pose[track.scan]


def in_order(track: Track) -> tuple[Increments, Float[np.ndarray, "N 3"]]:
    """Differences along rows that are in order and have all their poses; the scans' poses."""
    return _chained(track.pose, track.scan), track.pose[track.scan]


def _chained(chain: Float[np.ndarray, "E 3"], scan: Bool[np.ndarray, " E"]) -> Increments:
    """The movements from the first scan to the last, row by row."""
    first, last = np.flatnonzero(scan)[[0, -1]]
    interval = np.cumsum(scan)[first:last] - 1
    values = se2.relative(chain[first:last].T, chain[first + 1 : last + 1].T).T
    # A scan that repeats the odometry beside it adds nothing; one command an interval stays.
    at_scan = scan[first:last] | scan[first + 1 : last + 1]
    repeats = at_scan & (values == 0).all(axis=1)
    standing = np.bincount(interval, ~repeats)[interval] == 0
    kept = ~repeats | (standing & scan[first:last])
    return Increments(values[kept], interval[kept])


def is_one_frame(track: Track) -> bool:
    """Whether all poses are in the frame of the odometry, as far as the data tell.

    The frame jumps if most steps of odometry across a scan are faster than the robot drives
    elsewhere, or leave the course of the step before. Where too few steps have no scan in between
    to compare with, the poses of the scans must lie on the way of the odometry.
    """
    if np.isnan(track.pose[track.scan]).any(axis=1).all():
        return True
    across = np.diff(_after(track)) > 0
    if 2 * (~across).sum() < across.sum() or not across.any():
        between = _between(track)
        return bool(between.any()) and bool(_places(track)[1][between].mean() > 0.9)
    odometry = track.pose[~track.scan]
    steps = se2.relative(odometry[:-1].T, odometry[1:].T)[:2].T
    length = np.hypot(*steps.T)
    before = np.concatenate([[0.0], length[:-1]])
    moving = across & (np.maximum(length, before) > 1e-3 * _typical(length))
    if not moving.any():
        return True
    fast = _too_fast(track, length, across)
    off = _off_course(odometry, steps, across, forward=3.0 if fast is None else np.inf)
    jumps = off if fast is None else fast | off
    return bool(jumps[moving].mean() <= 0.5)


def _typical(length: Float[np.ndarray, " J"]) -> float:
    return float(np.median(length[length > 0])) if (length > 0).any() else 0.0


def _after(track: Track) -> Int[np.ndarray, " P"]:
    """Of each row of odometry the last scan before it; -1 where there is none."""
    return np.cumsum(track.scan)[~track.scan] - 1


def _too_fast(
    track: Track, length: Float[np.ndarray, " J"], across: Bool[np.ndarray, " J"]
) -> Bool[np.ndarray, " J"] | None:
    """Steps that are faster than the robot drives; None where the clock cannot be used."""
    seconds = np.diff(_odometry_time(track))
    usual = ~across & (length > 0)
    ticking = usual & (seconds > 0)
    if not usual.any() or ticking.sum() < 0.8 * usual.sum():
        return None
    speed = np.quantile(length[ticking] / seconds[ticking], 0.9)
    least = 1e-3 * length[usual].max()
    return across & (length > FASTER * speed * np.maximum(seconds, 0.0) + least)


def _odometry_time(track: Track) -> Float[np.ndarray, " P"]:
    """Times of the rows of odometry; one that repeats the pose of the scan before has its time."""
    after = _after(track)
    scans = np.flatnonzero(track.scan)[after]
    repeats = (track.pose[scans] == track.pose[~track.scan]).all(axis=1) & (after >= 0)
    return np.where(repeats, track.time[scans], track.time[~track.scan])


def _off_course(
    odometry: Float[np.ndarray, "P 3"],
    steps: Float[np.ndarray, "J 2"],
    across: Bool[np.ndarray, " J"],
    *,
    forward: float,
) -> Bool[np.ndarray, " J"]:
    """Steps that leave the direction of the step before, or go `forward` times as far."""
    last = -se2.relative(odometry[1:].T, odometry[:-1].T)[:2].T[:-1]
    square = (last**2).sum(axis=1)
    known = square > 0
    share = np.divide((steps[1:] * last).sum(axis=1), square, np.zeros_like(square), where=known)
    rest = np.hypot(*(steps[1:] - np.clip(share, 0, forward)[:, None] * last).T)
    off = np.divide(rest, np.sqrt(square), np.zeros_like(rest), where=known)
    usual = known & ~across[1:] & ~across[:-1]
    # Where two steps in a row have no scan between them, they say how straight the robot drives.
    limit = max(0.02, 3 * float(np.median(off[usual]))) if usual.any() else OFF_COURSE
    return np.concatenate([[False], across[1:] & ~across[:-1] & (off > limit)])


def _between(track: Track) -> Bool[np.ndarray, " N"]:
    """Whether each scan has odometry both before and after it."""
    odometry = np.flatnonzero(~track.scan)
    scans = np.flatnonzero(track.scan)
    return (scans > odometry[0]) & (scans < odometry[-1]) if len(odometry) else scans < 0


def _places(track: Track) -> tuple[Int[np.ndarray, " N"], Bool[np.ndarray, " N"]]:
    """The step of odometry in which each scan was taken, and whether its pose lies on the way."""
    odometry, own = track.pose[~track.scan, :2], track.pose[track.scan, :2]
    here = np.searchsorted(np.flatnonzero(~track.scan), np.flatnonzero(track.scan)) - 1
    if len(odometry) < 2:
        return here, np.full(len(own), not len(odometry))
    step = here[:, None] + LATE
    start, end = np.clip(step, 0, len(odometry) - 1), np.clip(step + 1, 0, len(odometry) - 1)
    direct = np.hypot(*np.moveaxis(odometry[end] - odometry[start], -1, 0))
    detour = -direct
    for ends in (start, end):
        detour = detour + np.hypot(*np.moveaxis(own[:, None] - odometry[ends], -1, 0))
    typical = _typical(np.hypot(*np.diff(odometry, axis=0).T))
    slack = DETOUR * np.maximum(direct, 0.1 * typical)
    detour[np.isnan(own).any(axis=1)] = np.where(LATE == 0, slack.max() * 2, np.inf)
    # Of equal ones the nearest to where the log has it.
    best = np.argmin(detour + 1e-6 * typical * np.abs(LATE), axis=1)
    scans = np.arange(len(own))
    return step[scans, best], detour[scans, best] <= slack[scans, best]


def _order(track: Track, step: Int[np.ndarray, " N"]) -> Int[np.ndarray, " E"]:
    """All rows, each scan moved into its step of the odometry; scans keep their order."""
    position = np.empty(len(track.scan))
    position[~track.scan] = np.arange((~track.scan).sum())
    position[track.scan] = np.maximum.accumulate(step) + 0.5
    return np.argsort(position, kind="stable")


def _interpolated(track: Track) -> Float[np.ndarray, "N 3"]:
    """Where the odometry was at the time of each scan."""
    rows, scans = np.flatnonzero(~track.scan), np.flatnonzero(track.scan)
    after = np.searchsorted(rows, scans)
    before, after = rows[np.maximum(after - 1, 0)], rows[np.minimum(after, len(rows) - 1)]
    seconds = track.time[after] - track.time[before]
    ticking = np.isfinite(seconds) & (seconds > 0)
    since = track.time[scans] - track.time[before]
    share = np.divide(since, seconds, np.zeros_like(since), where=ticking)
    share = np.clip(np.nan_to_num(share), 0.0, 1.0)
    moved = se2.relative(track.pose[before].T, track.pose[after].T)
    return se2.compose(track.pose[before].T, share * moved).T
