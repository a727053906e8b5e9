"""What is left of a goal after a part of the way: h(remaining) from h(goal) and what was done."""

import equinox as eqx
import jax
import jax.numpy as jnp
from jaxtyping import Array, Bool, Float

from motorspace._types import Code, Count, Motor, Motors
from motorspace.models.encoders.base import Matrix
from motorspace.models.encoders.matrix_product import matrix_size
from motorspace.models.model import Model
from motorspace.worlds.spaces import ContinuousCommands


class Remainder(eqx.Module):
    """From the codes of what was done and of the goal to the code of what remains, learned.

    For codes that are no products. Codes enter and leave whitened.
    """

    mlp: eqx.nn.MLP

    def __call__(self, done: Code, goal: Code) -> Code:
        return self.mlp(jnp.concatenate([done, goal]))


def held(commands: ContinuousCommands, motors: Motors, num: Count) -> Motors:
    """The first `num` commands, after which the agent stands still and looks where it looks."""
    looks = jnp.array([channel in commands.looking for channel in range(commands.size)], bool)
    rest = jnp.where(looks, motors[num - 1], 0.0)
    return jnp.where(jnp.arange(len(motors))[:, None] < num, motors, rest[None])


def is_product(model: Model) -> bool:
    """Whether codes are products of matrices."""
    motor = jax.ShapeDtypeStruct((len(model.scaling.motors),), jnp.float32)
    return eqx.filter_eval_shape(model.encoder.matrices, motor) is not None


def chained(model: Model, motors: Motors, carried_out: Bool[Array, " L"]) -> Matrix:
    """The product of A(m) over the commands carried out: what they do to all that follows."""
    scale = jnp.array(model.scaling.motors)

    def transition(motor: Motor) -> Matrix:
        matrices = model.encoder.matrices(motor / scale)
        assert matrices is not None, "asked of products of matrices only"
        return matrices[0]

    matrices = jax.vmap(transition)(motors)
    unit = jnp.eye(matrices.shape[-1])
    matrices = jnp.where(carried_out[:, None, None], matrices, unit[None])
    return jax.lax.scan(lambda before, matrix: (before @ matrix, None), unit, matrices)[0]


def remaining(model: Model, goal: Code, motors: Motors, carried_out: Bool[Array, " L"]) -> Code:
    """The code that leads to `goal` after the commands carried out: (A_1 ... A_n)^-1 G.

    The sensors' own last matrix H is in the goal G and not in what was done.
    """
    return as_code(jnp.linalg.solve(chained(model, motors, carried_out), as_matrix(goal)))


def as_matrix(code: Code) -> Matrix:
    """The matrix whose first n - 1 rows are the code."""
    size = matrix_size(len(code))
    last: Float[Array, "1 n"] = jnp.eye(size)[-1:]
    return jnp.concatenate([code.reshape(size - 1, size), last])


def as_code(matrix: Matrix) -> Code:
    """The first n - 1 rows of a matrix."""
    return matrix[:-1].reshape(-1)
