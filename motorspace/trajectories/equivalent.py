"""Motor sequences that differ and yet lead to the same displacement, by exact construction."""

import math
from collections.abc import Callable
from typing import NamedTuple

import equinox as eqx
import jax
import numpy as np
from jaxtyping import Array, Float, Int
from jaxtyping import Key as KeyArray

from motorspace._errors import UserError
from motorspace._types import Key
from motorspace.worlds.agents import AbstractAgent, ForwardAgent, HolonomicAgent

BodyAgent = ForwardAgent | HolonomicAgent
Commands = Float[np.ndarray, "G E L M"]
"""For each of G groups E ways of L commands that do the same."""

TURNING = 4
"""Commands over which a rotation is spread that may go around more than once."""


class EquivalentSequences(NamedTuple):
    """N motor sequences in groups of equal nominal displacement, at the agent's full horizon."""

    motors: Float[np.ndarray, "N T M"]
    groups: Int[np.ndarray, " N"]
    kinds: Int[np.ndarray, " N"]
    """What the members of a group differ in: an index into `names`."""
    full_turns: Int[np.ndarray, " N"]
    """Whole turns that a sequence makes more than the group's own rotation needs."""
    names: tuple[str, ...]


def equivalent_sequences(
    agent: AbstractAgent, *, num_groups: int, members: int = 8, horizon: int, key: Key
) -> EquivalentSequences:
    """`num_groups` groups of each kind that the agent's body and the horizon allow.

    The members of a group share all commands but a few neighbouring ones, which differ in:

    - `split`: how a rotation is shared out among commands without translation,
    - `permuted`: how a translation is shared out among commands without rotation,
    - `full turns`: the same, and whole turns that are added to the rotation,
    - `undone`: a way that is gone and then gone back (a forward agent has to turn round),
    - `head`: how an orientation is shared out between body and head, and where the head pointed
      in between (holonomic agent with `head_rule="set"`).

    Raises `UserError` for an agent of another body, and when no kind fits into the horizon.
    """
    if not isinstance(agent, ForwardAgent | HolonomicAgent):
        raise UserError(
            f"equivalent sequences of a {type(agent).__name__} are not constructed",
            remedy="group its sequences by their displacements",
        )
    draw_key, rng_key = jax.random.split(key)
    rng = np.random.default_rng(np.asarray(jax.random.key_data(rng_key)))
    size = (num_groups, members)
    made = {name: block(agent, rng, size, horizon) for name, block in BLOCKS.items()}
    found = {n: b for n, b in made.items() if b is not None and b.commands.shape[2] <= horizon}
    if not found:
        raise UserError(
            f"no two sequences of {horizon} commands are known to lead to the same place",
            remedy="ask for a longer horizon",
        )
    sequences, turns = [], []
    for name, key in zip(found, jax.random.split(draw_key, len(found)), strict=True):
        block = found[name]
        context = np.array(
            explored(agent, jax.random.split(key, (num_groups, horizon))), np.float64
        )
        sequences.append(_placed(block.commands, context, rng, last=name == "head"))
        turns.append(block.full_turns)
    each = num_groups * members
    return EquivalentSequences(
        np.concatenate(sequences).reshape(len(found) * each, horizon, -1),
        np.repeat(np.arange(len(found) * num_groups), members),
        np.repeat(np.arange(len(found)), each),
        np.concatenate(turns).ravel(),
        tuple(found),
    )


class _Block(NamedTuple):
    commands: Commands
    full_turns: Int[np.ndarray, "G E"]


_Size = tuple[int, int]
_Maker = Callable[[BodyAgent, np.random.Generator, _Size, int], _Block | None]


def _split(agent: BodyAgent, rng: np.random.Generator, size: _Size, horizon: int) -> _Block:
    length = min(3, horizon)
    total = _angles(rng, size) * min(1.0, length * agent.max_rotation / math.pi)
    total = np.broadcast_to(total, size)
    commands = _still(agent, rng, size, length)
    commands[..., 0] = _shares(rng, total, length, -agent.max_rotation, agent.max_rotation)
    commands[:, :, -1, 1:] = _random_moves(agent, rng, size)
    return _Block(commands, np.zeros(size, int))


def _permuted(agent: BodyAgent, rng: np.random.Generator, size: _Size, horizon: int) -> _Block:
    length = min(3, horizon)
    commands = _still(agent, rng, size, length)
    commands[:, :, 0, 0] = rng.uniform(-1, 1, (size[0], 1)) * agent.max_rotation
    for channel, lowest in _translations(agent):
        total = np.broadcast_to(rng.uniform(lowest, 1.0, (size[0], 1)) * length, size)
        commands[..., channel] = _shares(rng, total, length, lowest, 1.0)
    return _Block(commands, np.zeros(size, int))


def _full_turns(
    agent: BodyAgent, rng: np.random.Generator, size: _Size, horizon: int
) -> _Block | None:
    length = min(TURNING, horizon)
    reach = length * agent.max_rotation
    total = _angles(rng, size)
    possible = np.arange(-length, length + 1)
    allowed = np.abs(total + 2 * math.pi * possible) <= reach
    several = allowed.sum(axis=1) > 1
    if not several.any():
        return None
    # Groups whose rotation can be reached in one way only are replaced by ones that have more.
    kept = np.resize(np.flatnonzero(several), size[0])
    total, allowed = total[kept], allowed[kept]
    chosen = (rng.random((*size, len(possible))) * allowed[:, None]).argmax(axis=-1)
    turns = possible[chosen]
    commands = _still(agent, rng, size, length)
    around = total + 2 * math.pi * turns
    commands[..., 0] = _shares(rng, around, length, -agent.max_rotation, agent.max_rotation)
    commands[:, :, -1, 1:] = _random_moves(agent, rng, size)
    fewest = np.abs(total + 2 * math.pi * possible).argmin(axis=1)
    return _Block(commands, turns - possible[fewest][:, None])


def _undone(agent: BodyAgent, rng: np.random.Generator, size: _Size, horizon: int) -> _Block | None:
    if isinstance(agent, HolonomicAgent):
        commands = _still(agent, rng, size, 3)
        commands[:, :, 0, 0] = rng.uniform(-1, 1, (size[0], 1)) * agent.max_rotation
        there = rng.uniform(-1, 1, (*size, 2))
        commands[:, :, 1, 1:3], commands[:, :, 2, 1:3] = there, -there
        return _Block(commands, np.zeros(size, int))
    half = math.ceil(math.pi / agent.max_rotation - 1e-9)
    length = 1 + 2 * half
    if length > horizon:
        return None
    limits = -agent.max_rotation, agent.max_rotation
    total, aside = _angles(rng, size), rng.uniform(*limits, size)
    commands = _still(agent, rng, size, length)
    commands[:, :, 0, 0] = aside
    # Ahead, half a turn, as far back.
    commands[:, :, [0, half], 1] = rng.random((*size, 1))
    commands[:, :, 1 : 1 + half, 0] = _shares(rng, np.full(size, math.pi), half, *limits)
    back = (total - aside + 2 * math.pi) % (2 * math.pi) - math.pi
    commands[:, :, 1 + half :, 0] = _shares(rng, back, half, *limits)
    return _Block(commands, np.zeros(size, int))


def _head(agent: BodyAgent, rng: np.random.Generator, size: _Size, horizon: int) -> _Block | None:
    if not isinstance(agent, HolonomicAgent) or agent.head_rule != "set" or horizon < 2:
        return None
    commands = _still(agent, rng, size, 2)
    commands[:, :, 0] = rng.uniform(-1, 1, (size[0], 1, 4)) * agent.motor_scale
    commands[:, :, 0, 3] = rng.uniform(-1, 1, size) * agent.motor_scale[3]
    bound = min(agent.max_rotation, agent.motor_scale[3])
    total = np.broadcast_to(rng.uniform(-1, 1, (size[0], 1)) * bound, size)
    commands[:, :, 1, [0, 3]] = _shares(rng, total, 2, -bound, bound)
    return _Block(commands, np.zeros(size, int))


BLOCKS: dict[str, _Maker] = {
    "split": _split,
    "permuted": _permuted,
    "full turns": _full_turns,
    "undone": _undone,
    "head": _head,
}


def _angles(rng: np.random.Generator, size: _Size) -> Float[np.ndarray, "G 1"]:
    """A rotation for each group, radians."""
    return rng.uniform(-math.pi, math.pi, (size[0], 1))


def _still(agent: BodyAgent, rng: np.random.Generator, size: _Size, length: int) -> Commands:
    """Commands that move nothing but a head, which all members of a group move alike."""
    commands = np.zeros((*size, length, len(agent.motor_scale)))
    if isinstance(agent, HolonomicAgent):
        head = rng.uniform(-1, 1, (size[0], 1, length)) * agent.motor_scale[3]
        commands[..., 3] = head
    return commands


def _translations(agent: BodyAgent) -> tuple[tuple[int, float], ...]:
    """The channels that translate, and the least that each can be told."""
    return ((1, 0.0),) if isinstance(agent, ForwardAgent) else ((1, -1.0), (2, -1.0))


def _random_moves(agent: BodyAgent, rng: np.random.Generator, size: _Size) -> np.ndarray:
    """What one command of each group does beside turning the body, the same for all members."""
    if isinstance(agent, ForwardAgent):
        return rng.random((size[0], 1, 1))
    return rng.uniform(-1, 1, (size[0], 1, 3)) * agent.motor_scale[1:]


def _shares(
    rng: np.random.Generator, total: np.ndarray, count: int, low: float, high: float
) -> np.ndarray:
    """Random numbers from `low` to `high`, `count` of them for each `total` that they add up to.

    Equal shares and a deviation from them, scaled down where it would leave the limits.
    """
    equal = (total / count)[..., None]
    deviation = rng.uniform(low, high, (*total.shape, count))
    deviation -= deviation.mean(axis=-1, keepdims=True)
    room = np.where(deviation > 0, high - equal, equal - low) / np.maximum(np.abs(deviation), 1e-9)
    return np.asarray(equal + deviation * np.minimum(1.0, room.min(axis=-1, keepdims=True)))


def _placed(
    blocks: Commands, context: Float[np.ndarray, "G T M"], rng: np.random.Generator, *, last: bool
) -> Float[np.ndarray, "G E T M"]:
    """Each block written over the random commands of its group, anywhere or at the end."""
    groups, members, length, _ = blocks.shape
    free = context.shape[1] - length
    offsets = np.full(groups, free) if last else rng.integers(free + 1, size=groups)
    sequences = np.repeat(context[:, None], members, axis=1)
    for group, offset in enumerate(offsets):
        sequences[group, :, offset : offset + length] = blocks[group]
    return sequences


@eqx.filter_jit
def explored(agent: AbstractAgent, keys: KeyArray[Array, "N T"]) -> Float[Array, "N T M"]:
    """Commands as the agent explores with, walls aside: one for each key."""
    return jax.vmap(jax.vmap(lambda key: agent.draw(key=key)))(keys)
