"""Learning to decode: the agent's own encoder says whether a motor sequence has the code asked for.

No label is needed. A random motor sequence gives a code; the decoder answers with two sequences,
from two draws of noise; their codes should be the one asked for, and the two should differ.
"""

from dataclasses import dataclass
from typing import NamedTuple

import equinox as eqx
import jax
import jax.numpy as jnp
import optax
from jaxtyping import Array, Float

from motorspace._types import Key, Motors, Scalar
from motorspace.control.codes import Whitening, encode, random_sequence
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

    updates: int = 12_000
    batch_size: int = 256
    """Codes of one update."""
    learning_rate: float = 2e-3
    """Largest step of Adam; it falls to 0 on a cosine."""
    width_size: int = 256
    depth: int = 3
    """Hidden layers of the decoder, and their units."""
    noise_size: int = 4
    """Numbers that choose among the sequences of a code."""
    diversity: float = 0.4
    """How different two answers should be, relative to two random sequences."""
    labels: int = 50
    """Examples of known displacement that the map from displacements to codes is fitted on."""
    bank: int = 4096
    """Random sequences that are kept with their codes."""
    seed: int = 0

    def __post_init__(self) -> None:
        for name in ("updates", "batch_size", "width_size", "depth", "noise_size", "bank"):
            whole(name, getattr(self, name))
        whole("labels", self.labels)
        positive("learning_rate", self.learning_rate)

    def decoder(self, sizes: tuple[int, int, int], *, key: Key) -> Decoder:
        """A decoder with initial weights; `sizes` are those of code, sequence and command."""
        return Decoder(
            sizes, self.noise_size, width_size=self.width_size, depth=self.depth, key=key
        )


USUAL = ControlConfig()


class Task(NamedTuple):
    """What a decoder is to invert."""

    model: Model
    commands: ContinuousCommands
    whitening: Whitening
    horizon: int


def learn_decoder(task: Task, config: ControlConfig, *, key: Key) -> Decoder:
    """A decoder of the task's encoder."""
    init_key, data_key = jax.random.split(key)
    sizes = (len(task.whitening.centre), task.horizon, task.commands.size)
    decoder = config.decoder(sizes, key=init_key)
    schedule = optax.cosine_decay_schedule(config.learning_rate, config.updates)
    optimiser = optax.chain(optax.clip_by_global_norm(1.0), optax.adam(schedule))
    arrays, static = eqx.partition(decoder, eqx.is_array)

    def loss_of(arrays: Decoder, key: Key) -> Scalar:
        return decoding_loss(eqx.combine(arrays, static), task, config, key=key)

    @jax.jit
    def run(carry: tuple[Decoder, optax.OptState], keys: Array) -> tuple[Decoder, optax.OptState]:
        def update(
            carry: tuple[Decoder, optax.OptState], key: Key
        ) -> tuple[tuple[Decoder, optax.OptState], None]:
            arrays, state = carry
            gradients = jax.grad(loss_of)(arrays, key)
            with jax.numpy_dtype_promotion("standard"):  # optax counts in whole numbers
                updates, state = optimiser.update(gradients, state)
            return (optax.apply_updates(arrays, updates), state), None

        return jax.lax.scan(update, carry, keys)[0]

    carry, done = (arrays, optimiser.init(arrays)), 0
    while done < config.updates:
        num = min(STEPS_AT_ONCE, config.updates - done)
        keys = jax.random.split(jax.random.fold_in(data_key, done), num)
        carry, done = run(carry, keys), done + num
    return eqx.combine(carry[0], static)


def decoding_loss(decoder: Decoder, task: Task, config: ControlConfig, *, key: Key) -> Scalar:
    """How far the codes of answers are from those asked for, and how alike two answers are."""
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
    return jnp.mean(miss) + jnp.mean(alike**2)


BETTER = 0.8
"""How much the better of two answers counts beyond their mean."""

RANDOM_SPREAD = (1 / 6) ** 0.5
"""Root mean square difference of two uniformly random numbers in [0, 1]."""


def scaled(commands: ContinuousCommands, motors: Motors) -> Float[Array, " D"]:
    """A motor sequence as shares of the way from lower to upper bounds, in one row."""
    low, high = (jnp.array(bound)[None] for bound in (commands.low, commands.high))
    return ((motors - low) / (high - low)).reshape(-1)
