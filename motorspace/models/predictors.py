"""Networks from codes and sensors: the predictor, the inverse model, the composition of codes."""

import equinox as eqx
import jax
import jax.numpy as jnp

from motorspace._types import Code, Key, Sensors


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
