"""A trained network without its framework: plain arrays, and what is to be done with them."""

import dataclasses
from collections.abc import Callable
from typing import Any, NamedTuple

import equinox as eqx
import jax
import numpy as np
from jaxtyping import Array, Float, Int

from motorspace._errors import UserError
from motorspace.export.files import made_by
from motorspace.export.numpy_model import ACTIVATIONS, FORMAT_VERSION
from motorspace.models.encoders.attention import AGE_SCALE, AttentionEncoder
from motorspace.models.encoders.baselines import (
    ConstantEncoder,
    FlatEncoder,
    IdentityEncoder,
    SumEncoder,
)
from motorspace.models.encoders.exponential import HALVINGS, TERMS, ExponentialEncoder
from motorspace.models.encoders.matrix_product import MatrixProductEncoder
from motorspace.models.encoders.recurrent import GRUEncoder, LinearRecurrentEncoder, LSTMEncoder
from motorspace.models.model import SensorPredictor
from motorspace.training.run import Run
from motorspace.trajectories.transitions import Experience

TOLERANCE = 1e-5
"""The largest difference between a network and its export, relative to values above 1."""

CHECKED, CHECKED_STEPS = 64, 6
"""Sequences that an export is checked on, and their commands where the encoder leaves it open."""

Encode = Callable[[Float[np.ndarray, "N T M"], Int[np.ndarray, " N"]], Float[np.ndarray, "N C"]]
Predict = Callable[[Float[np.ndarray, "N K"], Float[np.ndarray, "N C"]], Float[np.ndarray, "N K"]]


class Layer(NamedTuple):
    """One dense layer: activation(weight x + bias)."""

    weight: Float[np.ndarray, "out in"]
    bias: Float[np.ndarray, " out"]
    activation: str


Layers = tuple[Layer, ...]


class Parts(NamedTuple):
    """What an encoder consists of."""

    kind: str
    layers: dict[str, Layers] = {}
    arrays: dict[str, np.ndarray] = {}
    options: dict[str, int] = {}


@dataclasses.dataclass(frozen=True)
class Network:
    """An encoder and a predictor as arrays; every value in float32."""

    encoder: Parts
    predictor: Layers
    code_size: int
    motor_scale: tuple[float, ...]
    sensor_scale: tuple[float, ...]
    horizon: int | None
    """The number of commands of every sequence, for encoders that take no other."""


def network_of(run: Run) -> Network:
    """The run's encoder and predictor as arrays.

    Raises:
        UserError: The encoder or the predictor is a class of the user's own, or has activation
            functions that no export knows.
    """
    model, scaling = run.model, run.model.scaling
    parts_of = PARTS.get(type(model.encoder))
    if parts_of is None or type(model.predictor) is not SensorPredictor:
        own = model.encoder if parts_of is None else model.predictor
        raise UserError(
            f"{type(own).__name__} is not a class of motorspace, so it has no ONNX or NumPy export",
            remedy="export the arrays alone, or train with one of motorspace's own classes",
        )
    parts, predictor = parts_of(model.encoder), _mlp_layers(model.predictor.mlp)
    code_size = predictor[0].weight.shape[1] - len(scaling.sensors)
    return Network(
        parts,
        predictor,
        code_size,
        tuple(map(float, scaling.motors)),
        tuple(map(float, scaling.sensors)),
        _fixed_horizon(parts, code_size, len(scaling.motors)),
    )


def _fixed_horizon(parts: Parts, code_size: int, motor_size: int) -> int | None:
    match parts.kind:
        case "mlp":
            return parts.layers["mlp"][0].weight.shape[1] // motor_size
        case "identity":
            return code_size // motor_size
        case _:
            return None


def described(run: Run, network: Network) -> dict[str, Any]:
    """What `model.json` says of a network: its kind, sizes, scales, and the run's configuration."""
    layers = {**network.encoder.layers, "predictor": network.predictor}
    return {
        "format_version": FORMAT_VERSION,
        "encoder": network.encoder.kind,
        **network.encoder.options,
        "code_size": network.code_size,
        "horizon": network.horizon,
        "motor_scale": list(network.motor_scale),
        "sensor_scale": list(network.sensor_scale),
        "activations": {name: [layer.activation for layer in mlp] for name, mlp in layers.items()},
        **made_by(run),
    }


def named_weights(network: Network) -> dict[str, np.ndarray]:
    """Every array of a network by its name."""
    layers = {**network.encoder.layers, "predictor": network.predictor}
    named = dict(network.encoder.arrays)
    for name, mlp in layers.items():
        for index, layer in enumerate(mlp):
            named[f"{name}.{index}.weight"], named[f"{name}.{index}.bias"] = layer[:2]
    return named


def largest_difference(run: Run, network: Network, encode: Encode, predict: Predict) -> float:
    """How far an export is from the run, on random sequences.

    Differences of codes are relative to the largest code where that is above 1; differences of
    predicted sensors are shares of the sensors' scale.

    Raises:
        UserError: The difference is above `TOLERANCE`.
    """
    motors, num_steps, sensors = _random_inputs(network)
    scale = np.asarray(network.sensor_scale, np.float32)
    # Accelerators multiply with fewer digits unless asked not to.
    with jax.default_matmul_precision("highest"):
        codes = np.asarray(run.encode(motors, num_steps))
        given = Experience(*(jax.numpy.asarray(a) for a in (sensors, motors, num_steps, sensors)))
        later = np.asarray(run.predict(given))
    found = encode(motors, num_steps)
    predicted = _relative(predict(sensors, found) / scale, later / scale)
    # NumPy's maximum, unlike Python's, is NaN if either is, and NaN is not within the tolerance.
    difference = float(np.maximum(_relative(found, codes), predicted))
    if not difference <= TOLERANCE:
        raise UserError(
            f"the exported network differs from the run by {difference:.2g}, "
            f"more than {TOLERANCE:g}, so nothing is written",
            remedy="report this with the run's config.json",
        )
    return difference


def _random_inputs(network: Network) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Motors, num_steps and sensors, about as large as the network's scales."""
    rng = np.random.default_rng(0)
    horizon, motor_size = network.horizon or CHECKED_STEPS, len(network.motor_scale)
    motors = rng.normal(size=(CHECKED, horizon, motor_size)) * network.motor_scale
    num_steps = rng.integers(1, horizon, CHECKED, endpoint=True, dtype=np.int32)
    sensors = rng.random((CHECKED, len(network.sensor_scale))) * network.sensor_scale
    return motors.astype(np.float32), num_steps, sensors.astype(np.float32)


def _relative(found: np.ndarray, expected: np.ndarray) -> float:
    if found.shape != expected.shape:
        return float("inf")
    return float(np.max(np.abs(found - expected)) / max(1.0, float(np.max(np.abs(expected)))))


def _array(value: Array) -> np.ndarray:
    return np.asarray(value, np.float32)


def _layer(linear: eqx.nn.Linear, activation: str = "identity") -> Layer:
    weight = _array(linear.weight)
    bias = np.zeros(len(weight), np.float32) if linear.bias is None else _array(linear.bias)
    return Layer(weight, bias, activation)


def _mlp_layers(mlp: eqx.nn.MLP) -> Layers:
    hidden, final = _activation(mlp.activation), _activation(mlp.final_activation)
    *first, last = mlp.layers
    return (*(_layer(linear, hidden) for linear in first), _layer(last, final))


def _activation(function: Callable[[Array], Array]) -> str:
    """The name of an activation function, found by what it does."""
    points = np.linspace(-3, 3, 7, dtype=np.float32)
    values = np.asarray(function(jax.numpy.asarray(points)))
    for name, candidate in ACTIVATIONS.items():
        if np.allclose(values, candidate(points), atol=1e-5):
            return name
    raise UserError(
        "the network has an activation function that cannot be exported",
        remedy=f"use one of {', '.join(ACTIVATIONS)}",
    )


def _recurrent(encoder: LSTMEncoder | GRUEncoder) -> Parts:
    cell = encoder.cell
    kind = "lstm" if isinstance(cell, eqx.nn.LSTMCell) else "gru"
    names = ("weight_ih", "weight_hh", "bias", *(("bias_n",) if kind == "gru" else ()))
    arrays = {name: _array(getattr(cell, name)) for name in names}
    return Parts(kind, {"to_code": (_layer(encoder.to_code, "sigmoid"),)}, arrays)


def _linear(encoder: LinearRecurrentEncoder) -> Parts:
    layers = {"to_state": (_layer(encoder.to_state),), "to_code": _mlp_layers(encoder.to_code)}
    arrays = {"log_decay": _array(encoder.log_decay), "phase": _array(encoder.phase)}
    return Parts("linear", layers, arrays)


def _attention(encoder: AttentionEncoder) -> Parts:
    attention = encoder.attention
    layers = {
        "to_token": _mlp_layers(encoder.to_token),
        "query": (_layer(attention.query_proj),),
        "key": (_layer(attention.key_proj),),
        "value": (_layer(attention.value_proj),),
        "output": (_layer(attention.output_proj),),
        "to_code": _mlp_layers(encoder.to_code),
    }
    options = {"num_heads": attention.num_heads, "age_scale": AGE_SCALE}
    return Parts("attention", layers, {}, options)


def _matrix_product(encoder: MatrixProductEncoder) -> Parts:
    layers = {
        "transition": _whole_matrix(_mlp_layers(encoder.transition), encoder.size),
        "readout": _whole_matrix(_mlp_layers(encoder.readout), encoder.size),
    }
    return Parts("matrix_product", layers, {}, {"matrix_size": encoder.size})


def _exponential(encoder: ExponentialEncoder) -> Parts:
    rows = _array(encoder.generators)
    generators = np.concatenate([rows, np.zeros_like(rows[:, :1])], axis=1)
    options = {"matrix_size": encoder.size, "terms": TERMS, "halvings": HALVINGS}
    return Parts("exponential", {}, {"generators": generators}, options)


def _whole_matrix(layers: Layers, size: int) -> Layers:
    """Layers that give all n x n entries: the identity and the fixed last row are in the bias."""
    *first, (weight, bias, activation) = layers
    weight = np.concatenate([weight, np.zeros((size, weight.shape[1]), np.float32)])
    bias = np.concatenate([bias, np.zeros(size, np.float32)])
    return (*first, Layer(weight, bias + np.eye(size, dtype=np.float32).ravel(), activation))


def _mlp(kind: str) -> Callable[[SumEncoder | FlatEncoder], Parts]:
    return lambda encoder: Parts(kind, {"mlp": _mlp_layers(encoder.mlp)})


PARTS: dict[type, Callable[[Any], Parts]] = {
    LSTMEncoder: _recurrent,
    GRUEncoder: _recurrent,
    LinearRecurrentEncoder: _linear,
    AttentionEncoder: _attention,
    MatrixProductEncoder: _matrix_product,
    ExponentialEncoder: _exponential,
    SumEncoder: _mlp("sum"),
    FlatEncoder: _mlp("mlp"),
    ConstantEncoder: lambda encoder: Parts("none"),
    IdentityEncoder: lambda encoder: Parts("identity"),
}
"""How each encoder is taken apart."""
