"""From a code back to motor commands that have it: many sequences do, and noise chooses one."""

import equinox as eqx
import jax
import jax.numpy as jnp
from jaxtyping import Array, Float

from motorspace._types import Code, Key, Motors
from motorspace.worlds.spaces import ContinuousCommands

Logits = Float[Array, "T M"]
"""A motor sequence before it is squashed into the bounds of the commands."""

STEEPEST = 6.0
"""Logits beyond this are as good as at the bound, and have no gradient left."""


def squash(commands: ContinuousCommands, logits: Logits) -> Motors:
    """The motor sequence within the bounds, raw units."""
    return commands.spread(jax.nn.sigmoid(logits).T).T


def unsquash(commands: ContinuousCommands, motors: Motors) -> Logits:
    """The logits of a motor sequence, at most `STEEPEST`."""
    return jax.scipy.special.logit(commands.shares(motors.T).T).clip(-STEEPEST, STEEPEST)


class Decoder(eqx.Module):
    """Logits of a motor sequence, from a whitened code and noise, by a ReLU network."""

    mlp: eqx.nn.MLP
    horizon: int = eqx.field(static=True)
    noise_size: int = eqx.field(static=True)

    def __init__(
        self,
        sizes: tuple[int, int, int],
        noise_size: int,
        *,
        width_size: int,
        depth: int,
        key: Key,
    ) -> None:
        """Of code size, horizon and command size."""
        code_size, self.horizon, motor_size = sizes
        self.noise_size = noise_size
        out_size = self.horizon * motor_size
        self.mlp = eqx.nn.MLP(
            code_size + noise_size, out_size, width_size, depth, jax.nn.relu, key=key
        )

    def __call__(self, code: Code, noise: Float[Array, " Z"]) -> Logits:
        logits = self.mlp(jnp.concatenate([code, noise])).reshape(self.horizon, -1)
        return STEEPEST * jnp.tanh(logits / STEEPEST)
