"""Motor encoders: a motor sequence in, a code out. One sequence; batching is `vmap`."""

import abc
from collections.abc import Callable
from typing import Any, Literal

import equinox as eqx
import jax
import jax.numpy as jnp
from jaxtyping import Array, Float

from motorspace._types import Code, Count, Key, Motors

EncoderName = Literal["lstm", "gru", "sum", "mlp", "none", "identity"]
Hidden = Float[Array, "T H"]

MAX_UNROLL = 8


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
