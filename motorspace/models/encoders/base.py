"""What every motor encoder answers, and the encoders there are by name."""

import abc
from typing import Any, ClassVar, NamedTuple

import equinox as eqx
import jax
import jax.numpy as jnp
from jaxtyping import Array, Float

from motorspace._kinds import Registry
from motorspace._types import Code, Count, Key, Motor, Motors, Scalar
from motorspace.models.config import ENCODERS

Matrix = Float[Array, "n n"]


class EncoderSize(NamedTuple):
    """What an encoder is made for."""

    motor_size: int
    """Channels of a motor command (M)."""
    horizon: int
    """Commands of the longest sequence (T)."""
    hidden_size: int
    code_size: int


class AbstractMotorEncoder(eqx.Module):
    """Encodes the first `num_steps` rows of a (scaled) motor sequence into a code h^m."""

    registry: ClassVar[Registry[Any]] = ENCODERS

    learned: ClassVar[bool] = True
    """Whether training shapes the codes, so that codes which do not vary have collapsed."""

    brings_weights: ClassVar[bool] = False
    """Whether the encoder's own initial weights are kept, whatever `initial_weights` says."""

    any_length: ClassVar[bool] = True
    """Whether it encodes sequences longer than those it was made for."""

    @classmethod
    def create(cls, size: EncoderSize, *, key: Key) -> "AbstractMotorEncoder":
        """An encoder with initial weights; by default `cls(motor, hidden, code size, key=key)`."""
        made: Any = cls
        encoder: AbstractMotorEncoder = made(
            size.motor_size, size.hidden_size, size.code_size, key=key
        )
        return encoder

    @abc.abstractmethod
    def __call__(self, motors: Motors, num_steps: Count) -> Code:
        """The code h^m of the sequence."""

    def penalty(self, motors: Float[Array, "N T M"]) -> Scalar:
        """What `isometry_weight` weighs, on a batch of scaled sequences; none by default."""
        del motors
        return jnp.zeros(())

    def matrices(self, motor: Motor) -> tuple[Matrix, Matrix] | None:
        """A and H of one scaled command, of an encoder whose codes are products of matrices."""
        del motor
        return None


def executed(motors: Motors, num_steps: Count) -> Motors:
    """The motor sequence with zeros for the rows that are no part of it."""
    return jnp.where(jnp.arange(len(motors))[:, None] < num_steps, motors, 0.0)


def code_mlp(in_size: int, width_size: int, code_size: int, *, key: Key) -> eqx.nn.MLP:
    """Two hidden layers, then a sigmoid layer, as the paper's codes end in one."""
    return eqx.nn.MLP(in_size, code_size, width_size, 2, final_activation=jax.nn.sigmoid, key=key)
