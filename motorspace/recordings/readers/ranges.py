"""Laser ranges as robots report them: which beams, and what a reading means."""

import math
from typing import Literal, NamedTuple

import numpy as np
from jaxtyping import Bool, Float, Int

from motorspace._errors import UserError

Invalid = Literal["max_range", "leave_out", "refuse"]

CODES = (81.83, 81.87, 81.89, 81.90, 81.91)
"""What a SICK LMS reports when it measures nothing: 8183 to 8191 centimetres, here in metres."""


class Beams(NamedTuple):
    """The beams of one scan: from the first one, counter-clockwise, evenly spread."""

    first: float
    """Angle of the first beam from the robot's heading, radians."""
    span: float
    """Angle from the first beam to the last one."""
    ranges: Float[np.ndarray, " R"]


class Reading(NamedTuple):
    """The readings of N scans along the kept rays."""

    sensors: Float[np.ndarray, "N K"]
    """World units, from 0 to the maximum range."""
    limit: float
    """The maximum range, which also stands for no return."""
    invalid: Bool[np.ndarray, " N"]
    """Scans with an invalid reading."""
    notes: tuple[str, ...]


def kept_beams(beams: Beams, num_rays: int, field_of_view: float) -> Int[np.ndarray, " K"]:
    """Indices of the beams that are nearest to `num_rays` even rays, rightmost first.

    One ray looks straight ahead. Raises `UserError` when none of the beams is within the view.
    """
    num = len(beams.ranges)
    if num == 1:
        return np.zeros(num_rays, int)
    ahead = -beams.first / beams.span
    half = field_of_view / 2 / beams.span
    low, high = max(ahead - half, 0.0), min(ahead + half, 1.0)
    if high < low or (num_rays == 1 and not 0 <= ahead <= 1):
        raise UserError(
            f"the laser sees {math.degrees(beams.first):.0f} to "
            f"{math.degrees(beams.first + beams.span):.0f} degrees, and no kept ray is among them",
            remedy="choose another laser, more rays or a larger field of view",
        )
    share = np.linspace(low, high, num_rays) if num_rays > 1 else np.array([ahead])
    # Of an even number of beams over (-pi/2, pi/2], the one above the middle looks ahead.
    return np.floor((num - 1) * share + 0.5).astype(int)


def interpret(
    raw: Float[np.ndarray, "N K"],
    limits: Float[np.ndarray, " N"],
    *,
    max_range: float,
    invalid: Invalid,
    where: object,
) -> Reading:
    """What raw readings mean.

    No return, which becomes the maximum range: at or beyond `max_range` or the scan's own limit,
    infinite, 0, or a code of the laser (81.91 and its like, 8191 in centimetres). Invalid: below
    0, or not a number.

    Args:
        raw: World units.
        limits: Each scan's own maximum range; infinite where it names none.
        max_range: The maximum range.
        invalid: What an invalid reading becomes: the maximum range, or a reason to leave the
            transitions of its scan out, or to refuse the log.
        where: The file, for errors.
    """
    own = limits[np.isfinite(limits)]
    limit = min(max_range, float(own.max())) if len(own) == len(limits) else max_range
    negative, unknown = raw < 0, np.isnan(raw)
    wrong = negative | unknown
    codes = np.array(CODES)[:, None, None]
    coded = np.isclose(raw, codes, 0, 1e-4) | np.isclose(raw, 100 * codes, 0, 1e-2)
    nothing = (raw == 0) | (raw >= np.minimum(limits, limit)[:, None]) | coded.any(axis=0)
    if wrong.any() and invalid == "refuse":
        scan, ray = np.argwhere(wrong)[0]
        raise UserError(
            f"{wrong.sum()} readings are invalid, the first is {raw[scan, ray]} in scan {scan}",
            where=where,
            remedy="set invalid to max_range or leave_out",
        )
    notes = []
    if wrong.any():
        rule = "taken as no return" if invalid == "max_range" else "their scans are left out"
        notes.append(
            f"{wrong.sum()} of {raw.size} readings are invalid ({negative.sum()} negative, "
            f"{unknown.sum()} not a number): {rule}"
        )
    if nothing.any():
        notes.append(
            f"{nothing.sum()} of {raw.size} readings are no return (0, infinite, a code of the "
            f"laser, or {limit:g} and more): each counts as {limit:g}"
        )
    if (nothing | wrong).mean() > 0.9:
        notes.append(
            "more than nine readings in ten are no return or invalid: check max_range and the unit "
            "of the ranges"
        )
    return Reading(np.where(nothing | wrong, limit, raw), limit, wrong.any(axis=1), tuple(notes))
