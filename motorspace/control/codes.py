"""The space of codes as a controller sees it: how codes are spread, which displacements they mean.

The agent's own encoder and its own random commands determine the spread; the map from
displacements alone needs examples whose displacement is known (`Probe`).
"""

from typing import NamedTuple

import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Float

from motorspace._types import Code, Displacement, Key, Motors, Scalar
from motorspace.analysis.probes import displacement_targets, linear_decoder
from motorspace.models.model import Model
from motorspace.worlds.spaces import CommandSpace

LEAST_SHARE = 0.01
"""The least variance of a direction, as a share of the largest: some hardly vary at all."""


class Examples(NamedTuple):
    """Random motor sequences and their codes."""

    motors: Float[Array, "N T M"]
    codes: Float[Array, "N C"]


def encode(model: Model, motors: Motors) -> Code:
    """The code of a whole motor sequence [T, M], raw units."""
    return model.encode(motors, jnp.array(len(motors), jnp.int32))


def random_sequence(commands: CommandSpace, horizon: int, *, key: Key) -> Motors:
    """A uniformly random motor sequence [T, M]."""
    return jax.vmap(lambda k: commands.sample(key=k))(jax.random.split(key, horizon))


def random_sequences(
    commands: CommandSpace, size: tuple[int, int], *, key: Key
) -> Float[Array, "N T M"]:
    """Uniformly random motor sequences of a (number, horizon)."""
    num, horizon = size
    keys = jax.random.split(key, num)
    return jax.vmap(lambda k: random_sequence(commands, horizon, key=k))(keys)


def examples(model: Model, commands: CommandSpace, size: tuple[int, int], *, key: Key) -> Examples:
    """Random motor sequences of a (number, horizon), with their codes."""
    motors = random_sequences(commands, size, key=key)
    return Examples(motors, jax.vmap(lambda m: encode(model, m))(motors))


class Whitening(eqx.Module):
    """An affine map after which the codes of random sequences have unit variance.

    Directions in which codes hardly vary are not blown up (`LEAST_SHARE`).
    """

    centre: Float[Array, " C"]
    weights: Float[Array, "C C"]

    def __call__(self, code: Code) -> Code:
        return self.weights @ (code - self.centre)

    def undone(self, white: Code) -> Code:
        """The code that is whitened to this."""
        return jnp.linalg.solve(self.weights, white) + self.centre

    def distance(self, code: Code, goal: Code) -> Scalar:
        """The squared distance of two codes."""
        return jnp.sum((self.weights @ (code - goal)) ** 2)


def whitening(codes: Float[Array, "N C"]) -> Whitening:
    """The whitening of these codes."""
    points = np.asarray(codes, np.float64)
    variances, directions = np.linalg.eigh(np.atleast_2d(np.cov(points.T)))
    floor = max(LEAST_SHARE * variances[-1], 1e-12)
    weights = directions.T / np.sqrt(np.maximum(variances, floor))[:, None]
    centre = points.mean(axis=0)
    return Whitening(jnp.asarray(centre, jnp.float32), jnp.asarray(weights, jnp.float32))


class Probe(eqx.Module):
    """The affine map from (longitudinal, lateral, cos, sin of the turn) to codes."""

    level: Float[Array, " C"]
    weights: Float[Array, "4 C"]

    def __call__(self, displacement: Displacement) -> Code:
        """The code of a displacement."""
        return self.level + displacement_targets(displacement[None])[0] @ self.weights


def fit_probe(displacements: Float[np.ndarray, "N 3"], codes: Float[Array, "N C"]) -> Probe:
    """The probe that fits labelled examples best."""
    targets = displacement_targets(jnp.asarray(displacements))
    decode = linear_decoder(np.asarray(targets), np.asarray(codes))
    corners = decode(np.concatenate([np.zeros((1, 4)), np.eye(4)]))
    level, weights = corners[0], corners[1:] - corners[0]
    return Probe(jnp.asarray(level, jnp.float32), jnp.asarray(weights, jnp.float32))
