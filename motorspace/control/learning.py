"""Learning to decode: the agent's own encoder says whether a motor sequence has the code asked for.

No label is needed. A random motor sequence gives a code; the decoder answers with two sequences,
from two draws of noise; their codes should be the one asked for, and the two should differ.
"""

from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import NamedTuple, TypeVar

import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np
import optax
from jaxtyping import Array, Float

from motorspace._types import Key, Motors, Scalar
from motorspace.control.codes import Whitening, encode, random_sequence
from motorspace.control.composing import Remainder, held
from motorspace.control.decoder import Decoder, squash
from motorspace.models.model import Model
from motorspace.worlds.checks import positive, whole
from motorspace.worlds.spaces import ContinuousCommands

STEPS_AT_ONCE = 500
"""Updates of one compiled call."""


@dataclass(frozen=True)
class ControlConfig:
    """How a controller learns.

    Raises:
        UserError: For a number that is too small.
    """

    updates: int = 6_000
    """Steps of Adam."""
    batch_size: int = 256
    """Codes of one update."""
    learning_rate: float = 2e-3
    """Largest step of Adam; it falls to 0 on a cosine."""
    width_size: int = 256
    """Units of each hidden layer of the decoder."""
    depth: int = 3
    """Hidden layers of the decoder."""
    restarts: int = 3
    """Initial weights that are tried."""
    noise_size: int = 4
    """Numbers that choose among the sequences of a code."""
    diversity: float = 0.4
    """How different two answers should be, relative to two random sequences."""
    labels: int = 50
    """Examples of known displacement that the map from displacements to codes is fitted on."""
    bank: int = 4096
    """Random sequences that are kept with their codes."""
    seed: int = 0
    """Seed of everything that is random."""

    def __post_init__(self) -> None:
        for name in ("updates", "batch_size", "width_size", "depth", "noise_size", "bank"):
            whole(name, getattr(self, name))
        whole("labels", self.labels)
        whole("restarts", self.restarts)
        positive("learning_rate", self.learning_rate)

    def decoder(self, sizes: tuple[int, int, int], *, key: Key) -> Decoder:
        """A decoder with initial weights; `sizes` are those of code, sequence and command."""
        return Decoder(
            sizes, self.noise_size, width_size=self.width_size, depth=self.depth, key=key
        )

    def remainder(self, code_size: int, *, key: Key) -> Remainder:
        """What remains of a goal, with initial weights."""
        sizes = 2 * code_size, code_size, self.width_size, self.depth
        return Remainder(eqx.nn.MLP(*sizes, jax.nn.relu, key=key))


Network = TypeVar("Network", Decoder, Remainder)

USUAL = ControlConfig()


class Task(NamedTuple):
    """What a decoder is to invert."""

    model: Model
    commands: ContinuousCommands
    whitening: Whitening
    horizon: int


def learn_decoder(task: Task, config: ControlConfig, *, key: Key) -> Decoder:
    """A decoder of the task's encoder.

    Some initial weights end where a third of the codes is never reached, which the loss shows
    early: of several short trials the best one is trained in full.
    """
    keys = jax.random.split(key, config.restarts)
    if config.restarts == 1:
        return _decoder_from(task, config, key=keys[0])
    trial = replace(config, updates=max(1, round(TRIAL_SHARE * config.updates)))
    tried = [_decoder_from(task, trial, key=k) for k in keys]
    losses = [_loss_of(decoder, task, config) for decoder in tried]
    best = int(np.argmin(losses))
    full = _decoder_from(task, config, key=keys[best])
    return full if _loss_of(full, task, config) < losses[best] else tried[best]


def _decoder_from(task: Task, config: ControlConfig, *, key: Key) -> Decoder:
    init_key, data_key = jax.random.split(key)
    sizes = (len(task.whitening.centre), task.horizon, task.commands.size)
    decoder = config.decoder(sizes, key=init_key)
    return _learned(
        decoder, lambda net, key: decoding_loss(net, task, config, key=key), config, key=data_key
    )


def _loss_of(decoder: Decoder, task: Task, config: ControlConfig) -> float:
    many = replace(config, batch_size=TRIAL_CODES)
    key = jax.random.key(config.seed)
    return float(eqx.filter_jit(decoding_loss)(decoder, task, many, key=key))


TRIAL_SHARE = 0.2
"""The part of the updates that a trial gets."""
TRIAL_CODES = 2048
"""Codes that trials are compared on."""


def learn_remainder(task: Task, config: ControlConfig, *, key: Key) -> Remainder:
    """What remains of a goal after a part of the way, for codes that are no products."""
    init_key, data_key = jax.random.split(key)
    remainder = config.remainder(len(task.whitening.centre), key=init_key)
    return _learned(
        remainder, lambda net, key: remainder_loss(net, task, config, key=key), config, key=data_key
    )


def _learned(
    network: Network, loss: Callable[[Network, Key], Scalar], config: ControlConfig, *, key: Key
) -> Network:
    """The network after so many updates on fresh sequences."""
    schedule = optax.cosine_decay_schedule(config.learning_rate, config.updates)
    optimiser = optax.chain(optax.clip_by_global_norm(1.0), optax.adam(schedule))
    arrays, static = eqx.partition(network, eqx.is_array)

    def loss_of(arrays: Network, key: Key) -> Scalar:
        return loss(eqx.combine(arrays, static), key)

    @jax.jit
    def run(carry: tuple[Network, optax.OptState], keys: Array) -> tuple[Network, optax.OptState]:
        def update(
            carry: tuple[Network, optax.OptState], key: Key
        ) -> tuple[tuple[Network, optax.OptState], None]:
            arrays, state = carry
            gradients = jax.grad(loss_of)(arrays, key)
            with jax.numpy_dtype_promotion("standard"):  # optax counts in whole numbers
                updates, state = optimiser.update(gradients, state)
            return (optax.apply_updates(arrays, updates), state), None

        return jax.lax.scan(update, carry, keys)[0]

    carry, done = (arrays, optimiser.init(arrays)), 0
    while done < config.updates:
        num = min(STEPS_AT_ONCE, config.updates - done)
        keys = jax.random.split(jax.random.fold_in(key, done), num)
        carry, done = run(carry, keys), done + num
    return eqx.combine(carry[0], static)


def decoding_loss(decoder: Decoder, task: Task, config: ControlConfig, *, key: Key) -> Scalar:
    """How far codes of answers are from those asked for, how alike two answers are, how extreme.

    Encoders err most where all of a sequence's commands are extreme, which few random ones are:
    such sequences have the code asked for, and lead elsewhere.
    """
    sequence_keys, noise_keys = jax.random.split(key, (2, config.batch_size))

    def one(sequence_key: Key, noise_key: Key) -> tuple[Scalar, Float[Array, "2 D"]]:
        asked = random_sequence(task.commands, task.horizon, key=sequence_key)
        code = encode(task.model, asked)
        noise = jax.random.normal(noise_key, (2, config.noise_size))
        white = task.whitening(code)
        answers = jax.vmap(lambda z: squash(task.commands, decoder(white, z)))(noise)
        miss = jax.vmap(lambda m: task.whitening.distance(encode(task.model, m), code))(answers)
        # The better answer counts most, so that noise may choose between ways that nothing leads
        # from one to the other: to the left or to the right, where half a turn is asked for.
        miss = BETTER * jnp.min(miss) + (1 - BETTER) * jnp.mean(miss)
        return miss, jax.vmap(lambda m: scaled(task.commands, m))(answers)

    miss, answers = jax.vmap(one)(sequence_keys, noise_keys)
    apart = jnp.sqrt(jnp.mean((answers[:, 0] - answers[:, 1]) ** 2, axis=-1) + 1e-8)
    alike = jax.nn.relu(config.diversity * RANDOM_SPREAD - apart)
    extreme = (2 * answers - 1) ** 4
    return jnp.mean(miss) + jnp.mean(alike**2) + EXTREMES * jnp.mean(extreme)


def remainder_loss(remainder: Remainder, task: Task, config: ControlConfig, *, key: Key) -> Scalar:
    """How far what is said to remain of random sequences is from the code of their rest."""

    def one(key: Key) -> Scalar:
        sequence_key, length_key = jax.random.split(key)
        whole = random_sequence(task.commands, task.horizon, key=sequence_key)
        done = jax.random.randint(length_key, (), 1, task.horizon)
        parts = whole, held(task.commands, whole, done)
        # The rest, moved to the front, and held from there on.
        rest = held(task.commands, jnp.roll(whole, -done, axis=0), task.horizon - done)
        goal, before, after = (task.whitening(encode(task.model, m)) for m in (*parts, rest))
        return jnp.mean((remainder(before, goal) - after) ** 2)

    return jnp.mean(jax.vmap(one)(jax.random.split(key, config.batch_size)))


BETTER = 0.8
"""How much the better of two answers counts beyond their mean."""

EXTREMES = 0.01
"""What it costs to answer with commands at their bounds, where 1 is what a random code would."""

RANDOM_SPREAD = (1 / 6) ** 0.5
"""Root mean square difference of two uniformly random numbers in [0, 1]."""


def scaled(commands: ContinuousCommands, motors: Motors) -> Float[Array, " D"]:
    """A motor sequence as shares of the way from lower to upper bounds, in one row."""
    return commands.shares(motors.T).T.reshape(-1)
