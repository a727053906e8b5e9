"""A trained encoder and predictor that need NumPy and nothing else.

`motorspace export RUN --numpy` copies this file, as `motorspace_model.py`, beside the weights:

    from motorspace_model import load

    model = load("FOLDER")
    codes = model.encode(motors, num_steps)   # [N, T, M], [N] -> [N, C]
    later = model.predict(sensors, codes)     # [N, K], [N, C] -> [N, K]

N motor sequences of at most T commands, M command channels, K sensors, C units of the code.
Commands and sensors are in the units that the network was trained in. Computes in float32.
"""

import json
import math
import os
from collections.abc import Callable
from typing import Any

import numpy as np


class Model:
    """The encoder and the predictor of one run.

    Attributes:
        description: What `model.json` says: the kind of encoder, sizes, scales, configuration.
        weights: The arrays of `weights.npz` by name.
    """

    def __init__(self, description: dict[str, Any], weights: dict[str, np.ndarray]) -> None:
        self.description = description
        self.weights = weights

    def encode(self, motors: np.ndarray, num_steps: np.ndarray | None = None) -> np.ndarray:
        """The codes of N motor sequences.

        Args:
            motors: Motor sequences [N, T, M]; what follows the first `num_steps` rows is ignored.
            num_steps: Commands of each sequence [N], from 1 to T; all T when left out.

        Returns:
            Codes [N, C], float32.

        Raises:
            ValueError: The shapes do not fit the network.
        """
        motors = np.asarray(motors, np.float32)
        channels, horizon = len(self.description["motor_scale"]), self.description["horizon"]
        if motors.ndim != 3 or motors.shape[2] != channels or motors.shape[1] < 1:
            raise ValueError(f"motors must be [N, T, {channels}], not {list(motors.shape)}")
        num, longest = motors.shape[:2]
        if horizon is not None and longest != horizon:
            raise ValueError(f"this encoder takes sequences of {horizon} commands, not {longest}")
        steps = np.full(num, longest) if num_steps is None else np.asarray(num_steps)
        if steps.shape != (num,) or not np.all((steps >= 1) & (steps <= longest)):
            raise ValueError(f"num_steps must be {num} numbers from 1 to {longest}")
        scale = np.asarray(self.description["motor_scale"], np.float32)
        return ENCODERS[self.description["encoder"]](self, motors / scale, steps)

    def predict(self, sensors: np.ndarray, codes: np.ndarray) -> np.ndarray:
        """The sensors expected after the motor sequences.

        Args:
            sensors: Sensors before the sequences [N, K].
            codes: Codes of the sequences [N, C].

        Returns:
            Sensors after them [N, K], float32.

        Raises:
            ValueError: The shapes do not fit the network.
        """
        sensors, codes = np.asarray(sensors, np.float32), np.asarray(codes, np.float32)
        scale = np.asarray(self.description["sensor_scale"], np.float32)
        num, size = len(sensors), self.description["code_size"]
        if sensors.shape != (num, len(scale)) or codes.shape != (num, size):
            raise ValueError(
                f"sensors and codes must be [N, {len(scale)}] and [N, {size}], "
                f"not {list(sensors.shape)} and {list(codes.shape)}"
            )
        seen = np.concatenate([codes, sensors / scale], axis=1)
        return self.layers("predictor", seen) * scale

    def layers(self, name: str, values: np.ndarray) -> np.ndarray:
        """The dense layers `name` applied to the last axis of `values`."""
        for index, activation in enumerate(self.description["activations"][name]):
            weight = self.weights[f"{name}.{index}.weight"]
            values = values @ weight.T + self.weights[f"{name}.{index}.bias"]
            values = ACTIVATIONS[activation](values)
        return values


def load(folder: str | os.PathLike[str]) -> Model:
    """The model in a folder that `motorspace export --numpy` wrote.

    Raises:
        OSError: A file is missing.
        ValueError: A file is damaged, or of another version of the format.
    """
    with open(os.path.join(folder, "model.json"), encoding="utf-8") as handle:
        description = json.load(handle)
    if description.get("format_version") != FORMAT_VERSION:
        raise ValueError(f"{folder}: model.json is not of format {FORMAT_VERSION}")
    with np.load(os.path.join(folder, "weights.npz"), allow_pickle=False) as stored:
        return Model(description, {name: stored[name] for name in stored.files})


FORMAT_VERSION = 1


def sigmoid(values: np.ndarray) -> np.ndarray:
    """1 / (1 + exp(-x)), without overflow."""
    return 0.5 * np.tanh(0.5 * values) + 0.5


def relu(values: np.ndarray) -> np.ndarray:
    """max(x, 0)."""
    return np.maximum(values, 0.0)


def identity(values: np.ndarray) -> np.ndarray:
    """x."""
    return values


ACTIVATIONS: dict[str, Callable[[np.ndarray], np.ndarray]] = {
    "identity": identity,
    "relu": relu,
    "sigmoid": sigmoid,
    "sin": np.sin,
}


def _lstm(model: Model, motors: np.ndarray, steps: np.ndarray) -> np.ndarray:
    from_input, from_hidden = model.weights["weight_ih"].T, model.weights["weight_hh"].T
    hidden = np.zeros((len(motors), len(from_hidden)), np.float32)
    memory, last = hidden, hidden
    for step in range(motors.shape[1]):
        gates = motors[:, step] @ from_input + hidden @ from_hidden + model.weights["bias"]
        write, keep, content, read = np.split(gates, 4, axis=1)
        memory = sigmoid(keep) * memory + sigmoid(write) * np.tanh(content)
        hidden = sigmoid(read) * np.tanh(memory)
        last = np.where((steps == step + 1)[:, None], hidden, last)
    return model.layers("to_code", last)


def _gru(model: Model, motors: np.ndarray, steps: np.ndarray) -> np.ndarray:
    from_input, from_hidden = model.weights["weight_ih"].T, model.weights["weight_hh"].T
    hidden = np.zeros((len(motors), len(from_hidden)), np.float32)
    last = hidden
    for step in range(motors.shape[1]):
        gates = motors[:, step] @ from_input + model.weights["bias"]
        reset, update, content = np.split(gates, 3, axis=1)
        hidden_reset, hidden_update, hidden_content = np.split(hidden @ from_hidden, 3, axis=1)
        reset, update = sigmoid(reset + hidden_reset), sigmoid(update + hidden_update)
        content = np.tanh(content + reset * (hidden_content + model.weights["bias_n"]))
        hidden = content + update * (hidden - content)
        last = np.where((steps == step + 1)[:, None], hidden, last)
    return model.layers("to_code", last)


def _linear(model: Model, motors: np.ndarray, steps: np.ndarray) -> np.ndarray:
    real, imaginary = np.split(model.layers("to_state", motors), 2, axis=2)
    age, executed = _age(motors, steps)
    decay = np.exp(-np.exp(model.weights["log_decay"]) * np.maximum(age, 0.0))
    angle = model.weights["phase"] * age
    cos, sin = executed * decay * np.cos(angle), executed * decay * np.sin(angle)
    state = [cos * real - sin * imaginary, sin * real + cos * imaginary]
    return model.layers("to_code", np.concatenate(state, axis=2).sum(axis=1))


def _attention(model: Model, motors: np.ndarray, steps: np.ndarray) -> np.ndarray:
    age, executed = _age(motors, steps)
    scaled = age / np.float32(model.description["age_scale"])
    tokens = model.layers("to_token", np.concatenate([motors, scaled], axis=2))
    query, key, value = (_heads(model, name, tokens) for name in ("query", "key", "value"))
    logits = query @ key.swapaxes(2, 3) / np.float32(math.sqrt(key.shape[3]))
    seen = executed[:, None, None, :, 0] > 0
    logits = np.where(seen, logits, np.finfo(np.float32).min)
    weight = np.exp(logits - logits.max(axis=3, keepdims=True))
    mixed = weight / weight.sum(axis=3, keepdims=True) @ value
    mixed = mixed.swapaxes(1, 2).reshape(*tokens.shape[:2], -1)
    attended = tokens + model.layers("output", mixed)
    last = attended[np.arange(len(motors)), steps - 1]
    pooled = np.concatenate([last, (executed * attended).sum(axis=1)], axis=1)
    return model.layers("to_code", pooled)


def _heads(model: Model, name: str, tokens: np.ndarray) -> np.ndarray:
    """[N, T, H] -> [N, heads, T, H / heads]."""
    projected = model.layers(name, tokens)
    split = projected.reshape(*tokens.shape[:2], model.description["num_heads"], -1)
    return split.swapaxes(1, 2)


def _matrix_product(model: Model, motors: np.ndarray, steps: np.ndarray) -> np.ndarray:
    size = model.description["matrix_size"]
    matrices = model.layers("transition", motors).reshape(*motors.shape[:2], size, size)
    last = model.layers("readout", motors[np.arange(len(motors)), steps - 1])
    product = _product(matrices, steps) @ last.reshape(-1, size, size)
    return product[:, :-1].reshape(len(motors), -1)


def _exponential(model: Model, motors: np.ndarray, steps: np.ndarray) -> np.ndarray:
    part = np.tensordot(motors, model.weights["generators"], axes=1)
    part = part / np.float32(2 ** model.description["halvings"])
    unit: np.ndarray = np.eye(part.shape[-1], dtype=np.float32)
    matrices = unit
    for term in range(model.description["terms"], 0, -1):
        matrices = unit + part @ matrices / np.float32(term)
    for _ in range(model.description["halvings"]):
        matrices = matrices @ matrices
    return _product(matrices, steps)[:, :-1].reshape(len(motors), -1)


def _product(matrices: np.ndarray, steps: np.ndarray) -> np.ndarray:
    """The product over time of the matrices that are executed, [N, T, n, n] -> [N, n, n]."""
    product = np.broadcast_to(np.eye(matrices.shape[-1], dtype=np.float32), matrices[:, 0].shape)
    for step in range(matrices.shape[1]):
        executed = (step < steps)[:, None, None]
        product = np.where(executed, product @ matrices[:, step], product)
    return product


def _sum(model: Model, motors: np.ndarray, steps: np.ndarray) -> np.ndarray:
    _, executed = _age(motors, steps)
    return model.layers("mlp", np.where(executed > 0, motors, 0.0).sum(axis=1))


def _mlp(model: Model, motors: np.ndarray, steps: np.ndarray) -> np.ndarray:
    _, executed = _age(motors, steps)
    return model.layers("mlp", np.where(executed > 0, motors, 0.0).reshape(len(motors), -1))


def _none(model: Model, motors: np.ndarray, steps: np.ndarray) -> np.ndarray:
    del steps
    return np.zeros((len(motors), model.description["code_size"]), np.float32)


def _identity(model: Model, motors: np.ndarray, steps: np.ndarray) -> np.ndarray:
    del model, steps
    return motors.reshape(len(motors), -1)


def _age(motors: np.ndarray, steps: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """How many commands follow each one, and 1 where it is part of the sequence, else 0."""
    age = steps[:, None] - 1 - np.arange(motors.shape[1])
    return age[..., None].astype(np.float32), (age >= 0)[..., None].astype(np.float32)


ENCODERS: dict[str, Callable[[Model, np.ndarray, np.ndarray], np.ndarray]] = {
    "lstm": _lstm,
    "gru": _gru,
    "linear": _linear,
    "attention": _attention,
    "matrix_product": _matrix_product,
    "exponential": _exponential,
    "sum": _sum,
    "mlp": _mlp,
    "none": _none,
    "identity": _identity,
}
