"""Displacements between views that nothing is known of: both as images, correlated.

For every rotation of the second view one Fourier transform gives its overlap with the first at all
shifts (correlative matching; Olson, 2009).
"""

from typing import NamedTuple

import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Complex, Float, Int

from motorspace.mapping.views import FAR, Views
from motorspace.se2 import wrap

CELL = 0.08
"""Side of a cell, share of the reach."""
NUM_CELLS = 32
"""Cells in a row: views are cut off at 1.28 times the reach."""
NUM_TURNS = 30
BLUR = 0.8
"""Standard deviation of a point in the first view's image, cells."""
CHUNK_SIZE = 256
AT_ONCE = 8
OUTSIDE = 2 * NUM_CELLS - 1


class Window(NamedTuple):
    """How far around a guess is searched: share of the reach, radians."""

    shift: float
    turn: float


class Images(NamedTuple):
    """Fourier transforms of views as images.

    Args:
        first: Blurred, [V, 2 C, C + 1].
        second: Conjugate, for every rotation, [V, R, 2 C, C + 1].
        num_cells: Cells that the rotated views fill, [V, R].
    """

    first: Complex[Array, "V W H"]
    second: Complex[Array, "V R W H"]
    num_cells: Float[Array, "V R"]


def images(views: Views, *, reach: float) -> Images:
    """The views as images of a fixed size."""
    first, second, num_cells = _images(jnp.asarray(views.in_reaches(reach), jnp.float32))
    return Images(first, second, num_cells)


def search(
    seen: Images,
    pairs: Int[np.ndarray, "2 E"],
    guess: Float[np.ndarray, "3 E"],
    window: Window,
    *,
    reach: float,
) -> tuple[Float[np.ndarray, "3 E"], Float[np.ndarray, " E"]]:
    """The displacement of each pair at which the views overlap most, and by what share.

    Args:
        seen: The views.
        pairs: The view that stays and the view that is moved, [2, E].
        guess: Middle of the search, [3, E].
        window: How far around.
        reach: The largest reading.
    """
    num = pairs.shape[1]
    size = -(-max(num, 1) // CHUNK_SIZE) * CHUNK_SIZE
    scale = np.array([reach, reach, 1.0])
    padded, middle = np.zeros((2, size), np.int32), np.zeros((size, 3), np.float32)
    padded[:, :num], middle[:num] = pairs, guess.T / scale
    limits = jnp.asarray(window, jnp.float32)
    found, overlap = [], []
    for start in range(0, size, CHUNK_SIZE):
        rows = slice(start, start + CHUNK_SIZE)
        best = _search(seen, jnp.asarray(padded[:, rows]), jnp.asarray(middle[rows]), limits)
        found.append(np.asarray(best[0], np.float64))
        overlap.append(np.asarray(best[1], np.float64))
    return (np.concatenate(found)[:num] * scale).T, np.concatenate(overlap)[:num]


@eqx.filter_jit
def _images(points: Float[Array, "V P 2"]) -> tuple[Array, Array, Array]:
    near = jnp.arange(-2.0, 3.0) / BLUR
    kernel = jnp.exp(-(near[:, None] ** 2 + near[None] ** 2) / 2)
    turns = jnp.arange(NUM_TURNS, dtype=jnp.float32) * (2 * jnp.pi / NUM_TURNS)

    def image(points: Float[Array, "P 2"]) -> Float[Array, "W W"]:
        cells = jnp.round(points / CELL).astype(jnp.int32) + NUM_CELLS // 2
        inside = jnp.all((cells >= 0) & (cells < NUM_CELLS), axis=-1)
        rows, columns = jnp.where(inside[:, None], cells, OUTSIDE).T
        blank = jnp.zeros((2 * NUM_CELLS, 2 * NUM_CELLS))
        return blank.at[rows, columns].set(1.0).at[OUTSIDE, OUTSIDE].set(0.0)

    def of_view(points: Float[Array, "P 2"]) -> tuple[Array, Array, Array]:
        x, y = points.T
        exists = x < FAR / 2

        def turned(angle: Float[Array, ""]) -> Float[Array, "W W"]:
            cos, sin = jnp.cos(angle), jnp.sin(angle)
            moved = jnp.stack([cos * x - sin * y, sin * x + cos * y], axis=-1)
            return image(jnp.where(exists[:, None], moved, FAR))

        blurred = jax.scipy.signal.convolve2d(turned(jnp.zeros(())), kernel, mode="same")
        rotated = jax.vmap(turned)(turns)
        spectra = jnp.conj(jnp.fft.rfft2(rotated))
        return jnp.fft.rfft2(jnp.minimum(blurred, 1.0)), spectra, rotated.sum(axis=(1, 2))

    found: tuple[Array, Array, Array] = jax.lax.map(of_view, points, batch_size=AT_ONCE)
    return found


@eqx.filter_jit
def _search(
    seen: Images,
    pairs: Int[Array, "2 E"],
    guess: Float[Array, "E 3"],
    limits: Float[Array, "2"],
) -> tuple[Float[Array, "E 3"], Float[Array, " E"]]:
    shifts = jnp.fft.fftfreq(2 * NUM_CELLS, 1 / (2 * NUM_CELLS)) * CELL
    turns = jnp.arange(NUM_TURNS, dtype=jnp.float32) * (2 * jnp.pi / NUM_TURNS)

    def one(case: tuple[Array, Array, Array]) -> tuple[Array, Array]:
        first, second, middle = case
        product = seen.first[first][None] * seen.second[second]
        overlap = jnp.fft.irfft2(product, s=(2 * NUM_CELLS, 2 * NUM_CELLS))
        overlap /= jnp.maximum(seen.num_cells[second], 1.0)[:, None, None]
        away = jnp.hypot(shifts[:, None] - middle[0], shifts[None] - middle[1]) > limits[0]
        turn = wrap(turns - middle[2])
        outside = away[None] | (jnp.abs(turn) > limits[1])[:, None, None]
        overlap = jnp.where(outside, -1.0, overlap)
        best = jnp.argmax(overlap)
        angle, row, column = jnp.unravel_index(best, overlap.shape)
        place = jnp.stack([shifts[row], shifts[column], wrap(turns[angle])])
        return place, jnp.max(overlap)

    found: tuple[Array, Array] = jax.lax.map(one, (*pairs, guess), batch_size=AT_ONCE)
    return found
