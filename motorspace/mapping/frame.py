"""How codes' displacements look in the rays' frame: what prediction leaves open, by matched scans.

Codes hold displacements of a frame of their own, in a unit of their own, perhaps in a mirror. What
prediction within a few steps hardly shows, such as how wide a turn is, they hold roughly. Where
neighbouring scans can be matched the same displacements are known in the rays' frame.
"""

import numpy as np
from jaxtyping import Float

from motorspace._errors import UserError
from motorspace.mapping.matching import Matches, mutual
from motorspace.mapping.search import Window, images, search
from motorspace.mapping.views import Views
from motorspace.se2 import exponential, logarithm

Steps = Float[np.ndarray, "3 S"]
FrameMap = Float[np.ndarray, "3 3"]

ROUNDS, REWEIGHTED = 4, 20
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


def in_frame(steps: Steps, frame: FrameMap) -> Steps:
    """The displacements in the rays' frame."""
    return np.asarray(exponential(logarithm(steps) @ frame.T))


def find_frame(views: Views, steps: Steps, *, reach: float) -> FrameMap:
    """From twists by codes to twists of the rays' origin.

    A change of frame, of unit, of handedness is linear in twists, and so is the little that codes
    get wrong of each command. Scans are matched where they overlap most at first, then where the
    codes lead.

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
    guess, _ = search(images(views, reach=reach), pairs, 0 * steps, SEARCHED, reach=reach)
    for _ in range(ROUNDS):
        rows, matches = mutual(views, pairs, guess, reach=reach, spread=SPREAD, share=SHARE)
        check_matched(len(rows), pairs.shape[1])
        frame = _fitted(logarithm(steps[:, rows]), matches, reach)
        guess = in_frame(steps, frame)
    return frame


def check_matched(num: int, of: int) -> None:
    """Refuse to go on with few matches."""
    if num < FEWEST:
        raise UserError(
            f"{num} of {of} pairs of neighbouring scans can be matched",
            remedy="give a walk with walls in sight and more rays",
        )


def _fitted(twists: Float[np.ndarray, "E 3"], matches: Matches, reach: float) -> FrameMap:
    """Least squares that are reweighted (Cauchy)."""
    scale = np.array([reach, reach, 1.0])
    wanted = logarithm(matches.displacement) / scale
    known = np.einsum("ab,ec->eabc", np.eye(3), twists).reshape(-1, 3, 9)
    # What matches say along a corridor is nothing: they are as certain as their walls.
    covariance = np.linalg.inv(matches.information * np.outer(scale, scale) + np.eye(3))
    information = np.linalg.inv(covariance + np.diag(LEAST**2))
    weight = np.ones(len(twists))
    for _ in range(REWEIGHTED):
        weighted = np.einsum("eau,eab->eub", known, information * weight[:, None, None])
        normal = np.einsum("eub,ebv->uv", weighted, known)
        found = np.linalg.lstsq(normal, np.einsum("eub,eb->u", weighted, wanted), rcond=None)[0]
        off = wanted - known @ found
        errors = np.einsum("ea,eab,eb->e", off, information, off)
        weight = 1 / (1 + errors / (2 * np.median(errors) + 1e-12))
    return found.reshape(3, 3) * scale[:, None]
