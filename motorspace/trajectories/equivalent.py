"""Motor sequences that differ and yet lead to the same displacement, by exact construction."""

import math
from collections.abc import Callable
from typing import NamedTuple

import jax
import numpy as np
from jaxtyping import Float, Int

from motorspace._errors import UserError
from motorspace._types import Key
from motorspace.trajectories.commands import nominal, random_commands
from motorspace.worlds.agents import AbstractAgent
from motorspace.worlds.spaces import ContinuousCommands

Commands = Float[np.ndarray, "G E L M"]
"""For each of G groups E ways of L commands that do the same."""

TURNING = 4
"""Commands over which a rotation is spread that may go around more than once."""

TOLERANCE = 1e-3
"""Equal displacements differ by less: the rounding of float32, world units and radians."""


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
    """Motor sequences in groups that lead to the same displacement, of each kind that fits.

    The members of a group share all commands but a few neighbouring ones, which differ in:

    - `split_rotation`: how a rotation is shared out among commands without translation,
    - `split_translation`: how a translation is shared out among commands without rotation,
    - `full_turns`: how a rotation is shared out, and whole turns that are added to it,
    - `undone`: a way that is gone and then gone back (an agent that cannot move backwards has to
      turn round),
    - `head`: how an orientation is shared out between body and head, and where the head pointed
      in between (where commands set the head).

    A kind is left out where the horizon is too short, the agent has no channels for it, or its
    body does something else with them than to turn first and to translate then.

    Args:
        agent: The agent whose commands they are.
        num_groups: Groups of each kind.
        members: Sequences of each group.
        horizon: Commands of each sequence.
        key: Source of randomness.

    Returns:
        N = kinds x groups x members sequences.

    Raises:
        UserError: For an agent whose commands do not say which channels turn it, and when no kind
            fits into the horizon.
    """
    draw_key, rng_key = jax.random.split(key)
    body = _Body(
        _turning_commands(agent), np.random.default_rng(np.asarray(jax.random.key_data(rng_key)))
    )
    size = (num_groups, members)
    made = {name: block(body, size, horizon) for name, block in BLOCKS.items()}
    found = {n: b for n, b in made.items() if b is not None and b.commands.shape[2] <= horizon}
    sequences = {}
    for name, key in zip(found, jax.random.split(draw_key, max(len(found), 1)), strict=False):
        keys = jax.random.split(key, (num_groups, horizon))
        context = np.array(random_commands(agent, keys), np.float64)
        sequences[name] = _placed(found[name].commands, context, body.rng, last=name == "head")
    sequences = {n: s for n, s in sequences.items() if _equivalent(agent, s)}
    if not sequences:
        raise UserError(
            f"no two sequences of {horizon} commands of a {type(agent).__name__}"
            " are known to lead to the same place",
            remedy="ask for a longer horizon, or group sequences by their displacements",
        )
    each = num_groups * members
    return EquivalentSequences(
        np.concatenate(list(sequences.values())).reshape(len(sequences) * each, horizon, -1),
        np.repeat(np.arange(len(sequences) * num_groups), members),
        np.repeat(np.arange(len(sequences)), each),
        np.concatenate([found[name].full_turns for name in sequences]).ravel(),
        tuple(sequences),
    )


def _turning_commands(agent: AbstractAgent) -> ContinuousCommands:
    """The agent's commands, if they turn its body to both sides alike."""
    commands = agent.commands
    if not isinstance(commands, ContinuousCommands) or not commands.turning:
        raise UserError(
            f"the commands of a {type(agent).__name__} do not say which channels turn it",
            remedy="group its sequences by their displacements",
        )
    turn = commands.turning[0]
    if commands.low[turn] != -commands.high[turn]:
        raise UserError(
            f"a {type(agent).__name__} does not turn to both sides alike",
            remedy="group its sequences by their displacements",
        )
    return commands


def _equivalent(agent: AbstractAgent, sequences: Float[np.ndarray, "G E T M"]) -> bool:
    """Whether the members of every group reach the same pose."""
    groups, members = sequences.shape[:2]
    moved = nominal(agent, sequences.reshape(groups * members, *sequences.shape[2:]))
    x, y, turn = moved.T.reshape(3, groups, members)
    reached = np.stack([x, y, np.cos(turn), np.sin(turn)])
    return bool(np.abs(reached - reached[..., :1]).max() < TOLERANCE)


class _Body(NamedTuple):
    """What the constructions ask of an agent, and their source of randomness."""

    commands: ContinuousCommands
    rng: np.random.Generator

    @property
    def turn(self) -> int:
        return self.commands.turning[0]

    @property
    def reach(self) -> float:
        """The largest rotation of one command, radians."""
        return self.commands.high[self.turn]

    @property
    def beside(self) -> list[int]:
        """The channels that do not turn the body."""
        return [c for c in range(self.commands.size) if c not in self.commands.turning]

    def limits(self, channel: int) -> tuple[float, float]:
        return self.commands.low[channel], self.commands.high[channel]

    def random(self, shape: tuple[int, ...], channels: list[int]) -> np.ndarray:
        """Uniform values [*shape, channels] of some channels."""
        share = np.zeros((*shape, self.commands.size))
        share[..., channels] = self.rng.random((*shape, len(channels)))
        spread: np.ndarray = self.commands.spread(np.moveaxis(share, -1, 0))
        return np.moveaxis(spread, 0, -1)[..., channels]

    def still(self, size: "_Size", length: int) -> Commands:
        """Commands that neither turn nor move; what else they do all members of a group share."""
        commands = np.zeros((*size, length, self.commands.size))
        others = [c for c in self.beside if c not in self.commands.translating]
        commands[..., others] = self.random((size[0], 1, length), others)
        return commands


class _Block(NamedTuple):
    commands: Commands
    full_turns: Int[np.ndarray, "G E"]


_Size = tuple[int, int]
_Maker = Callable[[_Body, _Size, int], _Block | None]


def _split_rotation(body: _Body, size: _Size, horizon: int) -> _Block:
    length = min(3, horizon)
    total = _angles(body, size) * min(1.0, length * body.reach / math.pi)
    total = np.broadcast_to(total, size)
    commands = body.still(size, length)
    commands[..., body.turn] = _shares(body, total, length, *body.limits(body.turn))
    commands[:, :, -1, body.beside] = body.random((size[0], 1), body.beside)
    return _Block(commands, np.zeros(size, int))


def _split_translation(body: _Body, size: _Size, horizon: int) -> _Block | None:
    if not body.commands.translating:
        return None
    length = min(3, horizon)
    commands = body.still(size, length)
    commands[:, :, 0, [body.turn]] = body.random((size[0], 1), [body.turn])
    for channel in body.commands.translating:
        low, high = body.limits(channel)
        total = np.broadcast_to(body.rng.uniform(low, high, (size[0], 1)) * length, size)
        commands[..., channel] = _shares(body, total, length, low, high)
    return _Block(commands, np.zeros(size, int))


def _full_turns(body: _Body, size: _Size, horizon: int) -> _Block | None:
    length = min(TURNING, horizon)
    total = _angles(body, size)
    possible = np.arange(-length, length + 1)
    allowed = np.abs(total + 2 * math.pi * possible) <= length * body.reach
    several = allowed.sum(axis=1) > 1
    if not several.any():
        return None
    # Groups whose rotation can be reached in one way only are replaced by ones that have more.
    kept = np.resize(np.flatnonzero(several), size[0])
    total, allowed = total[kept], allowed[kept]
    chosen = (body.rng.random((*size, len(possible))) * allowed[:, None]).argmax(axis=-1)
    turns = possible[chosen]
    commands = body.still(size, length)
    around = total + 2 * math.pi * turns
    commands[..., body.turn] = _shares(body, around, length, *body.limits(body.turn))
    commands[:, :, -1, body.beside] = body.random((size[0], 1), body.beside)
    fewest = np.abs(total + 2 * math.pi * possible).argmin(axis=1)
    return _Block(commands, turns - possible[fewest][:, None])


def _undone(body: _Body, size: _Size, horizon: int) -> _Block | None:
    moves = list(body.commands.translating)
    if not moves:
        return None
    if any(low != -high for low, high in map(body.limits, moves)):
        return _undone_by_turning_round(body, size, horizon)
    commands = body.still(size, 3)
    commands[:, :, 0, [body.turn]] = body.random((size[0], 1), [body.turn])
    there = body.random(size, moves)
    commands[:, :, 1, moves], commands[:, :, 2, moves] = there, -there
    return _Block(commands, np.zeros(size, int))


def _undone_by_turning_round(body: _Body, size: _Size, horizon: int) -> _Block | None:
    half = math.ceil(math.pi / body.reach - 1e-9)
    length = 1 + 2 * half
    if length > horizon:
        return None
    limits, move = body.limits(body.turn), body.commands.translating[0]
    total, aside = _angles(body, size), body.rng.uniform(*limits, size)
    commands = body.still(size, length)
    commands[:, :, 0, body.turn] = aside
    # Ahead, half a turn, as far back.
    commands[:, :, [0, half], move] = body.random(size, [move])
    turning = commands[..., body.turn]
    turning[:, :, 1 : 1 + half] = _shares(body, np.full(size, math.pi), half, *limits)
    back = (total - aside + 2 * math.pi) % (2 * math.pi) - math.pi
    turning[:, :, 1 + half :] = _shares(body, back, half, *limits)
    return _Block(commands, np.zeros(size, int))


def _head(body: _Body, size: _Size, horizon: int) -> _Block | None:
    if not body.commands.looking or horizon < 2:
        return None
    look = body.commands.looking[0]
    commands = body.still(size, 2)
    everything = list(range(body.commands.size))
    commands[:, :, 0] = body.random((size[0], 1), everything)
    commands[:, :, 0, [look]] = body.random(size, [look])
    bound = min(body.reach, body.commands.high[look])
    total = np.broadcast_to(body.rng.uniform(-1, 1, (size[0], 1)) * bound, size)
    commands[:, :, 1, [body.turn, look]] = _shares(body, total, 2, -bound, bound)
    return _Block(commands, np.zeros(size, int))


BLOCKS: dict[str, _Maker] = {
    "split_rotation": _split_rotation,
    "split_translation": _split_translation,
    "full_turns": _full_turns,
    "undone": _undone,
    "head": _head,
}


def _angles(body: _Body, size: _Size) -> Float[np.ndarray, "G 1"]:
    """A rotation for each group, radians."""
    return body.rng.uniform(-math.pi, math.pi, (size[0], 1))


def _shares(body: _Body, total: np.ndarray, count: int, low: float, high: float) -> np.ndarray:
    """Random numbers from `low` to `high`, `count` of them for each `total` that they add up to.

    Equal shares and a deviation from them, scaled down where it would leave the limits.
    """
    equal = (total / count)[..., None]
    deviation = body.rng.uniform(low, high, (*total.shape, count))
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
