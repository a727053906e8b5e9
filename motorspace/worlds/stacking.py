"""Many walled worlds as one, for sampling and training in all of them at once."""

from collections.abc import Sequence

import jax
import jax.numpy as jnp
from jaxtyping import Array, Float

from motorspace._errors import UserError
from motorspace.worlds.coat import Coat
from motorspace.worlds.simulation import to_agents_last
from motorspace.worlds.world import AbstractWorld, WalledWorld


def stack_worlds(worlds: Sequence[AbstractWorld]) -> WalledWorld:
    """Return worlds of any sizes as one, whose arrays have a leading axis: one entry a world.

    Worlds with fewer walls are padded with copies of a wall that they have, and with edges of
    no length among their solids. A wall that is met twice changes no distance and no crossing,
    so every world answers as it did alone, bit for bit.

    Use the result under `jax.vmap`, or take world `i` out of it with
    `jax.tree.map(lambda leaf: leaf[i], stacked)`. It has no index of walls (`tiles`): each query
    visits all of them.

    Args:
        worlds: One or more, each with walls.

    Raises:
        UserError: For no worlds, or for one that is no `WalledWorld`.

    Example:
        Free places in two layouts at once, one key for each:

        >>> from motorspace.worlds.layouts import layout
        >>> worlds = stack_worlds([layout("paper"), layout("empty")])
        >>> worlds.walls.shape
        (2, 40, 2, 2)
        >>> keys = jax.random.split(jax.random.key(0), 2)
        >>> jax.vmap(lambda world, key: world.place(key=key))(worlds, keys).x.shape
        (2,)
    """
    walled = [world for world in worlds if isinstance(world, WalledWorld)]
    if not worlds or len(walled) < len(worlds):
        kinds = ", ".join(type(world).__name__ for world in worlds) or "none"
        raise UserError(
            f"only walled worlds can be stacked, one or more, not {kinds}",
            remedy="give worlds of layouts",
        )
    num_walls = max(len(world.walls) for world in walled)
    num_edges = max(len(world.solids) for world in walled)
    coats = _padded_coats(walled, num_walls)
    padded = [
        _padded(world, num_walls, num_edges, coat)
        for world, coat in zip(walled, coats, strict=True)
    ]
    return jax.tree.map(lambda *leaves: jnp.asarray(leaves, jnp.float32), *padded)


def deal_worlds(worlds: Sequence[AbstractWorld], num_agents: int) -> WalledWorld:
    """Return one world whose arrays hold a world for each agent, in the last axis.

    Agent i is in world `i % len(worlds)`. All that takes agents in the last axis takes this world:
    moves, sensors, free places.

    Args:
        worlds: One or more, each with walls.
        num_agents: How many agents there are (N).

    Raises:
        UserError: As `stack_worlds`.

    Example:
        >>> from motorspace.worlds.layouts import layout
        >>> deal_worlds([layout("paper"), layout("empty")], 6).walls.shape
        (40, 2, 2, 6)
    """
    stacked = stack_worlds(worlds)
    rows = jnp.arange(num_agents) % len(worlds)
    return to_agents_last(jax.tree.map(lambda leaf: leaf[rows], stacked))


def _padded(world: WalledWorld, num_walls: int, num_edges: int, coat: Coat | None) -> WalledWorld:
    walls = _lengthened(world.walls, num_walls)
    edges = jnp.zeros((num_edges - len(world.solids), 2, 2), jnp.float32)
    solids = jnp.concatenate([world.solids, edges])
    return WalledWorld(walls, solids, world.bounds, coat=coat)


def _padded_coats(worlds: Sequence[WalledWorld], num_walls: int) -> list[Coat | None]:
    """The worlds' colours in arrays of the same sizes; none if there are walls without any."""
    coats = [world.coat for world in worlds if world.coat is not None]
    if len(coats) < len(worlds):
        return [None] * len(worlds)
    num_texels = max(len(coat.texels) for coat in coats)
    textured = any(coat.textured for coat in coats)
    return [
        Coat(
            texels=_lengthened(coat.texels, num_texels),
            first=_lengthened(coat.first, num_walls),
            last=_lengthened(coat.last, num_walls),
            along=_lengthened(coat.along, num_walls),
            textured=textured,
        )
        for coat in coats
    ]


def _lengthened(rows: Float[Array, "N ..."], num: int) -> Float[Array, "M ..."]:
    """The rows, and copies of the first one, so that there are `num` of them."""
    return jnp.concatenate([rows, jnp.repeat(rows[:1], num - len(rows), axis=0)])
