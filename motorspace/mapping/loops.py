"""Loops: places that a walk comes back to, found by what is seen there.

What one match says is not believed. Its views have to match both ways, and other matches nearby
have to say the same.
"""

from typing import NamedTuple

import numpy as np
from jaxtyping import Bool, Float, Int

from motorspace.mapping.matching import Matches, mutual
from motorspace.mapping.pose_graph import Edges
from motorspace.mapping.search import Images, Window, search
from motorspace.mapping.views import Views
from motorspace.se2 import compose, relative, wrap

NUM_NEAR, NUM_FAR, NUM_TRIED = 5, 12, 2
"""Candidates of each keyframe: the nearest; of many, chosen at random; of those the best."""
PER_RADIAN = 0.05
"""How much nearer a view has to be, share of the reach, that is turned by one radian more."""
TURNED = 1.0
"""Views that are turned by more seldom overlap, radians: the last of many to be tried."""
SHARE = 0.5
"""Least share of a view's points on the other one."""
SPREAD = (0.1, 0.2)
"""Standard deviations of a guess: share of the reach, radians."""
AROUND = 9
"""Keyframes from here on, and back, whose loops are neighbours."""
AGREE = (0.03, 0.06)
"""How far neighbours may disagree: share of the reach, radians."""
SUPPORT = 3
"""Neighbours that have to agree."""


class Keyframes(NamedTuple):
    """Moments of a walk whose surroundings are matched.

    Args:
        moments: [V], ascending.
        views: What is seen there.
        travelled: The length of the way up to each, [V].
        reach: The largest reading.
        around: Moments before and after each whose readings are part of its view.
    """

    moments: Int[np.ndarray, " V"]
    views: Views
    travelled: Float[np.ndarray, " V"]
    reach: float
    around: int

    def revisited(
        self, poses: Float[np.ndarray, "3 V"], *, apart: float, within: float, most: int
    ) -> Int[np.ndarray, "2 E"]:
        """Pairs of keyframes that are near one another, and far apart on the way.

        Args:
            poses: Where the keyframes are, [3, V].
            apart: Least length of the way between them.
            within: Greatest distance.
            most: Pairs for each keyframe: the nearest ones, which look the same way.
        """
        found = []
        for second in range(len(self.moments)):
            before = np.searchsorted(self.travelled, self.travelled[second] - apart)
            offset = poses[:, :before] - poses[:, [second]]
            distance = np.hypot(*offset[:2])
            nearest = np.argsort(unlikeness(offset, reach=self.reach))[:most]
            nearest = nearest[distance[nearest] < within]
            found.append(np.stack([nearest, np.full(len(nearest), second)]))
        return np.concatenate(found, axis=1).astype(np.int64)


def unlikeness(
    offset: Float[np.ndarray, "3 *pairs"], *, reach: float
) -> Float[np.ndarray, "*pairs"]:
    """How little two views have in common: how far they are apart, and how far turned.

    Args:
        offset: From one pose to the other, x, y and angle.
        reach: The largest reading, which is the unit.
    """
    x, y, turn = offset
    return np.asarray(np.hypot(x, y) / reach + PER_RADIAN * np.abs(wrap(turn)))


def near_loops(
    keyframes: Keyframes, poses: Float[np.ndarray, "3 V"], *, apart: float, within: float
) -> Edges:
    """Loops between keyframes that are known to be near, up to `within`; indices of keyframes."""
    pairs = keyframes.revisited(poses, apart=apart, within=within, most=NUM_NEAR)
    return _checked(keyframes, poses, pairs, relative(*_at(poses, pairs)))


def far_loops(
    keyframes: Keyframes,
    seen: Images,
    poses: Float[np.ndarray, "3 V"],
    window: Window,
    *,
    apart: float,
) -> Edges:
    """Loops between keyframes that are about where they are thought to be, within a window."""
    reach = keyframes.reach
    within = window.shift * reach
    pairs = keyframes.revisited(poses, apart=apart, within=within, most=len(poses[0]))
    pairs = _some(pairs, _turned(poses[2, pairs[0]] - poses[2, pairs[1]]), NUM_FAR)
    guess, overlap = search(seen, pairs, relative(*_at(poses, pairs)), window, reach=reach)
    best = _best(pairs[1], overlap)
    return _checked(keyframes, poses, pairs[:, best], guess[:, best])


def _at(poses: np.ndarray, pairs: Int[np.ndarray, "2 E"]) -> tuple[np.ndarray, np.ndarray]:
    return poses[:, pairs[0]], poses[:, pairs[1]]


def _turned(angle: np.ndarray) -> Bool[np.ndarray, "*pairs"]:
    """Whether one looks another way than the other."""
    return np.asarray(np.abs(wrap(angle)) > TURNED)


def _some(
    pairs: Int[np.ndarray, "2 E"], turned: Bool[np.ndarray, " E"], most: int
) -> Int[np.ndarray, "2 K"]:
    """At most so many pairs for each second keyframe: those not turned first, else at random."""
    order = np.lexsort((np.random.default_rng(0).permutation(len(turned)), turned))
    return pairs[:, np.sort(_first_of_each(pairs[1], order, most))]


def _best(second: Int[np.ndarray, " E"], overlap: Float[np.ndarray, " E"]) -> np.ndarray:
    """The rows of each second keyframe that overlap most."""
    return _first_of_each(second, np.argsort(-overlap), NUM_TRIED)


def _first_of_each(
    groups: Int[np.ndarray, " E"], order: Int[np.ndarray, " E"], most: int
) -> Int[np.ndarray, " K"]:
    """The first rows of every group, in the given order."""
    order = order[np.argsort(groups[order], kind="stable")]
    sorted_groups = groups[order]
    starts = np.searchsorted(sorted_groups, sorted_groups)
    return order[np.arange(len(order)) - starts < most]


def _checked(
    keyframes: Keyframes,
    poses: Float[np.ndarray, "3 V"],
    pairs: Int[np.ndarray, "2 E"],
    guess: Float[np.ndarray, "3 E"],
) -> Edges:
    """The pairs that match both ways, and whose neighbours agree."""
    rows, matches = mutual(
        keyframes.views, pairs, guess, reach=keyframes.reach, spread=SPREAD, share=SHARE
    )
    pairs = pairs[:, rows]
    agreeing = num_agreeing(pairs, matches, poses, reach=keyframes.reach) >= SUPPORT
    matches = matches.chosen(agreeing)
    return Edges.of(pairs[:, agreeing], matches.displacement, matches.information)


def num_agreeing(
    pairs: Int[np.ndarray, "2 E"],
    matches: Matches,
    poses: Float[np.ndarray, "3 V"],
    *,
    reach: float,
) -> Int[np.ndarray, " E"]:
    """How many other matches say of each the same, between keyframes a few away.

    Args:
        pairs: Keyframes, [2, E].
        matches: How they lie to one another.
        poses: Where keyframes are; only neighbours have to be right among themselves.
        reach: The largest reading.
    """
    first, second = pairs
    agreeing = np.zeros(len(first), int)
    shift, turn = AGREE[0] * reach, AGREE[1]
    for row in range(len(first)):
        close = (np.abs(first - first[row]) <= AROUND) & (np.abs(second - second[row]) <= AROUND)
        others = np.flatnonzero(close & ((first != first[row]) | (second != second[row])))
        num = len(others)
        here, there = (np.repeat(poses[:, [ends[row]]], num, axis=1) for ends in pairs)
        to_other = relative(here, poses[:, first[others]])
        back = relative(poses[:, second[others]], there)
        around = compose(compose(to_other, matches.displacement[:, others]), back)
        said = np.repeat(matches.displacement[:, [row]], num, axis=1)
        x, y, angle = relative(said, around)
        agreeing[row] = np.sum((np.hypot(x, y) < shift) & (np.abs(angle) < turn))
    return agreeing
