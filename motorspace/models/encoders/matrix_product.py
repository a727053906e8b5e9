"""Commands as matrices that multiply, as displacements do."""

import functools
import math
from typing import ClassVar

import equinox as eqx
import jax
import jax.numpy as jnp
from jaxtyping import Array, Float

from motorspace._errors import UserError
from motorspace._types import Code, Count, Key, Motor, Motors, Scalar
from motorspace.models.encoders.base import AbstractMotorEncoder, Matrix


class MatrixProductEncoder(AbstractMotorEncoder):
    """Commands as matrices that multiply, as displacements do: not in the paper.

    h^m = A(m_1) A(m_2) ... A(m_T) H(m_T), n x n matrices whose last row is (0 ... 0 1) and is
    left out. A says what a command does to all that follows it; H what the last one does to the
    sensors alone, such as the angle of a head. Sequences that make the same product have the same
    code, whatever follows or precedes them. With n = 3 there is just room for the plane's motions.
    """

    brings_weights: ClassVar[bool] = True  # which angles it learns to turn by depends on them

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
        matrices = jnp.where(executed[:, None, None], matrices, unit[None])
        moved = functools.reduce(product, matrices)
        last = self._matrix(self.readout, motors[num_steps - 1])
        return product(moved, last)[:-1].reshape(-1)

    def penalty(self, motors: Float[Array, "N T M"]) -> Scalar:
        """Penalty on commands that are not isometries: mean ||A(m)^T A(m) - 1||_F^2.

        A without its translation. A small growth with each command adds up over many of them.
        """
        linear = jax.vmap(jax.vmap(self._linear_part))(motors)
        gram = jnp.swapaxes(linear, -1, -2) @ linear
        return jnp.mean(jnp.sum((gram - jnp.eye(gram.shape[-1])[None, None]) ** 2, axis=(-2, -1)))

    def matrices(self, motor: Motor) -> tuple[Matrix, Matrix]:
        return self._matrix(self.transition, motor), self._matrix(self.readout, motor)

    def _linear_part(self, motor: Motor) -> Matrix:
        """What a command does to directions: A without its translation."""
        return self._matrix(self.transition, motor)[:-1, :-1]

    def _matrix(self, mlp: eqx.nn.MLP, motor: Motor) -> Matrix:
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
            remedy="give encoders of matrices a code_size of n (n - 1): 6, 12, 20, 30, ...",
        )
    return size


def product(left: Matrix, right: Matrix) -> Matrix:
    """left @ right, as a sum that is compiled into one loop over a batch of small matrices."""
    return jnp.sum(left[:, :, None] * right[None, :, :], axis=1)
