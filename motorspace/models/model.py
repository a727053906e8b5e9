"""The whole network: scaling, motor encoder, sensor predictor, inverse model."""

import equinox as eqx
import jax
import jax.numpy as jnp
from jaxtyping import Array, Float

from motorspace._types import Code, Count, Key, Motors, Sensors
from motorspace.models.config import ModelConfig
from motorspace.models.encoder import (
    AbstractMotorEncoder,
    AttentionEncoder,
    ConstantEncoder,
    FlatEncoder,
    GroupEncoder,
    IdentityEncoder,
    LinearRecurrentEncoder,
    RecurrentEncoder,
    SumEncoder,
)


class Scaling(eqx.Module):
    """What each sensor and each command channel is divided by before the network sees it."""

    sensors: tuple[float, ...] = eqx.field(static=True)
    motors: tuple[float, ...] = eqx.field(static=True)


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


class Model(eqx.Module):
    """The paper's system (figure 1). Methods take one element in raw units; use `vmap`."""

    encoder: AbstractMotorEncoder
    predictor: SensorPredictor
    inverse: InverseModel | None
    scaling: Scaling
    composition: CompositionModel | None = None

    def encode(self, motors: Motors, num_steps: Count) -> Code:
        """The code h^m of a motor sequence."""
        return self.encoder(motors / jnp.array(self.scaling.motors), num_steps)

    def predict(self, sensors: Sensors, code: Code) -> Sensors:
        """The sensors expected after the sequence behind `code`, raw units."""
        scale = jnp.array(self.scaling.sensors)
        return self.predictor(sensors / scale, code) * scale


def build_model(config: ModelConfig, scaling: Scaling, *, horizon: int, key: Key) -> Model:
    """A fresh network for these sensors, commands and horizon."""
    encoder_key, predictor_key, inverse_key = jax.random.split(key, 3)
    sensor_size, motor_size = len(scaling.sensors), len(scaling.motors)
    hidden_size, code_size = config.hidden_size, config.code_size
    encoder: AbstractMotorEncoder
    match config.encoder:
        case "lstm" | "gru":
            encoder = RecurrentEncoder(
                motor_size, hidden_size, code_size, gated=config.encoder, key=encoder_key
            )
        case "group":
            encoder = GroupEncoder(motor_size, hidden_size, code_size, key=encoder_key)
        case "linear":
            encoder = LinearRecurrentEncoder(motor_size, hidden_size, code_size, key=encoder_key)
        case "attention":
            encoder = AttentionEncoder(motor_size, hidden_size, code_size, key=encoder_key)
        case "sum":
            encoder = SumEncoder(motor_size, hidden_size, code_size, key=encoder_key)
        case "mlp":
            encoder = FlatEncoder(motor_size, horizon, hidden_size, code_size, key=encoder_key)
        case "none":
            encoder = ConstantEncoder(code_size)
        case "identity":
            encoder, code_size = IdentityEncoder(), horizon * motor_size
    sizes = (sensor_size, code_size, config.width_size, config.depth)
    predictor = SensorPredictor(*sizes, key=predictor_key)
    inverse = InverseModel(*sizes, key=inverse_key) if config.inverse_weight > 0 else None
    composition = None
    if config.composition_weight > 0:
        composition_key = jax.random.fold_in(key, 3)
        composition = CompositionModel(code_size, config.width_size, key=composition_key)
    model = Model(encoder, predictor, inverse, scaling, composition)
    if config.initial_weights == "uniform":
        return model
    return _reinitialised(model, wide=config.initial_weights == "wide", key=key)


def _reinitialised(model: Model, *, wide: bool, key: Key) -> Model:
    """The model with variance-preserving weights and zero biases.

    Linear layers follow He et al. (2015), an LSTM's input weights Glorot and Bengio (2010); its
    recurrent matrix is orthogonal per gate and its forget gate starts open (bias 1). Wide input
    weights are standard normal instead: a gate then bends about once per radian, as it must to
    fold turns that lead to the same orientation.
    """
    is_layer = lambda node: isinstance(node, eqx.nn.Linear | eqx.nn.LSTMCell)  # noqa: E731
    # A group encoder has initial weights of its own: what it learns to turn by hangs on them.
    is_leaf = lambda node: is_layer(node) or isinstance(node, GroupEncoder)  # noqa: E731
    leaves, structure = jax.tree.flatten(model, is_leaf=is_leaf)
    keys = jax.random.split(key, len(leaves))
    fresh = [
        _scaled_layer(leaf, wide=wide, key=k) if is_layer(leaf) else leaf
        for leaf, k in zip(leaves, keys, strict=True)
    ]
    return jax.tree.unflatten(structure, fresh)


def _scaled_layer(
    layer: eqx.nn.Linear | eqx.nn.LSTMCell, *, wide: bool, key: Key
) -> eqx.nn.Linear | eqx.nn.LSTMCell:
    if isinstance(layer, eqx.nn.Linear):
        out_size, in_size = layer.weight.shape
        weight = jax.nn.initializers.he_normal(1, 0)(key, (out_size, in_size))
        return eqx.tree_at(lambda m: (m.weight, m.bias), layer, (weight, jnp.zeros((out_size,))))
    input_key, hidden_key = jax.random.split(key)
    hidden_size, in_size = layer.hidden_size, layer.input_size
    if wide:
        from_input = jax.random.normal(input_key, (4 * hidden_size, in_size))
    else:
        glorot = jax.nn.initializers.glorot_uniform(1, 0)
        gates = [glorot(k, (hidden_size, in_size)) for k in jax.random.split(input_key, 4)]
        from_input = jnp.concatenate(gates)
    orthogonal = jax.nn.initializers.orthogonal()
    from_hidden = [
        orthogonal(k, (hidden_size, hidden_size)) for k in jax.random.split(hidden_key, 4)
    ]
    bias: Float[Array, " H4"] = jnp.zeros(4 * hidden_size)
    return eqx.tree_at(
        lambda m: (m.weight_ih, m.weight_hh, m.bias),
        layer,
        (
            from_input,
            jnp.concatenate(from_hidden),
            bias.at[hidden_size : 2 * hidden_size].set(1.0),
        ),
    )
