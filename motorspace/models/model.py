"""The whole network: scaling, motor encoder, sensor predictor, inverse model."""

import dataclasses
from typing import NamedTuple

import equinox as eqx
import jax
import jax.numpy as jnp
from jaxtyping import Array, Float

from motorspace._types import Code, Count, Key, Motors, Sensors
from motorspace.models.config import ENCODERS, ModelConfig
from motorspace.models.encoders.base import AbstractMotorEncoder, EncoderSize
from motorspace.models.initial_weights import reinitialised
from motorspace.models.predictors import (
    CompositionModel,
    InverseModel,
    LatentModel,
    SensorPredictor,
)


class Scaling(eqx.Module):
    """What each sensor and each command channel is divided by before the network sees it.

    Numbers, or arrays [K] and [M] within a program that is given them.
    """

    sensors: tuple[float, ...] | Float[Array, " K"]
    motors: tuple[float, ...] | Float[Array, " M"]


class Model(eqx.Module):
    """The paper's system (figure 1). Methods take one element in raw units; use `vmap`."""

    encoder: AbstractMotorEncoder
    predictor: SensorPredictor
    inverse: InverseModel | None
    scaling: Scaling
    composition: CompositionModel | None = None
    latent: LatentModel | None = None

    def encode(self, motors: Motors, num_steps: Count) -> Code:
        """The code h^m of a motor sequence."""
        return self.encoder(motors / jnp.array(self.scaling.motors)[None], num_steps)

    def predict(self, sensors: Sensors, code: Code) -> Sensors:
        """The sensors expected after the sequence behind `code`, raw units."""
        scale = jnp.array(self.scaling.sensors)
        return self.predictor(sensors / scale, code) * scale


UNSCALED = Scaling((), ())
"""In place of numbers that a program is given: networks that differ by them are one program."""


def with_scaling(model: Model, scaling: Scaling) -> Model:
    """The network with other divisors."""
    return dataclasses.replace(model, scaling=scaling)


Parts = tuple[str, ...]
"""Fields of a `Model`."""


def with_parts(model: Model, other: Model, parts: Parts) -> Model:
    """The network with these parts of another one."""

    def chosen(network: Model) -> list[eqx.Module]:
        return [getattr(network, part) for part in parts]

    return eqx.tree_at(chosen, model, chosen(other)) if parts else model


def with_fixed(model: Model, parts: Parts) -> Model:
    """The network, of which these parts have no gradient."""
    stop = jax.lax.stop_gradient
    fixed = jax.tree.map(lambda x: stop(x) if eqx.is_inexact_array(x) else x, model)
    return with_parts(model, fixed, parts)


class Extras(NamedTuple):
    """Networks beside encoder and predictor, which only some losses need."""

    inverse: bool = False
    composition: bool = False
    latent: bool = False


NO_EXTRAS = Extras()


def build_model(
    config: ModelConfig,
    scaling: Scaling,
    *,
    horizon: int,
    extras: Extras = NO_EXTRAS,
    key: Key,
) -> Model:
    """A network with initial weights for these sensors, commands and horizon."""
    encoder_key, predictor_key, inverse_key = jax.random.split(key, 3)
    sensor_size, motor_size = len(scaling.sensors), len(scaling.motors)
    size = EncoderSize(motor_size, horizon, config.hidden_size, config.code_size)
    encoder: AbstractMotorEncoder = ENCODERS.class_of(config.encoder).create(size, key=encoder_key)
    code_size = _code_size(encoder, size)
    sizes = (sensor_size, code_size, config.width_size, config.depth)
    predictor = SensorPredictor(*sizes, key=predictor_key)
    inverse = InverseModel(*sizes, key=inverse_key) if extras.inverse else None
    composition = None
    if extras.composition:
        composition_key = jax.random.fold_in(key, 3)
        composition = CompositionModel(code_size, config.width_size, key=composition_key)
    latent = LatentModel(*sizes, key=jax.random.fold_in(key, 4)) if extras.latent else None
    model = Model(encoder, predictor, inverse, UNSCALED, composition, latent)
    if config.initial_weights != "uniform":
        normal_inputs = config.initial_weights == "normal_inputs"
        model = reinitialised(model, normal_inputs=normal_inputs, key=key)
    return with_scaling(model, scaling)


def _code_size(encoder: AbstractMotorEncoder, size: EncoderSize) -> int:
    """Units of the codes that the encoder gives, whatever it was asked for."""
    motors = jax.ShapeDtypeStruct((size.horizon, size.motor_size), jnp.float32)
    steps = jax.ShapeDtypeStruct((), jnp.int32)
    return int(eqx.filter_eval_shape(encoder, motors, steps).shape[0])
