"""Recurrent encoders: the paper's LSTM, a GRU, and a state space that is linear in the commands."""

from collections.abc import Callable
from typing import Any

import equinox as eqx
import jax
import jax.numpy as jnp
from jaxtyping import Array, Float

from motorspace._types import Code, Count, Key, Motors
from motorspace.models.encoders.base import AbstractMotorEncoder, code_mlp

Hidden = Float[Array, "T H"]

MAX_UNROLL = 8


class LSTMEncoder(AbstractMotorEncoder):
    """The paper's encoder: a recurrent layer from a zero state, then a sigmoid layer.

    h^m = sigmoid(W h_T + b), h_t = LSTM(m_t, h_{t-1}), h_0 = 0 (section 3).
    """

    cell: eqx.nn.LSTMCell
    to_code: eqx.nn.Linear

    def __init__(self, motor_size: int, hidden_size: int, code_size: int, *, key: Key) -> None:
        cell_key, code_key = jax.random.split(key)
        self.cell = eqx.nn.LSTMCell(motor_size, hidden_size, key=cell_key)
        self.to_code = eqx.nn.Linear(hidden_size, code_size, key=code_key)

    def __call__(self, motors: Motors, num_steps: Count) -> Code:
        return _code(self.to_code, _lstm(self.cell, motors), num_steps)


class GRUEncoder(AbstractMotorEncoder):
    """The same with a gated recurrent unit (Cho et al., 2014)."""

    cell: eqx.nn.GRUCell
    to_code: eqx.nn.Linear

    def __init__(self, motor_size: int, hidden_size: int, code_size: int, *, key: Key) -> None:
        cell_key, code_key = jax.random.split(key)
        self.cell = eqx.nn.GRUCell(motor_size, hidden_size, key=cell_key)
        self.to_code = eqx.nn.Linear(hidden_size, code_size, key=code_key)

    def __call__(self, motors: Motors, num_steps: Count) -> Code:
        return _code(self.to_code, _gru(self.cell, motors), num_steps)


def _code(to_code: eqx.nn.Linear, hidden: Hidden, num_steps: Count) -> Code:
    """The code that the hidden state after `num_steps` commands gives."""
    last = jnp.arange(len(hidden)) == num_steps - 1
    return jax.nn.sigmoid(to_code(jnp.sum(jnp.where(last[:, None], hidden, 0.0), axis=0)))


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
        self.to_code = code_mlp(2 * hidden_size, hidden_size, code_size, key=code_key)

    def __call__(self, motors: Motors, num_steps: Count) -> Code:
        real, imaginary = jnp.split(jax.vmap(self.to_state)(motors), 2, axis=1)
        # The state unrolled: command t has been multiplied by l as often as commands follow it.
        age = (num_steps - 1 - jnp.arange(len(motors))).astype(jnp.float32)
        shrunk = jnp.exp(-jnp.exp(self.log_decay[None]) * age[:, None])
        kept = jnp.where(age[:, None] >= 0, shrunk, 0.0)
        cos, sin = (
            kept * jnp.cos(self.phase[None] * age[:, None]),
            kept * jnp.sin(self.phase[None] * age[:, None]),
        )
        state = [cos * real - sin * imaginary, sin * real + cos * imaginary]
        return self.to_code(jnp.concatenate(state, axis=1).sum(axis=0))
