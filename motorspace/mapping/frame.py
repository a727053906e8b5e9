"""How codes' displacements look in the rays' frame: what prediction leaves open, by matched scans.

Codes hold displacements of a frame of their own, in a unit of their own, perhaps in a mirror. What
prediction within a few steps hardly shows, such as how wide a turn is, they hold roughly. Where
neighbouring scans can be matched the same displacements are known in the rays' frame.
"""

import numpy as np
from jaxtyping import Float

from motorspace._errors import UserError
from motorspace.mapping.bearings import KEPT
from motorspace.mapping.matching import Matches, mutual
from motorspace.mapping.search import Window, images, search
from motorspace.mapping.views import Views
from motorspace.mapping.weighted import Equations
from motorspace.se2 import exponential, logarithm

Steps = Float[np.ndarray, "3 S"]
FrameMap = Float[np.ndarray, "3 3"]

ROUNDS = 3
SPREAD = (0.1, 0.25)
"""Standard deviations of guesses: share of the reach, radians."""
SEARCHED = Window(0.2, 0.8)
SHARE = 0.3
"""Least share of one scan's points on another."""
FEWEST = 20
"""Matches that are enough."""
NUM_PAIRS = 300
"""Neighbouring scans that are matched at most, evenly spread over the walk."""
LEAST = np.array([2e-3, 2e-3, 2e-3])
"""Errors of matches that make no difference: shares of the reach, radians."""


def _families() -> tuple[Float[np.ndarray, "U 3 3"], ...]:
    """Frames elsewhere in a unit of their own, turns in another; those in a mirror; all linear."""
    entry = np.eye(9).reshape(3, 3, 3, 3)
    shared = [entry[0, 2], entry[1, 2], entry[2, 2]]
    rigid = [entry[0, 0] + entry[1, 1], entry[1, 0] - entry[0, 1], *shared]
    mirrored = [entry[0, 0] - entry[1, 1], entry[1, 0] + entry[0, 1], *shared]
    return np.stack(rigid), np.stack(mirrored), entry.reshape(9, 3, 3)


FAMILIES = _families()


def in_frame(steps: Steps, frame: FrameMap) -> Steps:
    """The displacements in the rays' frame."""
    return np.asarray(exponential(logarithm(steps) @ frame.T))


def find_frame(views: Views, steps: Steps, *, reach: float) -> FrameMap:
    """From twists by codes to twists of the rays' origin.

    A change of frame, of unit, of handedness is linear in twists, and so is the little that codes
    get wrong of each command. Scans are matched where they overlap most at first, then where the
    codes lead. Where that leads to most matches is believed: a change of frame, or any linear map.

    Args:
        views: What is seen at every moment, N of them.
        steps: Displacements by codes between them, [3, N - 1].
        reach: The largest reading.

    Raises:
        UserError: Where too few neighbouring scans can be matched.
    """
    num = steps.shape[1]
    first = np.unique(np.linspace(0, num - 1, min(num, NUM_PAIRS)).astype(int))
    views, steps = views.chosen(np.concatenate([first, first + 1])), steps[:, first]
    pairs = np.arange(2 * len(first)).reshape(2, -1)
    begin, _ = search(images(views, reach=reach), pairs, 0 * steps, SEARCHED, reach=reach)
    best, most = np.eye(3), -1
    for family in FAMILIES:
        guess, frame = begin, np.zeros((3, 3))
        for _ in range(ROUNDS):
            rows, matches = mutual(views, pairs, guess, reach=reach, spread=SPREAD, share=SHARE)
            if len(rows) < FEWEST:
                break
            frame = _fitted(logarithm(steps[:, rows]), matches, family, reach=reach)
            guess = in_frame(steps, frame)
        num = len(rows)
        if num > most:
            best, most = frame, num
    check_matched(most, pairs.shape[1])
    return best


def check_matched(num: int, of: int) -> None:
    """Refuse to go on with few matches."""
    if num < FEWEST:
        raise UserError(
            f"{num} of {of} pairs of neighbouring scans can be matched",
            remedy=f"give a longer walk with walls in sight and more rays, or {KEPT}",
        )


def _fitted(
    twists: Float[np.ndarray, "E 3"],
    matches: Matches,
    family: Float[np.ndarray, "U 3 3"],
    *,
    reach: float,
) -> FrameMap:
    """The member of a linear family that fits best: least squares, robust."""
    scale = np.array([reach, reach, 1.0])
    wanted = logarithm(matches.displacement) / scale
    known = np.einsum("uab,eb->eau", family, twists)
    information = np.linalg.inv(matches.covariance(reach=reach) + np.diag(LEAST**2))
    equations = Equations(known, wanted, information)
    found = equations.fitted(equations.by_few())
    return np.asarray(np.einsum("u,uab->ab", found, family) * scale[:, None])
