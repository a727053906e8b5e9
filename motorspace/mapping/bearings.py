"""Where each ray points, by the readings alone: neighbours read nearly the same, and walls are
straight. Neither commands nor poses are needed, nor the order of the rays.
"""

from typing import NamedTuple

import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np
import optax
from jaxtyping import Array, Bool, Float, Int

from motorspace._errors import UserError
from motorspace._types import Scalar
from motorspace.mapping.mounting import SATURATED
from motorspace.mapping.order import neighbours_in_order

FEWEST_RAYS, FEWEST_WALLS = 16, 100
"""Rays, and stretches of wall that as many neighbouring rays meet, without which it is no use."""
KEPT = "a calibration made on another walk (--calibration FILE)"
"""What to do where walls are out of sight."""
NUM_ORDERING, NUM_SCANS = 2_000, 400
"""Scans that the order of the rays, and their directions, are found by; chosen at random."""
STRETCH = 1 / 4
"""Share of the rays that should meet one wall side by side."""
FEWEST_IN_A_ROW = 6
VIEWS = np.geomspace(0.3, 6.6, 90)
"""Angles between the first ray and the last that are tried, radians."""
TOLERANCES = (0.03, 0.01, 0.005)
"""Relative error of a reading that counts half, one pass after another."""
UPDATES, RATE = 150, 0.02
SMOOTHNESS = 0.3
"""Weight of how much neighbouring spaces between rays differ, squared, as logarithms."""


class _Walls(NamedTuple):
    """Stretches of neighbouring rays, and what they have read.

    Args:
        rays: Which rays each stretch is of, [V, w].
        inverse: One over the readings, [N, V, w].
        met: Whether all rays of a stretch have met something, [N, V].
    """

    rays: Int[Array, "V w"]
    inverse: Float[Array, "N V w"]
    met: Bool[Array, "N V"]


def find_bearings(sensors: Float[np.ndarray, "N K"], *, reach: float) -> Float[np.ndarray, " K"]:
    """The rays' directions; the middle of the view is 0.

    Rays that are neighbours read nearly the same, which gives their order. A wall that is straight
    is at a distance r with 1 / r = a cos(b) + c sin(b) in the direction b; the directions are
    those for which most stretches of neighbouring rays look like that. By convention rays are
    listed counter-clockwise, as those of lasers are: a mirror image is as consistent.

    Args:
        sensors: Readings from many places, lengths along the rays, [N, K].
        reach: The largest reading.

    Returns:
        Radians, [K].

    Raises:
        UserError: For few rays, and for readings in which there are no straight walls.
    """
    num = sensors.shape[1]
    if num < FEWEST_RAYS:
        raise UserError(
            f"{num} rays are too few to show where they point",
            remedy=f"give at least {FEWEST_RAYS} readings for each scan (--num-rays)",
        )
    rows = np.random.default_rng(0).permutation(len(sensors))
    order = neighbours_in_order(sensors[rows[:NUM_ORDERING]], reach=reach)
    walls = _walls(sensors[rows[:NUM_SCANS]][:, order], reach)
    if int(walls.met.sum()) < FEWEST_WALLS:
        raise UserError(
            "hardly ever do neighbouring rays all meet something",
            remedy=f"give a walk with walls in sight, or {KEPT}",
        )
    spaces = _evenly_spaced(walls, num)
    for tolerance in TOLERANCES:
        spaces = _refined(walls, spaces, jnp.float32(tolerance))
    along = np.append(0.0, np.cumsum(np.exp(np.asarray(spaces, np.float64))))
    bearings = np.empty(num)
    bearings[order] = along - along[-1] / 2
    return bearings


def _walls(sensors: Float[np.ndarray, "N K"], reach: float) -> _Walls:
    num = sensors.shape[1]
    length = max(FEWEST_IN_A_ROW, round(STRETCH * num))
    starts = np.arange(0, num - length + 1, max(1, length // 6))
    rays = starts[:, None] + np.arange(length)
    readings = sensors[:, rays]
    met = np.all(readings < SATURATED * reach, axis=-1)
    inverse = reach / np.maximum(readings, 1e-3 * reach)
    return _Walls(jnp.asarray(rays), jnp.asarray(inverse, jnp.float32), jnp.asarray(met))


def _evenly_spaced(walls: _Walls, num: int) -> Float[Array, " S"]:
    """Logarithms of the spaces of the view for which walls are straightest."""
    spaces = np.log(VIEWS / (num - 1))[:, None] * np.ones(num - 1)
    scores = np.asarray(_scores(walls, jnp.asarray(spaces, jnp.float32)))
    best = int(scores.argmax())
    if best in (0, len(VIEWS) - 1):
        raise UserError(
            "the readings do not look like lengths along rays that meet straight walls",
            remedy="give readings of distance, and a walk with walls in sight",
        )
    return jnp.asarray(spaces[best], jnp.float32)


@eqx.filter_jit
def _scores(walls: _Walls, spaces: Float[Array, "C S"]) -> Float[Array, " C"]:
    scores: Array = jax.lax.map(lambda one: _straightness(walls, one, TOLERANCES[1]), spaces)
    return scores


def _straightness(walls: _Walls, spaces: Float[Array, " S"], tolerance: Scalar | float) -> Scalar:
    """How many stretches of neighbouring rays look like a straight wall, as a share."""
    along = jnp.concatenate([jnp.zeros(1), jnp.cumsum(jnp.exp(spaces))])
    angles = along[walls.rays] - along[walls.rays].mean(axis=1, keepdims=True)
    known = jnp.stack([jnp.cos(angles), jnp.sin(angles)], axis=-1)
    across = jnp.swapaxes(known, 1, 2)
    solve = jnp.linalg.inv(across @ known) @ across
    fitted = jnp.einsum("vba,vac,nvc->nvb", known, solve, walls.inverse)
    off = jnp.mean((walls.inverse / jnp.maximum(fitted, 1e-3) - 1) ** 2, axis=-1)
    straight = jnp.where(walls.met, 1 / (1 + off / tolerance**2), 0.0)
    return straight.sum() / jnp.maximum(walls.met.sum().astype(jnp.float32), 1.0)


@eqx.filter_jit
def _refined(walls: _Walls, spaces: Float[Array, " S"], tolerance: Scalar) -> Float[Array, " S"]:
    """Spaces between the rays, each of its own, that make walls straighter."""
    optimiser = optax.adam(RATE)

    def loss(spaces: Float[Array, " S"]) -> Scalar:
        uneven = jnp.mean(jnp.diff(spaces) ** 2)
        return SMOOTHNESS * uneven - _straightness(walls, spaces, tolerance)

    def update(carry: tuple, _: None) -> tuple[tuple, None]:
        spaces, state = carry
        gradient = jax.grad(loss)(spaces)
        with jax.numpy_dtype_promotion("standard"):  # optax counts in whole numbers
            change, state = optimiser.update(gradient, state)
        return (spaces + change, state), None

    begin = spaces, optimiser.init(spaces)
    (found, _), _ = jax.lax.scan(update, begin, length=UPDATES)
    return found
