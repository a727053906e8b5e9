"""Commands as generators of motions: few enough numbers to learn them from a robot's log."""

import functools
from typing import ClassVar

import equinox as eqx
import jax
import jax.numpy as jnp
from jaxtyping import Array, Float

from motorspace._types import Code, Count, Key, Motor, Motors, Scalar
from motorspace.models.encoders.base import AbstractMotorEncoder, Matrix
from motorspace.models.encoders.matrix_product import matrix_size, product

TERMS = 6
"""Terms of the exponential's series, after halving its argument `HALVINGS` times."""
HALVINGS = 4


class ExponentialEncoder(AbstractMotorEncoder):
    """Commands as generators of a matrix group: not in the paper.

    h^m = A(m_1) A(m_2) ... A(m_T) with A(m) = exp(m_1 G_1 + ... + m_M G_M): n x n matrices whose
    last row is (0 ... 0 1) and is left out. Commands add up inside the exponential, as the
    increments of odometry and the speeds of wheels do. There are only M n (n - 1) numbers to
    learn, which a few hundred scans of a log can tell.
    """

    brings_weights: ClassVar[bool] = True

    generators: Float[Array, "M n n+1"]
    size: int = eqx.field(static=True)

    def __init__(self, motor_size: int, hidden_size: int, code_size: int, *, key: Key) -> None:
        del hidden_size
        self.size = matrix_size(code_size)
        rows = INITIAL_SIZE * jax.random.normal(key, (motor_size, self.size - 1, self.size))
        linear = rows[..., :-1]
        # Generators of rigid motions: exponentials of others grow with every command.
        turning = (linear - jnp.swapaxes(linear, -1, -2)) / 2
        self.generators = rows.at[..., :-1].set(turning)

    def __call__(self, motors: Motors, num_steps: Count) -> Code:
        executed = jnp.arange(len(motors)) < num_steps
        matrices = jax.vmap(self._matrix)(jnp.where(executed[:, None], motors, 0.0))
        return functools.reduce(product, matrices)[:-1].reshape(-1)

    def penalty(self, motors: Float[Array, "N T M"]) -> Scalar:
        """Penalty on commands that are not isometries: mean ||A(m)^T A(m) - 1||_F^2."""
        linear = jax.vmap(jax.vmap(lambda m: self._matrix(m)[:-1, :-1]))(motors)
        gram = jnp.swapaxes(linear, -1, -2) @ linear
        return jnp.mean(jnp.sum((gram - jnp.eye(gram.shape[-1])[None, None]) ** 2, axis=(-2, -1)))

    def matrices(self, motor: Motor) -> tuple[Matrix, Matrix]:
        return self._matrix(motor), jnp.eye(self.size)

    def _matrix(self, motor: Motor) -> Matrix:
        rows = jnp.tensordot(motor, self.generators, axes=1)
        return exponential(jnp.zeros((self.size, self.size)).at[:-1].set(rows))


INITIAL_SIZE = 0.01
"""Standard deviation of initial generators: commands of a log have unit variance, and move little
from one scan to the next."""


def exponential(matrix: Matrix) -> Matrix:
    """exp(matrix) of a small matrix, by its series and by squaring."""
    part = matrix / 2**HALVINGS
    unit = jnp.eye(len(matrix))
    found = unit
    for term in range(TERMS, 0, -1):
        found = unit + product(part, found) / term
    for _ in range(HALVINGS):
        found = product(found, found)
    return found
