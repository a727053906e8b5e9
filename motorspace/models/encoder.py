"""Motor encoders: a motor sequence in, a code out. One sequence; batching is `vmap`."""

import abc
import functools
import math
from collections.abc import Callable
from typing import Any, Literal

import equinox as eqx
import jax
import jax.numpy as jnp
from jaxtyping import Array, Float

from motorspace._errors import UserError
from motorspace._types import Code, Count, Key, Motors

EncoderName = Literal[
    "lstm", "gru", "linear", "attention", "group", "sum", "mlp", "none", "identity"
]
Hidden = Float[Array, "T H"]
Matrix = Float[Array, "n n"]

MAX_UNROLL = 8
NUM_HEADS = 4


class AbstractMotorEncoder(eqx.Module):
    """Squeezes the first `num_steps` rows of a (scaled) motor sequence into a code."""

    @abc.abstractmethod
    def __call__(self, motors: Motors, num_steps: Count) -> Code:
        """The code h^m of the sequence."""


class RecurrentEncoder(AbstractMotorEncoder):
    """The paper's encoder: a recurrent layer from a zero state, then a sigmoid layer.

    h^m = sigmoid(W h_T + b), h_t = LSTM(m_t, h_{t-1}), h_0 = 0 (section 3).
    """

    cell: eqx.nn.LSTMCell | eqx.nn.GRUCell
    to_code: eqx.nn.Linear

    def __init__(
        self,
        motor_size: int,
        hidden_size: int,
        code_size: int,
        *,
        gated: Literal["lstm", "gru"] = "lstm",
        key: Key,
    ) -> None:
        cell_key, code_key = jax.random.split(key)
        cell = eqx.nn.LSTMCell if gated == "lstm" else eqx.nn.GRUCell
        self.cell = cell(motor_size, hidden_size, key=cell_key)
        self.to_code = eqx.nn.Linear(hidden_size, code_size, key=code_key)

    def __call__(self, motors: Motors, num_steps: Count) -> Code:
        cell = self.cell
        hidden = _lstm(cell, motors) if isinstance(cell, eqx.nn.LSTMCell) else _gru(cell, motors)
        last = jnp.arange(len(motors)) == num_steps - 1
        return jax.nn.sigmoid(self.to_code(jnp.sum(jnp.where(last[:, None], hidden, 0.0), axis=0)))


def _lstm(cell: eqx.nn.LSTMCell, motors: Motors) -> Hidden:
    """h_1 to h_T. A step's two products are one, and in the first, where h_0 = 0, only one."""
    assert cell.bias is not None, "the encoder makes its cell with a bias"
    weight, bias = jnp.concatenate([cell.weight_ih, cell.weight_hh], axis=1), cell.bias

    def gated(gates: Array, memory: Array) -> tuple[Array, Array]:
        write, keep, content, read = jnp.split(gates, 4)
        memory = jax.nn.sigmoid(keep) * memory + jax.nn.sigmoid(write) * jnp.tanh(content)
        return jax.nn.sigmoid(read) * jnp.tanh(memory), memory

    def advance(state: tuple[Array, Array], motor: Array) -> tuple[tuple[Array, Array], Array]:
        hidden, memory = state
        state = gated(weight @ jnp.concatenate([motor, hidden]) + bias, memory)
        return state, state[0]

    first = gated(cell.weight_ih @ motors[0] + bias, jnp.zeros(cell.hidden_size))
    later = _unrolled(advance, first, motors[1:])
    return jnp.concatenate([first[0][None], later])


def _gru(cell: eqx.nn.GRUCell, motors: Motors) -> Hidden:
    """h_1 to h_T."""

    def advance(hidden: Array, motor: Array) -> tuple[Array, Array]:
        hidden = cell(motor, hidden)
        return hidden, hidden

    return _unrolled(advance, jnp.zeros(cell.hidden_size), motors)


def _unrolled(
    advance: Callable[[Any, Array], tuple[Any, Array]], start: Any, motors: Array
) -> Array:
    """`scan`, unrolled since one step holds too little work for an iteration; long sequences only
    in part, since compilation grows with the number of copies."""
    unroll = max(1, min(len(motors), MAX_UNROLL))
    return jax.lax.scan(advance, start, motors, unroll=unroll)[1]


class LinearRecurrentEncoder(AbstractMotorEncoder):
    """A comparison whose state is linear in the commands: a diagonal state space, then an MLP.

    x_t = diag(l) x_{t-1} + B m_t, l complex within the unit circle (Orvieto et al., 2023). Where a
    command ends up depends on those before it only through the MLP.
    """

    log_decay: Float[Array, " H"]
    phase: Float[Array, " H"]
    to_state: eqx.nn.Linear
    to_code: eqx.nn.MLP

    def __init__(self, motor_size: int, hidden_size: int, code_size: int, *, key: Key) -> None:
        decay_key, phase_key, state_key, code_key = jax.random.split(key, 4)
        self.log_decay = jnp.log(
            -jnp.log(jax.random.uniform(decay_key, (hidden_size,), minval=0.8))
        )
        self.phase = jax.random.uniform(phase_key, (hidden_size,), maxval=jnp.pi)
        self.to_state = eqx.nn.Linear(motor_size, 2 * hidden_size, key=state_key)
        self.to_code = _code_mlp(2 * hidden_size, hidden_size, code_size, key=code_key)

    def __call__(self, motors: Motors, num_steps: Count) -> Code:
        real, imaginary = jnp.split(jax.vmap(self.to_state)(motors), 2, axis=1)
        # The state unrolled: command t has been multiplied by l as often as commands follow it.
        age = num_steps - 1 - jnp.arange(len(motors))
        shrunk = jnp.exp(-jnp.exp(self.log_decay) * age[:, None])
        kept = jnp.where(age[:, None] >= 0, shrunk, 0.0)
        cos, sin = (
            kept * jnp.cos(self.phase * age[:, None]),
            kept * jnp.sin(self.phase * age[:, None]),
        )
        state = [cos * real - sin * imaginary, sin * real + cos * imaginary]
        return self.to_code(jnp.concatenate(state, axis=1).sum(axis=0))


class AttentionEncoder(AbstractMotorEncoder):
    """A comparison that looks at all commands at once: one block of self-attention, then an MLP.

    The last command's token asks all others (Vaswani et al., 2017); positions are counted back
    from it, so that sequences of every length end alike.
    """

    to_token: eqx.nn.MLP
    attention: eqx.nn.MultiheadAttention
    to_code: eqx.nn.MLP

    def __init__(self, motor_size: int, hidden_size: int, code_size: int, *, key: Key) -> None:
        token_key, attention_key, code_key = jax.random.split(key, 3)
        size = hidden_size - hidden_size % NUM_HEADS
        self.to_token = eqx.nn.MLP(motor_size + 1, size, size, 1, key=token_key)
        self.attention = eqx.nn.MultiheadAttention(NUM_HEADS, size, key=attention_key)
        self.to_code = _code_mlp(2 * size, hidden_size, code_size, key=code_key)

    def __call__(self, motors: Motors, num_steps: Count) -> Code:
        age = num_steps - 1 - jnp.arange(len(motors))
        placed = jnp.concatenate([motors, age[:, None] / MAX_UNROLL], axis=1)
        tokens = jax.vmap(self.to_token)(placed)
        seen = jnp.broadcast_to(age >= 0, (len(motors), len(motors)))
        attended = tokens + self.attention(tokens, tokens, tokens, mask=seen)
        weight = jnp.where(age >= 0, 1.0, 0.0)[:, None]
        last = jnp.where(age == 0, 1.0, 0.0)[:, None]
        pooled = [jnp.sum(last * attended, axis=0), jnp.sum(weight * attended, axis=0)]
        return self.to_code(jnp.concatenate(pooled))


class GroupEncoder(AbstractMotorEncoder):
    """Commands as matrices that multiply, as displacements do: not in the paper.

    h^m = A(m_1) A(m_2) ... A(m_T) H(m_T), n x n matrices whose last row is (0 ... 0 1) and is
    left out. A says what a command does to all that follows it; H what the last one does to the
    sensors alone, such as the angle of a head. Sequences that make the same product have the same
    code, whatever follows or precedes them. With n = 3 there is just room for the plane's motions.
    """

    transition: eqx.nn.MLP
    readout: eqx.nn.MLP
    size: int = eqx.field(static=True)

    def __init__(self, motor_size: int, hidden_size: int, code_size: int, *, key: Key) -> None:
        self.size = matrix_size(code_size)
        transition_key, readout_key, wide_key = jax.random.split(key, 3)
        sizes = (motor_size, code_size, hidden_size, 2, jnp.sin)
        transition = eqx.nn.MLP(*sizes, key=transition_key)
        # Sines of about one radian per radian fold turns by themselves. From matrices too near the
        # identity grow some that turn by a fraction of every angle, and stay so.
        wide = jax.random.normal(wide_key, (hidden_size, motor_size))
        self.transition = eqx.tree_at(
            lambda mlp: (mlp.layers[0].weight, mlp.layers[-1].weight),
            transition,
            (wide, 4 * transition.layers[-1].weight),
        )
        # H begins as the identity. What one command alone could say by either, A learns first;
        # turns that H has taken are missing from A when a second command comes.
        self.readout = _quiet(eqx.nn.MLP(*sizes, key=readout_key))

    def __call__(self, motors: Motors, num_steps: Count) -> Code:
        unit = jnp.eye(self.size)
        executed = jnp.arange(len(motors)) < num_steps
        matrices = jax.vmap(self._matrix, in_axes=(None, 0))(self.transition, motors)
        matrices = jnp.where(executed[:, None, None], matrices, unit)
        product = functools.reduce(_product, matrices)
        last = self._matrix(self.readout, motors[num_steps - 1])
        return _product(product, last)[:-1].reshape(-1)

    def matrices(self, motor: Array) -> tuple[Matrix, Matrix]:
        """A and H of one (scaled) command."""
        return self._matrix(self.transition, motor), self._matrix(self.readout, motor)

    def linear_part(self, motor: Array) -> Matrix:
        """What a command does to directions: A without its translation."""
        return self._matrix(self.transition, motor)[:-1, :-1]

    def _matrix(self, mlp: eqx.nn.MLP, motor: Array) -> Matrix:
        """The identity and what the network adds to all but its last row."""
        return jnp.eye(self.size).at[:-1].add(mlp(motor).reshape(self.size - 1, self.size))


def _quiet(mlp: eqx.nn.MLP) -> eqx.nn.MLP:
    """The network with a last layer of zeros: it says nothing until it has learned to."""
    last = mlp.layers[-1]
    return eqx.tree_at(lambda net: net.layers[-1], mlp, jax.tree.map(jnp.zeros_like, last))


def matrix_size(code_size: int) -> int:
    """The n of the n x n matrices whose first n - 1 rows make a code. Raises `UserError`."""
    size = round((1 + math.sqrt(1 + 4 * code_size)) / 2)
    if size < 2 or size * (size - 1) != code_size:
        raise UserError(
            f"a code of {code_size} units is no matrix",
            remedy="give the encoder 'group' a code_size of n (n - 1): 6, 12, 20, 30, ...",
        )
    return size


def _product(left: Matrix, right: Matrix) -> Matrix:
    """left @ right, as a sum that is compiled into one loop over a batch of small matrices."""
    return jnp.sum(left[:, :, None] * right[None, :, :], axis=1)


class SumEncoder(AbstractMotorEncoder):
    """A comparison that cannot know the order of the commands: an MLP on their sum."""

    mlp: eqx.nn.MLP

    def __init__(self, motor_size: int, hidden_size: int, code_size: int, *, key: Key) -> None:
        self.mlp = _code_mlp(motor_size, hidden_size, code_size, key=key)

    def __call__(self, motors: Motors, num_steps: Count) -> Code:
        return self.mlp(jnp.sum(_executed(motors, num_steps), axis=0))


class FlatEncoder(AbstractMotorEncoder):
    """A comparison without recurrence: an MLP on the whole sequence laid flat."""

    mlp: eqx.nn.MLP

    def __init__(
        self, motor_size: int, horizon: int, hidden_size: int, code_size: int, *, key: Key
    ) -> None:
        self.mlp = _code_mlp(horizon * motor_size, hidden_size, code_size, key=key)

    def __call__(self, motors: Motors, num_steps: Count) -> Code:
        return self.mlp(_executed(motors, num_steps).reshape(-1))


class ConstantEncoder(AbstractMotorEncoder):
    """A reference that knows nothing of the commands: what is left is a no-motor model."""

    code_size: int = eqx.field(static=True)

    def __call__(self, motors: Motors, num_steps: Count) -> Code:
        del motors, num_steps
        return jnp.zeros(self.code_size)


class IdentityEncoder(AbstractMotorEncoder):
    """The sequence itself, laid flat: for references that are given their code."""

    def __call__(self, motors: Motors, num_steps: Count) -> Code:
        del num_steps
        return motors.reshape(-1)


def _executed(motors: Motors, num_steps: Count) -> Motors:
    """The motor sequence with zeros for the rows that are no part of it."""
    return jnp.where(jnp.arange(len(motors))[:, None] < num_steps, motors, 0.0)


def _code_mlp(in_size: int, width_size: int, code_size: int, *, key: Key) -> eqx.nn.MLP:
    return eqx.nn.MLP(in_size, code_size, width_size, 2, final_activation=jax.nn.sigmoid, key=key)
