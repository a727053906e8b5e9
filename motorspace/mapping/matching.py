"""Two views of a place laid on top of one another: where the second was seen from.

Points of one view are moved until they lie on the lines through the points of the other
(point-to-line matching, Censi 2008), many pairs of views at once.
"""

from typing import NamedTuple

import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Bool, Float, Int

from motorspace._types import Scalar
from motorspace.mapping.views import FAR, Views
from motorspace.se2 import inverse, relative, wrap

ROUNDS, FEW_ROUNDS = 10, 4
"""Steps from a guess; from one that is known to be near."""
GATE_FIRST, GATE_NEAR, GATE_LAST = 0.1, 0.03, 0.015
"""How far points may be from their partners: in the first round, in the first of few, and in the
last round; shares of the sensors' reach."""
OUTLIER = 0.005
"""How far off a line a point is that counts a quarter, share of the reach."""
MOVED = 64
"""Points of a view that are moved, at most."""
SLANT, LEAST_KNOWN = 0.1, 1.0
"""How far off normals may be, radians; the information of matches that say nothing."""
CALL_SIZE, CHUNK_SIZE = 256, 32
"""Pairs of one call of the compiled program, and those that it matches at once."""


class Matches(NamedTuple):
    """How pairs of views lie to one another.

    Args:
        displacement: From the place of the first view to that of the second, [3, E].
        information: Inverse covariance of it, in the frame of the second place, [E, 3, 3]. Points
            count as independent, which those on one wall are not.
        share: How many points of the second view, of those that exist, lie on the first, [E].
    """

    displacement: Float[np.ndarray, "3 E"]
    information: Float[np.ndarray, "E 3 3"]
    share: Float[np.ndarray, " E"]

    def chosen(self, rows: np.ndarray) -> "Matches":
        """Some of them, by a mask or by indices."""
        return Matches(self.displacement[:, rows], self.information[rows], self.share[rows])

    def covariance(self, *, reach: float) -> Float[np.ndarray, "E 3 3"]:
        """How uncertain they are, in shares of the reach and radians: along a corridor, wholly."""
        scale = np.array([reach, reach, 1.0])
        information = self.information * np.outer(scale, scale)
        # Walls' normals are a little off, which looks like knowledge of the way along them.
        across = information[:, 0, 0] + information[:, 1, 1]
        spurious = SLANT**2 * across[:, None, None] * np.diag([1.0, 1.0, 0.0])
        sizes, axes = np.linalg.eigh(information - spurious)
        known = np.maximum(sizes, LEAST_KNOWN)[:, None]
        return np.asarray((axes / known) @ np.swapaxes(axes, 1, 2))


class _Pair(NamedTuple):
    points: Float[Array, "*E A 2"]
    normals: Float[Array, "*E A 2"]
    moving: Float[Array, "*E B 2"]
    guess: Float[Array, "*E 3"]


def match(
    views: Views,
    pairs: Int[np.ndarray, "2 E"],
    guess: Float[np.ndarray, "3 E"],
    *,
    reach: float,
    spread: tuple[float, float],
    near: bool = False,
) -> Matches:
    """Match pairs of views, beginning with a guess of each displacement.

    Args:
        views: The points seen from each place.
        pairs: The view that stays and the view that is moved, [2, E].
        guess: Displacements from the first place to the second, [3, E].
        reach: The largest reading, which is the unit of all tolerances.
        spread: Standard deviations of the guess, of shifts (shares of the reach) and of turns
            (radians): the guess decides where walls do not.
        near: Whether the guess is nearly right, so that few steps are enough.
    """
    scale = np.array([reach, reach, 1.0])
    start = guess.T / scale
    points, normals = views.in_reaches(reach), views.normals
    moving = points[:, :: -(-points.shape[1] // MOVED)]
    shift, turn = spread
    stiffness = jnp.asarray([1 / shift, 1 / shift, 1 / turn], jnp.float32)
    parts = []
    for first in range(0, max(pairs.shape[1], 1), CALL_SIZE):
        here, there = pairs[:, first : first + CALL_SIZE]
        case = _Pair(points[here], normals[here], moving[there], start[first : first + CALL_SIZE])
        padded = jax.tree.map(_padded, case)
        found = _matched(padded, stiffness, near=near)
        parts.append([np.asarray(part[: len(here)], np.float64) for part in found])
    displacement, information, share = (np.concatenate(part) for part in zip(*parts, strict=True))
    displacement = (displacement * scale).T
    displacement[2] = wrap(displacement[2])
    return Matches(displacement, information / np.outer(scale, scale), share)


def _padded(part: np.ndarray) -> Float[Array, "E *rest"]:
    """Rows up to a fixed number, so that one program serves all."""
    padded = np.zeros((CALL_SIZE, *part.shape[1:]), np.float32)
    padded[: len(part)] = part
    return jnp.asarray(padded)


@eqx.filter_jit
def _matched(
    pairs: _Pair, stiffness: Float[Array, "3"], *, near: bool
) -> tuple[Float[Array, "E 3"], Float[Array, "E 3 3"], Float[Array, " E"]]:
    def one(pair: _Pair) -> tuple[Array, Array, Array]:
        return _match_pair(pair, stiffness, near=near)

    return jax.lax.map(one, pairs, batch_size=CHUNK_SIZE)


def _match_pair(
    pair: _Pair, stiffness: Float[Array, "3"], *, near: bool
) -> tuple[Float[Array, "3"], Float[Array, "3 3"], Scalar]:
    """Gauss-Newton steps with partners that are chosen anew; all lengths in the reach."""
    exists = pair.moving[:, 0] < FAR / 2
    rounds, first_gate = (FEW_ROUNDS, GATE_NEAR) if near else (ROUNDS, GATE_FIRST)

    def partners(pose: Float[Array, "3"]) -> tuple[Array, Array, Array]:
        moved = _placed(pose, pair.moving)
        gaps = jnp.sum((moved[:, None] - pair.points[None]) ** 2, axis=-1)
        nearest = jnp.argmin(gaps, axis=1)
        normal = pair.normals[nearest]
        off = jnp.sum(normal * (moved - pair.points[nearest]), axis=-1)
        return off, normal, jnp.sqrt(gaps[jnp.arange(len(moved)), nearest])

    def equations(pose: Float[Array, "3"], gate: Scalar) -> tuple[Array, Array, Bool[Array, " B"]]:
        off, normal, gap = partners(pose)
        known = exists & (gap < gate) & (jnp.sum(normal**2, axis=-1) > 0)
        weight = jnp.where(known, (1 + (off / OUTLIER) ** 2) ** -2 / OUTLIER**2, 0.0)
        cos, sin = jnp.cos(pose[2]), jnp.sin(pose[2])
        across = jnp.stack(
            [
                normal[:, 0] * cos + normal[:, 1] * sin,
                normal[:, 1] * cos - normal[:, 0] * sin,
            ],
            axis=-1,
        )
        turned = across[:, 1] * pair.moving[:, 0] - across[:, 0] * pair.moving[:, 1]
        jacobian = jnp.concatenate([across, turned[:, None]], axis=-1)
        jacobian = jnp.where(known[:, None], jacobian, 0.0)
        information = jacobian.T @ (jacobian * weight[:, None])
        return information, jacobian.T @ (weight * jnp.where(known, off, 0.0)), known

    def step(index: Array, pose: Float[Array, "3"]) -> Float[Array, "3"]:
        share = jnp.float32(index) / (rounds - 1)
        gate = first_gate * (GATE_LAST / first_gate) ** share
        information, downhill, _ = equations(pose, gate)
        back = _within(pose, pair.guess)
        held = jnp.diag(stiffness**2)
        delta = jnp.linalg.solve(information + held, -downhill - held @ back)
        return _composed(pose, delta)

    pose = jax.lax.fori_loop(0, rounds, step, pair.guess)
    information, _, known = equations(pose, jnp.float32(GATE_LAST))
    off, _, _ = partners(pose)
    on = known & (jnp.abs(off) < 2 * OUTLIER)
    return pose, information, jnp.sum(on) / jnp.maximum(jnp.sum(exists), 1)


def _placed(pose: Float[Array, "3"], points: Float[Array, "B 2"]) -> Float[Array, "B 2"]:
    cos, sin = jnp.cos(pose[2]), jnp.sin(pose[2])
    x, y = points.T
    return jnp.stack([pose[0] + cos * x - sin * y, pose[1] + sin * x + cos * y], axis=-1)


def _composed(pose: Float[Array, "3"], then: Float[Array, "3"]) -> Float[Array, "3"]:
    shift = _placed(pose, then[None, :2])[0]
    return jnp.append(shift, pose[2] + then[2])


def _within(pose: Float[Array, "3"], other: Float[Array, "3"]) -> Float[Array, "3"]:
    """The pose in the frame of another, to first order where it serves as a residual."""
    cos, sin = jnp.cos(pose[2]), jnp.sin(pose[2])
    dx, dy = pose[:2] - other[:2]
    angle = pose[2] - other[2]
    return jnp.stack([cos * dx + sin * dy, cos * dy - sin * dx, angle])


def mutual(
    views: Views,
    pairs: Int[np.ndarray, "2 E"],
    guess: Float[np.ndarray, "3 E"],
    *,
    reach: float,
    spread: tuple[float, float],
    share: float,
) -> tuple[Int[np.ndarray, " K"], Matches]:
    """Matches that hold both ways: from the first view to the second, and back.

    Args:
        views: The points seen from each place.
        pairs: The first and the second view of each pair, [2, E].
        guess: Displacements to begin with, [3, E].
        reach: The largest reading.
        spread: Standard deviations of the guess: share of the reach, radians.
        share: Least share of each view's points that have to lie on the other.

    Returns:
        Which pairs match, and how.
    """
    there = match(views, pairs, guess, reach=reach, spread=spread)
    rows = np.flatnonzero(there.share > share)
    there = there.chosen(rows)
    back = match(
        views,
        pairs[::-1, rows],
        np.asarray(inverse(there.displacement)),
        reach=reach,
        spread=spread,
        near=True,
    )
    x, y, turn = relative(np.asarray(inverse(back.displacement)), there.displacement)
    same = (np.hypot(x, y) < SAME_SHIFT * reach) & (np.abs(turn) < SAME_TURN)
    same &= back.share > share
    return rows[same], there.chosen(same)


SAME_SHIFT, SAME_TURN = 0.02, 0.03
"""How far a match there and a match back may be apart: share of the reach, radians."""
