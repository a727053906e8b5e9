"""A walk put together from what it has sensed: odometry, matched views, loops, no pose."""

from typing import NamedTuple

import numpy as np
from jaxtyping import Float, Int

from motorspace.mapping.frame import check_matched
from motorspace.mapping.loops import Keyframes, far_loops, near_loops, unlikeness
from motorspace.mapping.matching import match, mutual
from motorspace.mapping.motion import Motion, chained, fit_motion
from motorspace.mapping.mounting import SATURATED, Mounting, unwrapped
from motorspace.mapping.pose_graph import Edges, joined, optimised
from motorspace.mapping.search import Window, images
from motorspace.mapping.views import Views, joined_views, scan_views
from motorspace.se2 import relative

CORRECTIONS = 2
"""Rounds in which odometry is corrected by matches of neighbours."""
GAPS = (1, 2, 3, 5, 8, 12)
"""Steps between scans that are matched."""
SPREAD = (0.03, 0.07)
"""Standard deviations of odometry over a few steps: share of the reach, radians."""
LOOSE = (0.1, 0.2)
"""The same where a match is to say how far off odometry is: it has to be the walls' word alone."""
FREE = (0.3, 0.6)
"""The same where it is to say how uncertain odometry is: what draws matches together hides that."""
SHARE = 0.3
"""Least share of one scan's points on another; they look into different directions."""
JOINED_SHARE = 0.3
KEYFRAME = (0.05, 0.5)
"""From one keyframe to the next: share of the reach, radians."""
NUM_JOINED, NUM_POINTS = 600, 128
"""Readings that are joined to a keyframe's view, and points that are kept of them."""
NEIGHBOURS = (1, 2, 4, 7)
"""Keyframes from one to another on the way that are matched."""
APART = 0.5
"""Least length of the way around a loop, share of the reach."""
WIDE = Window(0.7, 0.6)
SEARCHES, ENOUGH = 3, 0.5
"""How often loops are searched for far around, unless there are so many for each keyframe."""
PASSES = (0.25, 0.12)
"""How far apart keyframes may be thought to be whose views are matched, one pass after another."""
NUM_HELD, WITHIN, HELD_SHARE = 3, 0.15, 0.5
"""Keyframes that each scan is matched with, how near they are, the least share of its points."""
CERTAINTY, JOINED_CERTAINTY = 0.1, 0.03
"""Errors of points on one wall are alike: matches are less certain than if they were not."""


class Scans(NamedTuple):
    """What a walk has sensed, and the odometry between.

    Args:
        sensors: Readings, [N, K].
        steps: Displacements of the rays' origin from each moment to the next, by odometry, in
            the readings' unit, [3, N - 1].
        mounting: Where the rays point.
    """

    sensors: Float[np.ndarray, "N K"]
    steps: Float[np.ndarray, "3 S"]
    mounting: Mounting

    def views(self) -> Views:
        """Each scan as points on walls, neighbouring rays side by side."""
        angles = unwrapped(self.mounting.angles)
        order = np.argsort(angles)
        angles, sensors = angles[order], self.sensors[:, order]
        points = np.stack([sensors * np.cos(angles), sensors * np.sin(angles)], axis=-1)
        met = sensors < SATURATED * self.mounting.reach
        return scan_views(points, met, reach=self.mounting.reach)


class Survey(NamedTuple):
    """Where the rays began at every moment of a walk, and what says so.

    Args:
        poses: [3, N], from the first of them, in the readings' unit.
        local: Where odometry alone leads, once it is corrected by matches of neighbours, [3, N].
        motion: What odometry gets wrong, and how uncertain it is.
        loops: Matches of places that the walk has come back to, between moments.
    """

    poses: Float[np.ndarray, "3 N"]
    local: Float[np.ndarray, "3 N"]
    motion: Motion
    loops: Edges


def survey(scans: Scans, known: Motion | None = None) -> Survey:
    """Put a walk together.

    Args:
        scans: Readings and odometry.
        known: What odometry gets wrong; by default the walk has to show it. Where no walls are in
            sight the path is then that of corrected odometry.

    Raises:
        UserError: Where nothing is known and too few neighbouring scans can be matched.
    """
    views, reach = scans.views(), scans.mounting.reach
    motion = _corrected(views, scans.steps, reach) if known is None else known
    steps = motion.corrected(scans.steps)
    poses = local = chained(steps)
    if not views.exist.any():
        return Survey(poses, local, motion, NO_EDGES)
    num = len(scans.sensors)
    odometry = Edges(
        np.arange(num - 1), np.arange(1, num), steps, np.linalg.inv(motion.covariance(steps))
    )
    matched: list[Edges] = []
    for gap in GAPS:
        if gap < num:
            matched.append(_neighbours(views, poses, gap, reach))
            poses = optimised(odometry, joined(*matched), poses)
    loops = NO_EDGES
    for within in (*[None] * SEARCHES, *PASSES):
        keyframes = _keyframes(views, poses, scans)
        if within is None and len(loops.first) > ENOUGH * len(keyframes.moments):
            continue
        there = poses[:, keyframes.moments]
        if within is None:
            seen = images(keyframes.views, reach=reach)
            found = far_loops(keyframes, seen, there, WIDE, apart=APART * reach)
        else:
            found = near_loops(keyframes, there, apart=APART * reach, within=within * reach)
        loops = found.between(keyframes.moments, JOINED_CERTAINTY)
        around = _around(keyframes, there)
        poses = optimised(odometry, joined(*matched, around, loops), poses)
    on_keyframes = _on_keyframes(views, keyframes, poses)
    poses = optimised(odometry, joined(*matched, around, loops, on_keyframes), poses)
    if known is None:
        motion = _uncertain(views, motion, steps, relative(poses[:, :-1], poses[:, 1:]))
    return Survey(poses, local, motion, loops)


NO_EDGES = Edges(np.zeros(0, int), np.zeros(0, int), np.zeros((3, 0)), np.zeros((0, 3, 3)))


def corrected_odometry(scans: Scans) -> Motion:
    """What odometry gets wrong along a walk, and how uncertain it is, by matches of neighbours.

    Args:
        scans: Readings and odometry.

    Raises:
        UserError: Where too few neighbouring scans can be matched.
    """
    views = scans.views()
    motion = _corrected(views, scans.steps, scans.mounting.reach)
    steps = motion.corrected(scans.steps)
    return _uncertain(views, motion, steps, steps)


def _corrected(views: Views, steps: Float[np.ndarray, "3 S"], reach: float) -> Motion:
    """Odometry that agrees with matches of neighbouring scans, on average."""
    pairs = _apart(steps.shape[1] + 1, 1)
    given = steps
    for _ in range(CORRECTIONS):
        rows, matches = mutual(views, pairs, steps, reach=reach, spread=LOOSE, share=SHARE)
        check_matched(len(rows), pairs.shape[1])
        motion = fit_motion(given[:, rows], matches, reach=reach)
        steps = motion.corrected(given)
    return motion


def _uncertain(
    views: Views, motion: Motion, steps: Float[np.ndarray, "3 S"], guess: Float[np.ndarray, "3 S"]
) -> Motion:
    """The motion with the uncertainty of corrected odometry, by how far it is from matches.

    Matches begin with the guess. Steps between poses are no more than that: they are compromises
    with odometry itself.
    """
    reach, pairs = motion.reach, _apart(steps.shape[1] + 1, 1)
    rows, matches = mutual(views, pairs, guess, reach=reach, spread=FREE, share=SHARE)
    if len(rows) == 0:
        return motion
    found = fit_motion(steps[:, rows], matches, reach=reach, correct=False)
    return found._replace(twist=motion.twist)


def _neighbours(views: Views, poses: Float[np.ndarray, "3 N"], gap: int, reach: float) -> Edges:
    """Matches of scans so many steps apart."""
    pairs = _apart(poses.shape[1], gap)
    guess = relative(poses[:, pairs[0]], poses[:, pairs[1]])
    rows, matches = mutual(views, pairs, guess, reach=reach, spread=SPREAD, share=SHARE)
    return Edges.of(pairs[:, rows], matches.displacement, CERTAINTY * matches.information)


def _apart(num: int, gap: int) -> Int[np.ndarray, "2 E"]:
    """The pairs of `num` in a row that are so many apart; none where they are fewer."""
    first = np.arange(max(num - gap, 0))
    return np.stack([first, first + gap])


def _keyframes(views: Views, poses: Float[np.ndarray, "3 N"], scans: Scans) -> Keyframes:
    """Moments that are some way apart, and what is seen around each."""
    reach = scans.mounting.reach
    shift, turn = KEYFRAME
    moments = [0]
    for moment in range(1, poses.shape[1]):
        x, y, angle = relative(poses[:, moments[-1]], poses[:, moment])
        if np.hypot(x, y) > shift * reach or abs(angle) > turn:
            moments.append(moment)
    chosen = np.array(moments)
    around = max(1, round(NUM_JOINED / (2 * scans.sensors.shape[1])))
    joint = joined_views(views, poses, chosen, around=around, num_points=NUM_POINTS, reach=reach)
    way = np.append(0.0, np.cumsum(np.hypot(*np.diff(poses[:2], axis=1))))
    return Keyframes(chosen, joint, way[chosen], reach, around)


def _around(keyframes: Keyframes, poses: Float[np.ndarray, "3 V"]) -> Edges:
    """Matches of keyframes that follow one another."""
    pairs = np.concatenate([_apart(len(keyframes.moments), gap) for gap in NEIGHBOURS], axis=1)
    guess = relative(poses[:, pairs[0]], poses[:, pairs[1]])
    rows, matches = mutual(
        keyframes.views,
        pairs,
        guess,
        reach=keyframes.reach,
        spread=SPREAD,
        share=JOINED_SHARE,
    )
    found = Edges.of(pairs[:, rows], matches.displacement, matches.information)
    return found.between(keyframes.moments, JOINED_CERTAINTY)


def _on_keyframes(views: Views, keyframes: Keyframes, poses: Float[np.ndarray, "3 N"]) -> Edges:
    """Matches of every scan with the nearest keyframes that have not seen it themselves.

    Scans whose neighbours do not match are where odometry has left them, until now.
    """
    reach, num = keyframes.reach, poses.shape[1]
    offset = poses[:, :, None] - poses[:, keyframes.moments][:, None]
    away = unlikeness(offset, reach=reach)
    away[np.abs(np.arange(num)[:, None] - keyframes.moments) <= keyframes.around] = np.inf
    nearest = np.argsort(away, axis=1)[:, :NUM_HELD]
    near = np.take_along_axis(away, nearest, axis=1) < WITHIN
    second, place = np.nonzero(near)
    first = nearest[second, place]
    both = keyframes.views.beside(views)
    pairs = np.stack([first, len(keyframes.moments) + second])
    moments = np.stack([keyframes.moments[first], second])
    guess = relative(poses[:, moments[0]], poses[:, moments[1]])
    found = match(both, pairs, guess, reach=reach, spread=SPREAD, near=True)
    held = found.share > HELD_SHARE
    found = found.chosen(held)
    return Edges.of(moments[:, held], found.displacement, CERTAINTY * found.information)
