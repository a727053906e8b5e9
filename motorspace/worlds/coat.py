"""The colours of painted walls as arrays, looked up where rays meet them."""

import math
from collections.abc import Sequence

import equinox as eqx
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Float, Int


class Coat(eqx.Module):
    """The colours of S walls: of each a run of `texels`, evenly spaced from its first end on.

    Arrays hold floats, also those of whole numbers, as all arrays of a world do.
    """

    texels: Float[Array, "P 3 *worlds"]
    """Colours, each channel from 0 to 1; those of a wall follow each other."""
    first: Float[Array, "S *worlds"]
    """The row of each wall's first colour."""
    last: Float[Array, "S *worlds"]
    """The row of each wall's last colour but one; of a flat wall that of its only colour."""
    along: Float[Array, "S 3 *worlds"]
    """(a, b, c) of each wall: a x + b y + c is how many texels from its first end (x, y) is."""
    textured: bool = eqx.field(static=True)
    """Whether colours vary along any wall."""

    def colours(
        self, wall: Int[Array, "K *batch"], x: Float[Array, "K *batch"], y: Float[Array, "K *batch"]
    ) -> Float[Array, "K 3 *batch"]:
        """The colours at places on walls, which are given by their numbers."""
        first = _each(self.first, wall).astype(jnp.int32)
        if not self.textured:
            return self._rows(first)
        a, b, c = (_each(self.along[:, n], wall) for n in range(3))
        texel = jnp.maximum(a * x + b * y + c, 0.0)
        last = _each(self.last, wall).astype(jnp.int32)
        row = jnp.minimum(first + texel.astype(jnp.int32), last)
        share = jnp.clip(texel - (row - first).astype(jnp.float32), 0.0, 1.0)[:, None]
        low = self._rows(row)
        return low + share * (self._rows(row + 1) - low)

    def _rows(self, row: Int[Array, "K *batch"]) -> Float[Array, "K 3 *batch"]:
        if self.texels.ndim == 2:
            return jnp.moveaxis(self.texels[row], -1, 1)
        return jnp.stack([_each(self.texels[:, c], row) for c in range(3)], axis=1)


def coat_of(
    walls: Float[np.ndarray, "S 2 2"], colours: Sequence[Float[np.ndarray, "_ 3"]], step: float
) -> Coat:
    """The coat of walls with these colours, `step` world units apart; infinite for flat ones."""
    lengths = np.array([len(of_wall) for of_wall in colours])
    first = np.cumsum(lengths) - lengths
    along = (
        np.diff(walls, axis=1)[:, 0] / np.linalg.norm(walls[:, 1] - walls[:, 0], axis=-1)[:, None]
    )
    slope = along / step
    offset = -(slope * walls[:, 0]).sum(axis=-1)
    return Coat(
        texels=jnp.asarray(np.concatenate(colours), jnp.float32),
        first=jnp.asarray(first, jnp.float32),
        last=jnp.asarray(np.maximum(first, first + lengths - 2), jnp.float32),
        along=jnp.asarray(np.column_stack([slope, offset]), jnp.float32),
        textured=math.isfinite(step),
    )


def _each(values: Float[Array, "S *worlds"], number: Int[Array, "K *batch"]) -> Array:
    """One value for each of the numbers: of the only world, or of each agent's own."""
    if values.ndim == 1:
        return values[number]
    return jnp.take_along_axis(values, number, axis=0)
