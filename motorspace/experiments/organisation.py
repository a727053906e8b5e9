"""How an encoder organises motor sequences: what every row of the topology table is measured at."""

from collections.abc import Callable
from typing import Any, NamedTuple

import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Float, Int

from motorspace._types import Key
from motorspace.analysis import composition
from motorspace.analysis.circle import circular_error
from motorspace.analysis.collapse import collapse_ratio, equal_rows, equivalence_auc
from motorspace.analysis.coordinates import displacement_coordinates
from motorspace.analysis.probes import linear_decoder
from motorspace.analysis.topology import Topology, topology
from motorspace.trajectories import commands
from motorspace.trajectories.commands import nominal, padded
from motorspace.trajectories.equivalent import EquivalentSequences, equivalent_sequences
from motorspace.worlds.agents import AbstractAgent, LatticeAgent

Motors = Float[np.ndarray, "N _ M"]
Codes = Float[np.ndarray, "N _"]
Encode = Callable[[Motors], Codes]
"""From N motor sequences of any one length to their codes."""

MEASURE_SEED = 3_000_017
NUM_SEQUENCES = 10_000
NUM_GROUPS = 100
NUM_MEMBERS = 8
LENGTHS = (1, 2, 3, 6, 12, 24)
NUM_COMPOSED = 4_000


def encoder_of(encode: Callable[[Array, Array], Array]) -> Encode:
    """A network's `encode(motors, num_steps)` for sequences of any length up to the longest."""

    def any_length(motors: Motors) -> Codes:
        num, length, _ = motors.shape
        codes = encode(jnp.asarray(padded(motors)), jnp.full(num, length))
        return np.asarray(codes, np.float64)

    return any_length


def organisation(
    encode: Encode, agent: AbstractAgent, *, horizon: int, seed: int
) -> dict[str, Any]:
    """Every measure of the codes of fresh random sequences, and of those built to be equivalent.

    No world comes in: codes are compared with the displacements that the commands would cause
    with no walls, as nothing is known of any.
    """
    keys = jax.random.split(jax.random.key(MEASURE_SEED + seed), 3)
    return {
        "topology": measures(encode, agent, horizon=horizon, seed=seed),
        "collapse": collapse(encode, agent, horizon=horizon, key=keys[0]),
        "composition": compositions(encode, agent, length=horizon // 2, key=keys[1]),
        "lengths": lengths(encode, agent, horizon=horizon, key=keys[2]),
    }


def measures(
    encode: Encode, agent: AbstractAgent, *, horizon: int, seed: int
) -> dict[str, list[float | None]]:
    """The report on the codes of fresh random sequences, as numbers: value and error of each."""
    found = sampled(encode, agent, horizon=horizon, seed=seed, subsets=1)
    return {name: [value, error] for name, value, error, _ in found.topology.rows()}


class Sampled(NamedTuple):
    """Codes of random sequences, and how they are organised."""

    codes: Codes
    displacements: Float[np.ndarray, "N 3"]
    topology: Topology


def sampled(
    encode: Encode, agent: AbstractAgent, *, horizon: int, seed: int, subsets: int = 5
) -> Sampled:
    """The report on the codes of fresh random sequences."""
    key = jax.random.key(MEASURE_SEED - 1 - seed)
    motors = random_commands(agent, (NUM_SEQUENCES, horizon), key=key)
    codes, displacements = encode(motors), nominal(agent, motors)
    found = topology(codes, displacements, motors, subsets=subsets, seed=seed)
    return Sampled(codes, displacements, found)


def collapse(encode: Encode, agent: AbstractAgent, *, horizon: int, key: Key) -> dict[str, Any]:
    """Collapse ratio and AUC, of all groups and by what their members differ in.

    `by full turns` is the mean squared distance between codes of the same group that differ by so
    many whole turns, over that of all pairs.
    """
    if isinstance(agent, LatticeAgent):
        motors = random_commands(agent, (NUM_SEQUENCES, horizon), key=key)
        none = np.zeros(len(motors), int)
        made = EquivalentSequences(motors, equal_rows(nominal(agent, motors)), none, none, ())
    else:
        made = equivalent_sequences(
            agent, num_groups=NUM_GROUPS, members=NUM_MEMBERS, horizon=horizon, key=key
        )
    motors, groups, kinds, turns, names = made
    codes, flat = encode(motors), motors.reshape(len(motors), -1)
    measured: dict[str, Any] = {
        "ratio": collapse_ratio(codes, groups),
        "auc": equivalence_auc(codes, flat, groups),
        "by kind": {
            name: collapse_ratio(codes, np.where(kinds == index, groups, -1))
            for index, name in enumerate(names)
        },
    }
    if "full_turns" in names:
        chosen = kinds == names.index("full_turns")
        measured["by full turns"] = _by_turns(
            codes[chosen],
            turns[chosen],
            members=NUM_MEMBERS,
            total=2 * float(codes.var(axis=0).sum()),
        )
    return measured


def _by_turns(
    codes: Codes, turns: Int[np.ndarray, " N"], *, members: int, total: float
) -> dict[str, float]:
    h, n = codes.reshape(-1, members, codes.shape[1]), turns.reshape(-1, members)
    squares = ((h[:, :, None] - h[:, None]) ** 2).sum(axis=-1)
    apart = np.abs(n[:, :, None] - n[:, None])
    other = ~np.eye(members, dtype=bool)
    return {
        str(count): float(squares[(apart == count) & other].mean() / total)
        for count in range(int(apart.max()) + 1)
        if ((apart == count) & other).any()
    }


def compositions(encode: Encode, agent: AbstractAgent, *, length: int, key: Key) -> dict[str, Any]:
    """Whether the code of two sequences of `length` in a row follows from their codes."""
    first, second = (
        random_commands(agent, (NUM_COMPOSED, length), key=k) for k in jax.random.split(key)
    )
    both = encode(np.concatenate([first, second], axis=1))
    codes = encode(first)
    near = first[composition.nearest_other(codes)]
    left = encode(np.concatenate([near, second], axis=1))
    before = encode(np.concatenate([second, first], axis=1))
    right = encode(np.concatenate([second, near], axis=1))
    return composition.composition_errors(codes, encode(second), both) | {
        "congruence left": composition.congruence_error(both, left),
        "congruence right": composition.congruence_error(before, right),
    }


def lengths(
    encode: Encode, agent: AbstractAgent, *, horizon: int, key: Key
) -> dict[str, dict[str, float]]:
    """Displacement errors at every length, of the linear map fitted at the full horizon.

    Root mean square of the translation's error (world units), mean absolute error of orientation
    (degrees), and the translation's own root mean square.
    """
    fit_key, test_key = jax.random.split(key)
    motors = random_commands(agent, (NUM_SEQUENCES, horizon), key=fit_key)
    points = displacement_coordinates(nominal(agent, motors), weight=1.0).points
    fitted = encode(motors)
    decode = linear_decoder(fitted, points)
    errors = {}
    for length in LENGTHS:
        tested = random_commands(agent, (NUM_SEQUENCES // 2, length), key=test_key)
        true = nominal(agent, tested)
        codes = encode(tested)
        if codes.shape[1] != fitted.shape[1]:
            return {}
        decoded = decode(codes)
        off = ((decoded[:, :2] - true[:, :2]) ** 2).sum(axis=1).mean() ** 0.5
        angles = np.arctan2(decoded[:, 3], decoded[:, 2])
        errors[str(length)] = {
            "translation": float(off),
            "orientation": circular_error(angles, true[:, 2]),
            "size": float((true[:, :2] ** 2).sum(axis=1).mean() ** 0.5),
        }
    return errors


def random_commands(agent: AbstractAgent, shape: tuple[int, int], *, key: Key) -> Motors:
    """Commands as the agent explores with, walls aside: [*shape, M], at most `NUM_SEQUENCES`."""
    num, length = shape
    keys = jax.random.split(key, (NUM_SEQUENCES, max(length, LENGTHS[-1])))
    return np.asarray(commands.random_commands(agent, keys))[:num, :length]
