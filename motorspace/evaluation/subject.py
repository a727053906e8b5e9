"""An encoder as it is measured: from motor sequences of any one length to codes."""

from collections.abc import Callable
from typing import NamedTuple

import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Float

from motorspace._errors import UserError
from motorspace._types import Key
from motorspace.analysis.standard_form import standard_form
from motorspace.training.data import Derived, simulated
from motorspace.training.run import Run
from motorspace.training.sources import derive
from motorspace.trajectories.commands import nominal, random_commands
from motorspace.trajectories.transitions import Displacements, Experience, Trajectories
from motorspace.worlds.agents import AbstractAgent

Motors = Float[np.ndarray, "N _ M"]
Codes = Float[np.ndarray, "N _"]
Encode = Callable[[Motors], Codes]
"""From N motor sequences of any one length to their codes."""

LENGTHS = (1, 2, 3, 6, 12, 24)


class Sizes(NamedTuple):
    """How many sequences are measured."""

    sequences: int = 10_000
    groups: int = 100
    """Groups of equivalent sequences of each kind."""
    members: int = 8
    composed: int = 4_000


class Subject(NamedTuple):
    """An encoder to be measured, and what is known of its commands."""

    encode: Encode
    agent: AbstractAgent
    horizon: int
    """Commands of the sequences that it was trained on."""
    longest: int = LENGTHS[-1]
    """Commands of the longest sequences that it encodes."""
    sizes: Sizes = Sizes()


def subject_of(run: Run, *, standard: bool = False) -> Subject:
    """A simulated run's encoder; with `standard` its codes in standard form.

    Raises `UserError` for a run that did not learn in simulation, and if its codes have no
    standard form.
    """
    data = simulated(run.config.data)
    any_length = run.model.encoder.any_length and not _given_displacements(run)
    longest = max(LENGTHS[-1], data.horizon) if any_length else data.horizon
    agent = data.scenario().agent
    encode = encoder_of(_with_derived_motors(run, agent), longest=longest)
    if standard:
        single, key = Subject(encode, agent, horizon=1), jax.random.key(run.config.training.seed)
        drawn = commands(single, (single.sizes.sequences, 1), key=key)
        in_standard_form, plain = standard_form_of(run, drawn[:, 0]), encode
        encode = lambda motors: in_standard_form(plain(motors))  # noqa: E731
    return Subject(encode, agent, data.horizon, longest)


def encoder_of(encode: Callable[[Array, Array], Array], *, longest: int = LENGTHS[-1]) -> Encode:
    """A network's `encode(motors, num_steps)` for sequences of any length up to the longest."""

    def any_length(motors: Motors) -> Codes:
        num, length, size = motors.shape
        # Rows up to the longest length, so that every length shares one compiled program.
        filled = np.zeros((num, max(length, longest), size), np.float32)
        filled[:, :length] = motors
        return np.asarray(encode(jnp.asarray(filled), jnp.full(num, length)), np.float64)

    return any_length


def _with_derived_motors(run: Run, agent: AbstractAgent) -> Callable[[Array, Array], Array]:
    """The run's `encode`; of a baseline that learned from other motors, on those."""
    if not _given_displacements(run):
        return run.encode
    data = run.config.data
    assert isinstance(data, Derived), "the only data that are displacements"

    def encode(motors: Array, num_steps: Array) -> Array:
        moved = jnp.asarray(nominal(agent, np.asarray(motors)[:, : int(num_steps[0])]))
        unseen = jnp.zeros((len(motors), 1))
        experience = Experience(unseen, motors, num_steps, unseen)
        made = derive(
            data, Trajectories(experience, Displacements(moved, moved)), key=jax.random.key(0)
        )
        return run.encode(made.motors, made.num_steps)

    return encode


def _given_displacements(run: Run) -> bool:
    """Whether the run's network is given displacements for motor sequences."""
    data = run.config.data
    return isinstance(data, Derived) and data.change in ("oracle", "scaled_rotations")


def commands(subject: Subject, shape: tuple[int, int], *, key: Key) -> Motors:
    """Random commands of the agent, [*shape, M]; at most `sizes.sequences` sequences."""
    num, length = shape
    keys = jax.random.split(key, (subject.sizes.sequences, max(length, LENGTHS[-1])))
    return np.asarray(random_commands(subject.agent, keys))[:num, :length]


def standard_form_of(run: Run, drawn: Float[np.ndarray, "N M"]) -> Callable[[Codes], Codes]:
    """A function that puts a run's codes into standard form.

    Args:
        run: The run.
        drawn: Random commands of its agent, raw units.

    Raises:
        UserError: For an encoder whose codes are no products of matrices.
    """
    scaled = jnp.asarray(drawn) / jnp.array(run.model.scaling.motors)[None]
    matrices = jax.vmap(run.model.encoder.matrices)(scaled)
    if matrices is None:
        raise UserError(
            f"codes of the encoder {run.config.model.encoder!r} have no standard form",
            remedy="leave it out, or train a run with the encoder 'matrix_product'",
        )
    transitions, readouts = (np.asarray(m, np.float64) for m in matrices)
    return lambda codes: standard_form(codes, transitions, readouts)
