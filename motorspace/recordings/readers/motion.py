"""Where a robot was at the times of its scans, by odometry, by commands or by its wheels."""

from typing import NamedTuple

import numpy as np
from jaxtyping import Bool, Float, Int

from motorspace import se2

LACKING = 5.0
"""Odometry is missing where it pauses for more than so many times its usual interval."""


class Motion(NamedTuple):
    """Poses of a body in one frame, in order of time."""

    time: Float[np.ndarray, " P"]
    pose: Float[np.ndarray, "P 3"]


def driven(steps: Float[np.ndarray, "J 3"]) -> Float[np.ndarray, "P 3"]:
    """The poses before, between and after arcs, from (0, 0, 0) on.

    Args:
        steps: Of each arc the way ahead, the way to the left and the rotation, all three at
            constant speed and at once.
    """
    ahead, left, turn = steps.T
    # Along an arc the mean direction is turned by half the angle, and the chord is shorter.
    chord = np.sinc(turn / (2 * np.pi))
    before = np.concatenate([[0.0], np.cumsum(turn)])
    cos, sin = np.cos(before[:-1] + turn / 2), np.sin(before[:-1] + turn / 2)
    moved = chord * np.stack([cos * ahead - sin * left, sin * ahead + cos * left])
    places = np.concatenate([np.zeros((1, 2)), np.cumsum(moved.T, axis=0)])
    return np.column_stack([places, before])


def commanded(
    time: Float[np.ndarray, " C"],
    velocity: Float[np.ndarray, "C 3"],
    also: Float[np.ndarray, " N"],
    *,
    timeout: float | None,
) -> Motion:
    """The motion by commands, each of which is executed until the next one.

    Args:
        time: When each command was given, seconds, in order.
        velocity: Ahead, to the left, and rotation, per second.
        also: Further times at which the pose is wanted.
        timeout: Seconds after which a robot that hears nothing stands still; None for never.
    """
    ends = time[:0] if timeout is None else time + timeout
    moments = np.unique(np.concatenate([time, also, ends]))
    moments = moments[moments >= time[0]]
    given = np.searchsorted(time, moments[:-1], side="right") - 1
    active = np.ones(len(given), bool)
    if timeout is not None:
        active = moments[:-1] < time[given] + timeout
    seconds = np.diff(moments)[:, None]
    return Motion(moments, driven(np.where(active[:, None], velocity[given] * seconds, 0.0)))


def interpolated(motion: Motion, time: Float[np.ndarray, " N"]) -> Float[np.ndarray, "N 3"]:
    """Where the body was at other times; beyond the first and the last pose, these."""
    after = np.clip(np.searchsorted(motion.time, time), 1, len(motion.time) - 1)
    start, end = motion.pose[after - 1].T, motion.pose[after].T
    seconds = motion.time[after] - motion.time[after - 1]
    share = np.clip((time - motion.time[after - 1]) / seconds, 0.0, 1.0)
    return se2.compose(start, share * se2.relative(start, end)).T


def pauses(motion: Motion, scans: Float[np.ndarray, " N"]) -> tuple[tuple[float, float], ...]:
    """From when to when the odometry is missing, so that poses in between would be invented."""
    seconds = np.diff(motion.time)
    usual = float(np.median(seconds))
    between = float(np.median(np.diff(scans))) if len(scans) > 1 else 0.0
    found = np.flatnonzero(seconds > max(LACKING * usual, 2 * between))
    return tuple((float(motion.time[i]), float(motion.time[i + 1])) for i in found)


def ordered(time: Float[np.ndarray, " P"]) -> tuple[Int[np.ndarray, " Q"], int, int]:
    """The positions of times in order, each time once; how many were late, how many repeated."""
    order = np.argsort(time, kind="stable")
    late = int((np.diff(time) < 0).sum())
    new: Bool[np.ndarray, " P"] = np.diff(time[order], prepend=-np.inf) > 0
    return order[new], late, int((~new).sum())
