"""Networks from codes and sensors: predictors, the inverse model, the composition of codes."""

import equinox as eqx
import jax
import jax.numpy as jnp
from jaxtyping import Array, Float

from motorspace._types import Code, Key, Sensors

LATENT_SIZE = 32
"""Features that stand for the sensors where the prediction is not of sensors."""


class SensorPredictor(eqx.Module):
    """Forward model: (code, sensors now) -> sensors after the sequence, by a ReLU network.

    s_{t+T} = W_4 relu(W_3 relu(W_2 relu(W_1 [h^m, s_t]))) (section 3).
    """

    mlp: eqx.nn.MLP

    def __init__(
        self, sensor_size: int, code_size: int, width_size: int, depth: int, *, key: Key
    ) -> None:
        self.mlp = eqx.nn.MLP(
            code_size + sensor_size, sensor_size, width_size, depth, jax.nn.relu, key=key
        )

    def __call__(self, sensors: Sensors, code: Code) -> Sensors:
        return self.mlp(jnp.concatenate([code, sensors]))


class InverseModel(eqx.Module):
    """Inverse model: (sensors now, sensors later) -> code, by a ReLU network."""

    mlp: eqx.nn.MLP

    def __init__(
        self, sensor_size: int, code_size: int, width_size: int, depth: int, *, key: Key
    ) -> None:
        self.mlp = eqx.nn.MLP(
            2 * sensor_size,
            code_size,
            width_size,
            depth,
            jax.nn.relu,
            jax.nn.sigmoid,
            key=key,
        )

    def __call__(self, sensors: Sensors, later_sensors: Sensors) -> Code:
        return self.mlp(jnp.concatenate([sensors, later_sensors]))


class CompositionModel(eqx.Module):
    """From the codes of two sequences to that of both in a row, C(h(a), h(b)): not in the paper."""

    mlp: eqx.nn.MLP

    def __init__(self, code_size: int, width_size: int, *, key: Key) -> None:
        self.mlp = eqx.nn.MLP(2 * code_size, code_size, width_size, 1, jax.nn.relu, key=key)

    def __call__(self, first: Code, second: Code) -> Code:
        return self.mlp(jnp.concatenate([first, second]))


class LatentModel(eqx.Module):
    """Prediction of learned features of the sensors instead of sensors: not in the paper."""

    features: eqx.nn.MLP
    predictor: eqx.nn.MLP

    def __init__(
        self, sensor_size: int, code_size: int, width_size: int, depth: int, *, key: Key
    ) -> None:
        features_key, predictor_key = jax.random.split(key)
        sizes = LATENT_SIZE, width_size, depth, jax.nn.relu
        self.features = eqx.nn.MLP(sensor_size, *sizes, key=features_key)
        self.predictor = eqx.nn.MLP(code_size + LATENT_SIZE, *sizes, key=predictor_key)

    def __call__(self, features: Float[Array, " F"], code: Code) -> Float[Array, " F"]:
        """The features expected after the sequence behind `code`."""
        return self.predictor(jnp.concatenate([code, features]))
