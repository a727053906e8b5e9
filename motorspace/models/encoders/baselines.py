"""Encoders to compare with: of no order, of no recurrence, of no motors, of the code itself."""

from typing import ClassVar

import equinox as eqx
import jax.numpy as jnp

from motorspace._types import Code, Count, Key, Motors
from motorspace.models.encoders.base import (
    AbstractMotorEncoder,
    EncoderSize,
    code_mlp,
    executed,
)


class SumEncoder(AbstractMotorEncoder):
    """A baseline that cannot know the order of the commands: an MLP on their sum."""

    mlp: eqx.nn.MLP

    def __init__(self, motor_size: int, hidden_size: int, code_size: int, *, key: Key) -> None:
        self.mlp = code_mlp(motor_size, hidden_size, code_size, key=key)

    def __call__(self, motors: Motors, num_steps: Count) -> Code:
        return self.mlp(jnp.sum(executed(motors, num_steps), axis=0))


class FlatEncoder(AbstractMotorEncoder):
    """A baseline without recurrence: an MLP on the whole sequence, flattened."""

    any_length: ClassVar[bool] = False

    mlp: eqx.nn.MLP

    @classmethod
    def create(cls, size: EncoderSize, *, key: Key) -> "FlatEncoder":
        in_size = size.horizon * size.motor_size
        return cls(code_mlp(in_size, size.hidden_size, size.code_size, key=key))

    def __call__(self, motors: Motors, num_steps: Count) -> Code:
        return self.mlp(executed(motors, num_steps).reshape(-1))


class ConstantEncoder(AbstractMotorEncoder):
    """A baseline that knows nothing of the commands: what is left is a no-motor model."""

    learned: ClassVar[bool] = False

    code_size: int = eqx.field(static=True)

    @classmethod
    def create(cls, size: EncoderSize, *, key: Key) -> "ConstantEncoder":
        del key
        return cls(size.code_size)

    def __call__(self, motors: Motors, num_steps: Count) -> Code:
        del motors, num_steps
        return jnp.zeros(self.code_size)


class IdentityEncoder(AbstractMotorEncoder):
    """The sequence itself, flattened: for baselines that are given their code."""

    learned: ClassVar[bool] = False
    any_length: ClassVar[bool] = False

    @classmethod
    def create(cls, size: EncoderSize, *, key: Key) -> "IdentityEncoder":
        del size, key
        return cls()

    def __call__(self, motors: Motors, num_steps: Count) -> Code:
        del num_steps
        return motors.reshape(-1)
