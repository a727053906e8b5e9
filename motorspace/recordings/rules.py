"""Rules that leave intervals of a log out of all transitions: by motors, time stamps and poses."""

from dataclasses import replace
from typing import Literal

import numpy as np
from jaxtyping import Bool, Float

from motorspace._errors import UserError
from motorspace.recordings.recording import Recording, chained_per_interval

Clock = Literal["check", "ignore"]

LATEST = 1e300
"""Later time stamps are not read; differences of earlier ones are finite."""

GAPS = 10.0
"""Gaps are longer than so many times the median time between scans."""
JUMPS = 10.0
"""Jumps are longer than so many times the step that three quarters of the steps do not exceed."""
CORRECTION = 0.5
"""Steps back in time of at most this share of the median are corrections of the clock."""


def leave_out(
    recording: Recording, *, max_gap: float | None, max_jump: float | None, clock: Clock
) -> Recording:
    """The recording with the intervals that are no transition marked as not usable.

    An interval counts for the first reason that applies: no motor command in it; a time stamp
    that cannot be read; time that runs backwards (by more than half the median time between
    scans: less is a correction of the clock) or stands still; more than `max_gap` seconds; a
    movement, by poses or by odometry, of more than `max_jump` world units.

    Args:
        recording: The log as it was read.
        max_gap: Seconds; None stands for 10 times the median time between scans.
        max_jump: World units; None stands for 10 times the upper quartile of all steps.
        clock: "ignore" leaves nothing out because of its time stamps.

    Returns:
        The same recording but for `usable`, unreadable time stamps (NaN), and a note that counts
        every reason.
    """
    readable = np.abs(recording.time) < LATEST
    recording = replace(recording, time=np.where(readable, recording.time, np.nan))
    left = ~recording.usable
    reasons = [f"{left.sum()} with values missing"] * bool(left.any())
    notes = list(recording.notes)
    checks = [("without a motor command", _without_command(recording))]
    if clock == "check":
        checks += _by_clock(recording, max_gap, notes)
    checks.append(("that jump in position", _jumps(recording, max_jump)))
    for reason, found in checks:
        new = found & ~left
        left = left | found
        if new.any():
            reasons.append(f"{new.sum()} {reason} (first after scan {int(np.argmax(new))})")
    if reasons:
        notes.append(
            f"left out: {left.sum()} of {len(left)} intervals between scans: " + ", ".join(reasons)
        )
    return replace(recording, usable=~left, notes=tuple(notes), judged=True)


def refuse_overflow(recording: Recording, *, where: object) -> None:
    """Raise `UserError` for values that do not fit into the 32 bits that learning uses."""
    largest = float(np.finfo(np.float32).max)
    for what in ("sensors", "increments", "poses"):
        values = np.abs(getattr(recording, what))
        if (values > largest).any():
            raise UserError(
                f"the {what} hold {np.nanmax(values):.3g}, too large for 32-bit numbers",
                where=where,
                remedy="correct the value, or choose a larger unit",
            )


def _without_command(recording: Recording) -> Bool[np.ndarray, " I"]:
    return np.bincount(recording.interval, minlength=len(recording) - 1) == 0


def _by_clock(
    recording: Recording, max_gap: float | None, notes: list[str]
) -> list[tuple[str, Bool[np.ndarray, " I"]]]:
    """What is left out because of its time stamps; notes on what is not."""
    seconds = np.diff(recording.time)
    known = np.isfinite(seconds)
    moving = np.abs(seconds[known & (seconds != 0)])
    if not len(moving):
        notes.append("the time stamps do not change or cannot be read, so gaps cannot be found")
        return []
    median = float(np.quantile(moving, 0.5, method="lower"))
    still = known & (seconds == 0)
    if still.sum() > len(seconds) / 2:
        notes.append(
            f"{still.sum()} of {len(seconds)} intervals begin and end at one time stamp: the clock "
            "is too coarse to find repeated scans"
        )
        still = np.zeros_like(still)
    corrected = known & (seconds < 0) & (seconds >= -CORRECTION * median)
    if corrected.any():
        notes.append(
            f"the clock steps back {corrected.sum()} times by at most half the usual interval "
            f"({-seconds[corrected].min():.6g} s): kept as corrections of the clock"
        )
    longest = GAPS * median if max_gap is None else max_gap
    gaps = known & (seconds > longest)
    gap = f"longer than {longest:.6g} s"
    if gaps.any():
        gap += f", up to {seconds[gaps].max():.6g} s"
    return [
        ("whose time stamps cannot be read", ~known),
        ("where time runs backwards", known & (seconds < 0) & ~corrected),
        ("where time stands still", still),
        (gap, gaps),
    ]


def _jumps(recording: Recording, max_jump: float | None) -> Bool[np.ndarray, " I"]:
    """Movements, by poses or by planar odometry, that are longer than any robot's."""
    steps = [np.hypot(*np.diff(recording.poses[:, :2], axis=0).T)]
    if recording.planar:
        steps.append(np.hypot(*chained_per_interval(recording)[:, :2].T))
    found = np.zeros(len(recording) - 1, bool)
    for lengths in steps:
        # Comparisons with NaN are false: an unknown pose is no jump.
        found |= lengths > (_plausible(lengths) if max_jump is None else max_jump)
    return found


def _plausible(lengths: Float[np.ndarray, " I"]) -> float:
    moving = lengths[np.isfinite(lengths) & (lengths > 0)]
    if len(moving) < 3:
        return np.inf
    return JUMPS * float(np.quantile(moving, 0.75, method="lower"))
