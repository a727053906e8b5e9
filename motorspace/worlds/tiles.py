"""An index of walls: a uniform grid of tiles, each with the walls around it, nearest first."""

import math
from collections.abc import Callable
from typing import Any, TypeVar

import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Bool, Float, Int

from motorspace._devices import on_accelerator

Batch = Float[Array, "*batch"]
Carry = TypeVar("Carry")

REACH = 10.0
"""How far a tile's list of walls goes, world units: the range of the paper's sensors."""

BLOCK = 8
"""Walls that are looked up at once."""

UNROLL, ACCELERATOR_UNROLL = 4, 16
"""Walls per turn of a loop over walls, on a CPU and on a device that launches each operation."""

GROUP, ACCELERATOR_GROUP = 128, 16_384
"""Agents that look for walls together: until the last of them has found what matters."""

FAR_AWAY = 1e6
"""Where the walls lie that fill up the last block, world units."""


class Tiles(eqx.Module):
    """The walls within `reach` of every tile, in blocks of `BLOCK`; world units.

    Tile (i, j) covers `side` x `side` from `corner` + (i, j) `side` on. Memory grows with the
    number of tiles and with the walls around the most crowded one.
    """

    walls: Float[Array, "G B W"]
    """End points of every tile's walls, block by block, W = 4 `BLOCK` numbers each."""
    numbers: Float[Array, "G B N"]
    """The number of every wall among all, N = `BLOCK`; floats, -1 for what fills up a block."""
    gaps: Float[Array, "G B"]
    """No wall of a block is nearer to any point of the tile than this."""
    corner: tuple[float, float] = eqx.field(static=True)
    side: float = eqx.field(static=True)
    num_tiles: tuple[int, int] = eqx.field(static=True)
    reach: float = eqx.field(static=True)

    def fold(
        self,
        visit: Callable[[Carry, Any], Carry],
        start: Carry,
        place: tuple[Batch, Batch],
        horizon: Callable[[Carry], Batch],
        *,
        numbered: bool = False,
    ) -> Carry:
        """`visit` folded over the walls around each place, block by block, all agents at once.

        `visit` gets a wall per agent, [2, 2, *batch]; if they are `numbered`, the wall and its
        number. `horizon` says how far a wall can be and
        still change what was found; it must stay below `reach`. Once nobody's next block is that
        near, the rest cannot matter.
        """
        tile = self._tile(*place)
        gaps, walls = self.gaps[tile], self.walls

        def matters(carry: tuple[Int[Array, ""], Carry]) -> Bool[Array, ""]:
            block, found = carry
            near = gaps[..., jnp.minimum(block, gaps.shape[-1] - 1)] <= horizon(found)
            return (block < gaps.shape[-1]) & jnp.any(near)

        def visit_block(carry: tuple[Int[Array, ""], Carry]) -> tuple[Int[Array, ""], Carry]:
            block, found = carry
            numbers = jnp.moveaxis(walls[tile, block], -1, 0)
            visited: Any = numbers.reshape(BLOCK, 2, 2, *tile.shape)
            if numbered:
                visited = visited, jnp.moveaxis(self.numbers[tile, block], -1, 0)
            found, _ = jax.lax.scan(
                lambda found, wall: (visit(found, wall), None), found, visited, unroll=unroll()
            )
            return block + 1, found

        return jax.lax.while_loop(matters, visit_block, (jnp.zeros((), jnp.int32), start))[1]

    def _tile(self, x: Batch, y: Batch) -> Int[Array, "*batch"]:
        nx, ny = self.num_tiles
        column = ((x - self.corner[0]) / self.side).astype(jnp.int32).clip(0, nx - 1)
        row = ((y - self.corner[1]) / self.side).astype(jnp.int32).clip(0, ny - 1)
        return column * ny + row


def unroll() -> int:
    """Walls per turn of a loop over walls."""
    return ACCELERATOR_UNROLL if on_accelerator() else UNROLL


def in_groups(work: Callable[..., Array], batch: tuple[int, ...], *agents: Any) -> Array:
    """`work(*agents)`, group by group; `batch` is the shape of the agents' axes, the last."""
    num, group = math.prod(batch), ACCELERATOR_GROUP if on_accelerator() else GROUP
    if num <= group:
        return work(*agents)
    num_groups = -(-num // group)

    def split(leaf: Array) -> Array:
        flat = leaf.reshape(*leaf.shape[: leaf.ndim - len(batch)], num)
        padding = [(0, 0)] * (flat.ndim - 1) + [(0, num_groups * group - num)]
        flat = jnp.pad(flat, padding, mode="edge")
        return jnp.moveaxis(flat.reshape(*flat.shape[:-1], num_groups, group), -2, 0)

    done = jax.lax.map(lambda agents: work(*agents), jax.tree.map(split, agents))
    joined = jnp.moveaxis(done, 0, -2)
    return joined.reshape(*joined.shape[:-2], -1)[..., :num].reshape(*joined.shape[:-2], *batch)


def tiled(walls: Float[np.ndarray, "S 2 2"], bounds: tuple[float, float, float, float]) -> Tiles:
    """The index of some walls in a rectangle (x low, y low, x high, y high)."""
    x_low, y_low, x_high, y_high = bounds
    width, height = x_high - x_low, y_high - y_low
    side = max(math.sqrt(width * height / len(walls)), REACH / 4)
    nx, ny = max(1, math.ceil(width / side)), max(1, math.ceil(height / side))
    # Rounding may put a place into the next tile: the bounds are a little lower than need be.
    half_diagonal = side / math.sqrt(2) + 1e-3
    middles_y = y_low + side * (np.arange(ny) + 0.5)
    lists = []
    for column in range(nx):
        x = x_low + side * (column + 0.5)
        near_x = (walls[..., 0].min(1) < x + side + REACH) & (
            walls[..., 0].max(1) > x - side - REACH
        )
        ids = np.flatnonzero(near_x)
        middles = np.stack([np.full(ny, x), middles_y], axis=1)
        gaps = np.maximum(_distances(middles, walls[ids]) - half_diagonal, 0.0)
        for gap in gaps:
            order = np.argsort(gap, kind="stable")
            order = order[gap[order] <= REACH]
            lists.append((ids[order], gap[order]))
    num_blocks = max(1, *(-(-len(ids) // BLOCK) for ids, _ in lists))
    ends = np.full((len(lists), num_blocks * BLOCK, 4), FAR_AWAY, np.float32)
    ends[..., 2] += 1.0
    nearest = np.full((len(lists), num_blocks * BLOCK), np.inf, np.float32)
    numbers = np.full((len(lists), num_blocks * BLOCK), -1.0, np.float32)
    for tile, (ids, gap) in enumerate(lists):
        ends[tile, : len(ids)] = walls[ids].reshape(-1, 4)
        nearest[tile, : len(ids)] = gap
        numbers[tile, : len(ids)] = ids
    return Tiles(
        jnp.asarray(ends.reshape(len(lists), num_blocks, BLOCK * 4)),
        jnp.asarray(numbers.reshape(len(lists), num_blocks, BLOCK)),
        jnp.asarray(nearest[:, ::BLOCK]),
        corner=(x_low, y_low),
        side=side,
        num_tiles=(nx, ny),
        reach=REACH,
    )


def _distances(
    points: Float[np.ndarray, "P 2"], walls: Float[np.ndarray, "S 2 2"]
) -> Float[np.ndarray, "P S"]:
    """Distances of points from segments."""
    start, along = walls[:, 0], walls[:, 1] - walls[:, 0]
    offset = points[:, None] - start
    share = np.clip((offset * along).sum(-1) / (along**2).sum(-1), 0.0, 1.0)
    return np.linalg.norm(offset - share[..., None] * along, axis=-1)
