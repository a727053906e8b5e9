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
from motorspace.analysis.probes import displacement_targets
from motorspace.models.model import Model
from motorspace.worlds.spaces import CommandSpace

LEAST_SHARE = 0.01
"""The least variance of a direction, as a share of the largest: some hardly vary at all."""
LEAST_SPREAD = 1e-3
"""Of displacements: a direction in which the examples do not move is not blown up."""
EDGE = 2.0
"""Standard deviations beyond which the bend stays what it is at the edge."""
AFFINE = 5
"""The constant and the four components, which are never held small."""
NUM_MONOMIALS = AFFINE + 10
RIDGES = tuple(10.0**power for power in range(-4, 5))
"""Strengths of the regularisation of the bend, per example; the last leaves none."""


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
    """A map from displacements to codes: affine, with a slight bend within reach of the examples.

    A displacement counts as (longitudinal, lateral, cos, sin of the turn). Codes of short rotations
    are not quite affine in it; far from the examples only the affine part goes on.
    """

    centre: Float[Array, "4"]
    spread: Float[Array, "4"]
    weights: Float[Array, "F C"]

    def __call__(self, displacement: Displacement) -> Code:
        """The code of a displacement."""
        return self.monomials(displacement) @ self.weights

    def monomials(self, displacement: Displacement) -> Float[Array, " F"]:
        """The constant, the components in standard units, and near the examples their products."""
        (target,) = displacement_targets(displacement[None])
        values = (target - self.centre) / self.spread
        near = values.clip(-EDGE, EDGE)
        first, second = np.triu_indices(4)
        return jnp.concatenate([jnp.ones(1), values, near[first] * near[second]])


def blank_probe(code_size: int) -> Probe:
    """A probe that maps everything to zero."""
    return Probe(jnp.zeros(4), jnp.ones(4), jnp.zeros((NUM_MONOMIALS, code_size)))


def fit_probe(displacements: Float[np.ndarray, "N 3"], codes: Float[Array, "N C"]) -> Probe:
    """The probe that fits labelled examples; leaving each out tells how much bend they support."""
    targets = np.asarray(displacement_targets(jnp.asarray(displacements)))
    spread = np.maximum(targets.std(axis=0), LEAST_SPREAD)
    probe = Probe(jnp.asarray(targets.mean(axis=0)), jnp.asarray(spread), jnp.zeros((0, 0)))
    known = np.asarray(jax.vmap(probe.monomials)(jnp.asarray(displacements)), np.float64)
    fits = [_ridge(known, np.asarray(codes, np.float64), ridge) for ridge in RIDGES]
    weights, _ = min(fits, key=lambda fit: fit[1])
    return eqx.tree_at(lambda p: p.weights, probe, jnp.asarray(weights, jnp.float32))


def _ridge(
    known: Float[np.ndarray, "N F"], codes: Float[np.ndarray, "N C"], ridge: float
) -> tuple[Float[np.ndarray, "F C"], float]:
    """The weights, and the squared error on each example by the fit without it."""
    held = np.where(np.arange(known.shape[1]) < AFFINE, 1e-9, ridge)
    inverse = np.linalg.inv(known.T @ known + len(known) * np.diag(held))
    weights = inverse @ known.T @ codes
    leverage = np.einsum("nf,fg,ng->n", known, inverse, known)
    left_out = (codes - known @ weights) / np.maximum(1 - leverage, 1e-6)[:, None]
    return weights, float(np.mean(left_out**2))
