"""Motor encoders: a motor sequence in, a code out. One sequence; batching is `vmap`."""

import abc
from typing import Literal

import equinox as eqx
import jax
import jax.numpy as jnp

from motorspace._types import Code, Count, Key, Motors

EncoderName = Literal["lstm", "gru", "sum", "mlp", "none", "identity"]


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
        zero = jnp.zeros(self.cell.hidden_size)
        gated = isinstance(self.cell, eqx.nn.LSTMCell)

        def advance(state, motor):  # type: ignore[no-untyped-def]
            state = self.cell(motor, state)
            return state, state[0] if gated else state

        # Unrolled, since one iteration holds too little work; long sequences only in part,
        # since compilation grows with the number of copies.
        start = (zero, zero) if gated else zero
        _, hidden = jax.lax.scan(advance, start, motors, unroll=min(len(motors), MAX_UNROLL))
        last = jnp.arange(len(motors)) == num_steps - 1
        return jax.nn.sigmoid(self.to_code(jnp.sum(jnp.where(last[:, None], hidden, 0.0), axis=0)))


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
