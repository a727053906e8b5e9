"""Where an agent may be that senses this: places it has not stood at, as its map shows them."""

from typing import NamedTuple

import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Float
from scipy.spatial import cKDTree

from motorspace._types import Count
from motorspace.mapping.walls import WallMap

PER_MOMENT = 20
"""Imagined places for each remembered moment."""
AROUND = 0.05
"""Standard deviation of their distance from it, share of the reach."""
CHUNK_SIZE = 20_000
NEIGHBOURS = 200
"""Imagined places that sense most like the readings; these are corrected and weighed."""
CORRECTIONS = 5
DIFFERENCE = 2e-3
"""Step of the finite differences, share of the reach and tenths of radians."""
OUTLIER = 0.01
"""What is off by more counts less, share of the reach: a ray beside a corner is off by a jump."""
SHARPNESS = 2.0
"""How fast a hypothesis loses weight with its mismatch, the sum of log(1 + (off / OUTLIER)^2)."""
SAME = np.array([[0.01], [0.01], [0.05]])
"""Hypotheses nearer than this are one: shares of the reach, radians."""
SLIP, TWIST = 0.01, 0.05
"""Standard deviation of what odometry is off by after a sequence: share of the reach, radians."""
UNEXPECTED = 1e-4
"""How likely a place is that odometry does not lead to, relative to one that it leads to."""
HYPOTHESES = 16
UNLIKELY = 0.01
"""Hypotheses below this share of the likeliest one are dropped."""


class Hypotheses(NamedTuple):
    """Where an agent may be.

    Args:
        eyes: Where the rays begin and the direction of reference, [3, H], in the map's frame.
        weight: How likely each is, [H]; they sum to one.
    """

    eyes: Float[np.ndarray, "3 H"]
    weight: Float[np.ndarray, " H"]


class Places:
    """Imagined places by what is sensed there.

    Args:
        walls: The map.
        angles: Directions of the rays, [K].
        eyes: Where the agent has been, [3, S].
        seed: Which places around are imagined.
    """

    def __init__(
        self,
        walls: WallMap,
        angles: Float[np.ndarray, " K"],
        eyes: Float[np.ndarray, "3 S"],
        *,
        seed: int = 0,
    ) -> None:
        self.walls, self.angles = walls, jnp.asarray(angles, jnp.float32)
        self.eyes = _imagined(walls, eyes, seed=seed)
        sensors = [self._ranges(part) for part in _chunks(self.eyes)]
        self.tree = cKDTree(np.concatenate(sensors))

    def where(self, sensors: Float[np.ndarray, "N K"]) -> list[Hypotheses]:
        """Where an agent may be that senses this, at most `HYPOTHESES` places for each row."""
        num = min(NEIGHBOURS, self.tree.n)
        _, nearest = self.tree.query(sensors, k=range(1, num + 1))
        near = jnp.asarray(self.eyes[:, nearest], jnp.float32)
        found = _corrected(self.walls, self.angles, near, jnp.asarray(sensors, jnp.float32))
        eyes, mismatch = (np.asarray(part, np.float64) for part in found)
        cases = zip(np.moveaxis(eyes, 1, 0), mismatch, strict=True)
        return [_merged(case, off, self.walls.reach) for case, off in cases]

    def tracked(self, sensors: Float[np.ndarray, " K"], expected: Hypotheses) -> Hypotheses:
        """Where an agent may be that senses this, and should be at one of the places expected.

        Places that nobody expected stay possible: odometry may have been wrong all along.
        """
        row = np.asarray(sensors, np.float64)[None]
        _, nearest = self.tree.query(row, k=range(1, min(NEIGHBOURS, self.tree.n) + 1))
        also = expected.eyes[:, np.arange(HYPOTHESES) % expected.eyes.shape[1]]
        near = np.concatenate([self.eyes[:, nearest[0]], also], axis=1)[:, None]
        found = _corrected(
            self.walls, self.angles, jnp.asarray(near, jnp.float32), jnp.asarray(row, jnp.float32)
        )
        eyes, mismatch = (np.asarray(part, np.float64) for part in found)
        surprise = -_log_prior(eyes[:, 0], expected, self.walls.reach)
        return _merged(eyes[:, 0], mismatch[0] + surprise / SHARPNESS, self.walls.reach)

    def _ranges(self, eyes: Float[np.ndarray, "3 N"]) -> Float[np.ndarray, "N K"]:
        return np.asarray(_ranges(self.walls, jnp.asarray(eyes, jnp.float32), self.angles))


@eqx.filter_jit
def _ranges(walls: WallMap, eyes: Array, angles: Array) -> Array:
    return walls.ranges(eyes, angles)


def _chunks(eyes: Float[np.ndarray, "3 N"]) -> list[Float[np.ndarray, "3 _"]]:
    """The columns in chunks of one size, so that one program serves all; the last is less."""
    stops = range(CHUNK_SIZE, eyes.shape[1], CHUNK_SIZE)
    return np.split(eyes, list(stops), axis=1)


def _imagined(
    walls: WallMap, eyes: Float[np.ndarray, "3 S"], *, seed: int
) -> Float[np.ndarray, "3 N"]:
    """Places in any direction around remembered ones, as far as nothing stands between."""
    random = np.random.default_rng(seed)
    num = PER_MOMENT * eyes.shape[1]
    x, y, _ = eyes[:, random.integers(0, eyes.shape[1], num)]
    bearing, direction = random.uniform(-np.pi, np.pi, (2, num))
    distance = np.hypot(*random.normal(0.0, AROUND * walls.reach, (2, num)))
    ahead = jnp.zeros(1)
    free = np.concatenate(
        [
            np.asarray(_ranges(walls, jnp.asarray(part, jnp.float32), ahead))[:, 0]
            for part in _chunks(np.stack([x, y, bearing]))
        ]
    )
    kept = distance < free
    x, y = x + distance * np.cos(bearing), y + distance * np.sin(bearing)
    return np.stack([x, y, direction])[:, kept]


@eqx.filter_jit
def _corrected(
    walls: WallMap,
    angles: Float[Array, " K"],
    eyes: Float[Array, "3 N k"],
    sensors: Float[Array, "N K"],
) -> tuple[Float[Array, "3 N k"], Float[Array, "N k"]]:
    """Places led to where they sense the readings, as nearly as they get, and their mismatch.

    Gauss-Newton steps on the sum of log(1 + (off / OUTLIER)^2), damped until they help.
    """
    outlier, shape = OUTLIER * walls.reach, eyes.shape[1:]
    scale = DIFFERENCE * jnp.array([walls.reach, walls.reach, 10.0])

    def off(eyes: Float[Array, "3 N k"]) -> Float[Array, "N k K"]:
        seen = walls.ranges(eyes.reshape(3, -1), angles).reshape(*shape, -1)
        return (seen - sensors[:, None]) / outlier

    def mismatch(off: Float[Array, "N k K"]) -> Float[Array, "N k"]:
        return jnp.log1p(off**2).sum(axis=-1)

    def correct(_: Count, now: tuple[Array, Array, Array]) -> tuple[Array, Array, Array]:
        eyes, damping, here = now
        aside = [off(eyes + step[:, None, None]) for step in jnp.diag(scale)]
        slopes = (jnp.stack(aside, axis=-2) - here[..., None, :]) / scale[None, None, :, None]
        weighted = slopes / (1 + here[..., None, :] ** 2)
        normal = jnp.einsum("nkis,nkjs->nkij", weighted, slopes)
        size = jnp.trace(normal, axis1=-2, axis2=-1) + 1e-3
        normal += (damping * size)[..., None, None] * jnp.eye(3)[None, None]
        downhill = jnp.einsum("nkis,nks->nki", weighted, here)[..., None]
        there = eyes - jnp.moveaxis(jnp.linalg.solve(normal, downhill)[..., 0], -1, 0)
        moved = off(there)
        better = mismatch(moved) < mismatch(here)
        damping = jnp.where(better, damping / 10, damping * 10).clip(1e-5, 1e3)
        eyes = jnp.where(better[None], there, eyes)
        return eyes, damping, jnp.where(better[..., None], moved, here)

    begin = eyes, jnp.full(shape, 1e-3), off(eyes)
    eyes, _, here = jax.lax.fori_loop(0, CORRECTIONS, correct, begin)
    return eyes, mismatch(here)


def _log_prior(
    eyes: Float[np.ndarray, "3 k"], expected: Hypotheses, reach: float
) -> Float[np.ndarray, " k"]:
    """How likely odometry leads to each place, up to a constant."""
    x, y, angle = eyes[:, :, None] - expected.eyes[:, None]
    off = (np.hypot(x, y) / (SLIP * reach)) ** 2 + (2 * np.sin(angle / 2) / TWIST) ** 2
    return np.asarray(np.log(UNEXPECTED + np.exp(-off / 2) @ expected.weight))


def _merged(
    eyes: Float[np.ndarray, "3 k"], mismatch: Float[np.ndarray, " k"], reach: float
) -> Hypotheses:
    """The likeliest places; those that are nearly the same count as one."""
    weight = np.exp(-SHARPNESS * (mismatch - mismatch.min()))
    cells = np.round(eyes / (SAME * np.array([[reach], [reach], [1.0]]))).astype(np.int64)
    _, firsts, groups = np.unique(cells, axis=1, return_index=True, return_inverse=True)
    groups = groups.reshape(-1)
    total = np.bincount(groups, weight)
    best = np.argsort(-total)[:HYPOTHESES]
    # The best of each group stands for it.
    order = np.argsort(-weight, kind="stable")
    firsts[groups[order[::-1]]] = order[::-1]
    best = best[total[best] > UNLIKELY * total[best[0]]]
    return Hypotheses(eyes[:, firsts[best]], total[best] / total[best].sum())
