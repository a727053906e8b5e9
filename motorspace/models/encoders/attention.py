"""An encoder that attends to all commands at once."""

import equinox as eqx
import jax
import jax.numpy as jnp

from motorspace._types import Code, Count, Key, Motors
from motorspace.models.encoders.base import AbstractMotorEncoder, code_mlp

NUM_HEADS = 4
AGE_SCALE = 8
BIASED = ("query", "key", "value", "output")
"""What the position of a command is divided by."""


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
        biases = dict.fromkeys([f"use_{part}_bias" for part in BIASED], True)
        self.attention = eqx.nn.MultiheadAttention(NUM_HEADS, size, **biases, key=attention_key)
        self.to_code = code_mlp(2 * size, hidden_size, code_size, key=code_key)

    def __call__(self, motors: Motors, num_steps: Count) -> Code:
        age = num_steps - 1 - jnp.arange(len(motors))
        placed = jnp.concatenate([motors, age[:, None] / AGE_SCALE], axis=1)
        tokens = jax.vmap(self.to_token)(placed)
        seen = jnp.broadcast_to(age >= 0, (len(motors), len(motors)))
        attended = tokens + self.attention(tokens, tokens, tokens, mask=seen)
        weight = jnp.where(age >= 0, 1.0, 0.0)[:, None]
        last = jnp.where(age == 0, 1.0, 0.0)[:, None]
        pooled = [jnp.sum(last * attended, axis=0), jnp.sum(weight * attended, axis=0)]
        return self.to_code(jnp.concatenate(pooled))
