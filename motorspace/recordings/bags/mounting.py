"""How a laser is mounted on its robot, and where its beams point from there."""

import math
from collections.abc import Mapping
from typing import NamedTuple

import numpy as np

from motorspace.recordings.bags.messages import LaserScan, Located
from motorspace.recordings.readers.ranges import Beams

Quaternion = tuple[float, float, float, float]

DEEPEST = 32
"""Frames between a laser and the robot's body, at most."""


class Mount(NamedTuple):
    """The laser's direction on the robot."""

    yaw: float
    """From the robot's heading to the laser's, radians."""
    upright: bool = True
    """False where the laser hangs upside down, so that it turns the other way."""


def mount(
    frames: Mapping[tuple[str, str], Located], laser: str, bodies: tuple[str, ...]
) -> Mount | None:
    """How the laser's frame is turned in the first of the bodies that the transforms lead to.

    Args:
        frames: The transforms by (parent, child).
        laser: The frame of the scans.
        bodies: Frames of the robot's body.

    Returns:
        None where the transforms do not say.
    """
    parents = {child: (parent, found.rotation) for (parent, child), found in frames.items()}
    rotation, frame = (0.0, 0.0, 0.0, 1.0), laser
    for _ in range(DEEPEST):
        if frame in bodies:
            return _mount(rotation)
        if frame not in parents:
            break
        frame, turned = parents[frame]
        rotation = _product(turned, rotation)
    return None


def beams(scan: LaserScan, mounted: Mount) -> Beams:
    """The beams as the robot sees them: those of a full turn begin behind it."""
    num, step = len(scan.ranges), scan.step
    span = step * (num - 1)
    first, ranges = mounted.yaw + scan.first, scan.ranges
    if not mounted.upright:
        first, ranges = mounted.yaw - scan.first - span, ranges[::-1]
    if num > 2 and span > 2 * math.pi - 1.5 * step:
        return _full_turn(first, step, ranges)
    middle = first + span / 2
    return Beams(first - 2 * math.pi * round(middle / (2 * math.pi)), span, ranges)


def _full_turn(first: float, step: float, ranges: np.ndarray) -> Beams:
    """The beams from -pi on; one that repeats the first is left out."""
    num = min(len(ranges), max(2, round(2 * math.pi / step)))
    angles = np.remainder(first + step * np.arange(num) + math.pi, 2 * math.pi) - math.pi
    start = int(np.argmin(angles))
    return Beams(float(angles[start]), step * (num - 1), np.roll(ranges[:num], -start))


def _mount(rotation: Quaternion) -> Mount:
    x, y, z, w = rotation
    yaw = math.atan2(2 * (w * z + x * y), w * w + x * x - y * y - z * z)
    return Mount(yaw, x * x + y * y <= z * z + w * w)


def _product(a: Quaternion, b: Quaternion) -> Quaternion:
    (ax, ay, az, aw), (bx, by, bz, bw) = a, b
    return (
        aw * bx + ax * bw + ay * bz - az * by,
        aw * by - ax * bz + ay * bw + az * bx,
        aw * bz + ax * by - ay * bx + az * bw,
        aw * bw - ax * bx - ay * by - az * bz,
    )
