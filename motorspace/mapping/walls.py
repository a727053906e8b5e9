"""Remembered walls: a line in each cell where rays have ended, and what is seen of them."""

import math

import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Float

CELL = 0.02
"""Side of the cells, share of the sensors' reach."""
STRIDE = 0.01
"""How far a ray is followed at once, share of the reach."""
GRAIN = 0.002
"""Ends of rays nearer than this count once, so that a line extends as far as they are spread."""
EXTENT = 1.8
"""Half the length of evenly spread points, in standard deviations."""
SLACK = 0.005
"""By how much a line is longer at each end, share of the reach."""


MANY, FEW = 4_096, 256
"""Straight ways that are looked along at once, so that few programs are compiled."""


class WallMap(eqx.Module):
    """Walls as rays have met them; one array, and nothing trained.

    Args:
        lines: [W, H, 6], for each cell: normal (x, y) and offset of its line, the middle of the
            wall along it, half its length, and 1 where there is any.
        low: Corner of the first cell, [2].
        cell: Side of a cell.
        reach: The reading of a ray that meets nothing.
    """

    lines: Float[Array, "W H 6"]
    low: Float[Array, "2"]
    cell: float = eqx.field(static=True)
    reach: float = eqx.field(static=True)

    def ranges(self, eyes: Float[Array, "3 N"], angles: Float[Array, " K"]) -> Float[Array, "N K"]:
        """What is sensed with rays at these angles from where they begin (x, y, direction)."""
        x, y, direction = eyes
        ray = direction[:, None] + angles[None]
        cos, sin = jnp.cos(ray), jnp.sin(ray)
        x, y = (jnp.broadcast_to(axis[:, None], ray.shape) for axis in (x, y))
        stride = STRIDE * self.reach

        def line_at(distance: Float[Array, ""]) -> Float[Array, "N K 6"]:
            places = x + cos * distance - self.low[0], y + sin * distance - self.low[1]
            columns, rows = ((place / self.cell).astype(jnp.int32) for place in places)
            width, height, _ = self.lines.shape
            flat = columns.clip(0, width - 1) * height + rows.clip(0, height - 1)
            return self.lines.reshape(-1, 6)[flat]

        def met(line: Float[Array, "N K 6"], near: Float[Array, ""]) -> Float[Array, "N K"]:
            normal_x, normal_y, offset, middle, half, exists = jnp.moveaxis(line, -1, 0)
            towards = normal_x * cos + normal_y * sin
            gap = offset - normal_x * x - normal_y * y
            distance = gap / jnp.where(jnp.abs(towards) < 1e-6, 1e-6, towards)
            along = normal_y * (x + cos * distance) - normal_x * (y + sin * distance)
            there = (distance >= near - 1e-3) & (distance <= near + stride + 1e-3)
            there &= (exists > 0) & (jnp.abs(along - middle) <= half)
            return jnp.where(there, distance, jnp.inf)

        def follow(carry: tuple[Array, Array], near: Float[Array, ""]) -> tuple[tuple, None]:
            found, here = carry
            ahead = line_at(near + stride)
            nearest = jnp.minimum(met(here, near), met(ahead, near))
            return (jnp.minimum(found, nearest), ahead), None

        nothing = jnp.full(ray.shape, self.reach)
        strides = jnp.arange(math.ceil(1 / STRIDE), dtype=jnp.float32) * stride
        (found, _), _ = jax.lax.scan(follow, (nothing, line_at(jnp.zeros(()))), strides)
        return found.clip(0.0, self.reach)


def map_walls(points: Float[np.ndarray, "2 P"], *, reach: float) -> WallMap:
    """The walls that rays have met which ended at these points."""
    cell = CELL * reach
    grains = np.round(points / (GRAIN * reach)).astype(np.int64)
    points = points[:, np.unique(grains, axis=1, return_index=True)[1]]
    low = points.min(axis=1) - 2 * cell
    width, height = np.ceil((points.max(axis=1) + 2 * cell - low) / cell).astype(int)
    column, row = ((points - low[:, None]) / cell).astype(int)
    flat = column * height + row
    count = np.bincount(flat, minlength=width * height)

    def mean(values: Float[np.ndarray, " P"]) -> Float[np.ndarray, " C"]:
        return np.bincount(flat, values, width * height) / np.maximum(count, 1)

    middle_x, middle_y = (mean(axis) for axis in points)
    dx, dy = points[0] - middle_x[flat], points[1] - middle_y[flat]
    xx, xy, yy = mean(dx * dx), mean(dx * dy), mean(dy * dy)
    angle = np.arctan2(2 * xy, xx - yy) / 2
    cos, sin = np.cos(angle), np.sin(angle)
    along = np.maximum(xx * cos**2 + 2 * xy * cos * sin + yy * sin**2, 0.0)
    lines = [
        -sin,
        cos,
        cos * middle_y - sin * middle_x,
        cos * middle_x + sin * middle_y,
        EXTENT * np.sqrt(along) + SLACK * reach,
        count > 0,
    ]
    grid = np.stack(lines, axis=-1).reshape(width, height, 6)
    return WallMap(jnp.asarray(grid, jnp.float32), jnp.asarray(low, jnp.float32), cell, reach)


def clearance(
    walls: WallMap, starts: Float[np.ndarray, "2 *batch"], ends: Float[np.ndarray, "2 *batch"]
) -> Float[np.ndarray, "*batch"]:
    """How far behind the end of each straight way the first wall stands; below zero before it."""
    shape = starts.shape[1:]
    (x, y), (dx, dy) = starts.reshape(2, -1), (ends - starts).reshape(2, -1)
    num = len(x)
    size = MANY if num > FEW else FEW
    eyes = np.pad(np.stack([x, y, np.arctan2(dy, dx)]), ((0, 0), (0, -num % size)), mode="edge")
    chunks = np.split(eyes.astype(np.float32), eyes.shape[1] // size, axis=1)
    clear = np.concatenate([np.asarray(_ahead(walls, jnp.asarray(chunk))) for chunk in chunks])
    return np.asarray((clear[:num] - np.hypot(dx, dy)).reshape(shape), np.float64)


@eqx.filter_jit
def _ahead(walls: WallMap, eyes: Float[Array, "3 N"]) -> Float[Array, " N"]:
    return walls.ranges(eyes, jnp.zeros(1))[:, 0]
