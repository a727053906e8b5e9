"""The graphs of encoders and predictor, in operators that every ONNX runtime has.

Imports the optional package onnx: import it only where a missing extra is reported.
"""

import math
from collections.abc import Callable
from typing import Any, NamedTuple

import numpy as np
from onnx import GraphProto, ModelProto, NodeProto, TensorProto, checker
from onnx import helper as make
from onnx.numpy_helper import from_array

from motorspace.export.network import Layers, Network

OPSET, IR = 17, 8
"""Versions of 2022, so that older runtimes read the files."""

OPERATORS = {"identity": "Identity", "relu": "Relu", "sigmoid": "Sigmoid", "sin": "Sin"}


class Graph:
    """A graph in the making. Values are known by their names."""

    def __init__(self) -> None:
        self.nodes: list[NodeProto] = []
        self.constants: list[TensorProto] = []

    def op(self, kind: str, *inputs: object, **attributes: Any) -> str:
        """The result of one more operator; inputs that are no names become constants."""
        names = [value if isinstance(value, str) else self.constant(value) for value in inputs]
        result = f"value_{len(self.nodes)}"
        self.nodes.append(make.make_node(kind, names, [result], **attributes))
        return result

    def constant(self, value: object) -> str:
        """The name of an array, in float32, int64 or bool."""
        array = np.asarray(value)
        array = array.astype(np.float32) if array.dtype.kind == "f" else array
        name = f"constant_{len(self.constants)}"
        self.constants.append(from_array(array, name))
        return name

    def layers(self, layers: Layers, value: str) -> str:
        """Dense layers on the last axis of `value`."""
        for weight, bias, activation in layers:
            product = self.op("MatMul", value, np.ascontiguousarray(weight.T))
            value = self.op(OPERATORS[activation], self.op("Add", product, bias))
        return value

    def total(self, mask: str, value: str) -> str:
        """The sum [N, H] of `value` [N, T, H] over the commands where `mask` [N, T, 1] holds."""
        kept = self.op("Where", mask, value, 0.0)
        return self.op("ReduceSum", kept, [1], keepdims=0)

    def size(self, value: str, axis: int) -> str:
        """The size of an axis, [1]."""
        return self.op("Shape", value, start=axis, end=axis + 1)


class Commands(NamedTuple):
    """The inputs of an encoder as values of the graph."""

    motors: str
    """Scaled motor sequences [N, T, M]."""
    age: str
    """How many commands follow each one [N, T, 1]; below 0 beyond the end."""
    executed: str
    """Whether a command is part of the sequence [N, T, 1]."""
    last: str
    """Whether it is the last one [N, T, 1]."""


def encoder_model(network: Network, about: dict[str, str]) -> ModelProto:
    """The model (motors [N, T, M], num_steps [N]) -> codes [N, C]."""
    graph, size = Graph(), len(network.motor_scale)
    scaled = graph.op("Div", "motors", network.motor_scale)
    codes = ENCODERS[network.encoder.kind](graph, network, _commands(graph, scaled))
    inputs = [
        make.make_tensor_value_info(
            "motors", TensorProto.FLOAT, ["N", network.horizon or "T", size]
        ),
        make.make_tensor_value_info("num_steps", TensorProto.INT32, ["N"]),
    ]
    return _model(graph, inputs, (codes, "codes", network.code_size), about)


def predictor_model(network: Network, about: dict[str, str]) -> ModelProto:
    """The model (sensors [N, K], codes [N, C]) -> later_sensors [N, K]."""
    graph, scale = Graph(), network.sensor_scale
    seen = graph.op("Concat", "codes", graph.op("Div", "sensors", scale), axis=1)
    later = graph.op("Mul", graph.layers(network.predictor, seen), scale)
    inputs = [
        make.make_tensor_value_info(name, TensorProto.FLOAT, ["N", size])
        for name, size in (("sensors", len(scale)), ("codes", network.code_size))
    ]
    return _model(graph, inputs, (later, "later_sensors", len(scale)), about)


def _model(
    graph: Graph, inputs: list, output: tuple[str, str, int], about: dict[str, str]
) -> ModelProto:
    value, name, size = output
    graph.nodes.append(make.make_node("Identity", [value], [name]))
    outputs = [make.make_tensor_value_info(name, TensorProto.FLOAT, ["N", size])]
    whole = make.make_graph(graph.nodes, "motorspace", inputs, outputs, graph.constants)
    opset = make.make_opsetid("", OPSET)
    model = make.make_model(whole, opset_imports=[opset], ir_version=IR, producer_name="motorspace")
    make.set_model_props(model, about)
    checker.check_model(model, full_check=True)
    return model


def _commands(graph: Graph, motors: str) -> Commands:
    longest = graph.op("Squeeze", graph.size("motors", 1))
    places = graph.op("Range", 0, longest, 1)
    steps = graph.op("Unsqueeze", graph.op("Cast", "num_steps", to=TensorProto.INT64), [1])
    age = graph.op("Unsqueeze", graph.op("Sub", graph.op("Sub", steps, 1), places), [2])
    return Commands(
        motors,
        graph.op("Cast", age, to=TensorProto.FLOAT),
        graph.op("GreaterOrEqual", age, 0),
        graph.op("Equal", age, 0),
    )


def _recurrent(graph: Graph, network: Network, commands: Commands) -> str:
    cell = _lstm if network.encoder.kind == "lstm" else _gru
    by_step = graph.op("Transpose", commands.motors, perm=[1, 0, 2])
    states = graph.op("Squeeze", cell(graph, network.encoder.arrays, by_step), [1])
    hidden = graph.op("Transpose", states, perm=[1, 0, 2])
    return graph.layers(network.encoder.layers["to_code"], graph.total(commands.last, hidden))


def _lstm(graph: Graph, arrays: dict[str, np.ndarray], motors: str) -> str:
    """h_1 to h_T, [T, 1, N, H]. Gates here: write, keep, content, read; in ONNX the second last."""
    order = [0, 3, 1, 2]
    weights = [_gates(arrays[name], 4, order) for name in ("weight_ih", "weight_hh", "bias")]
    weights[2] = np.concatenate([weights[2], np.zeros_like(weights[2])], axis=1)
    return graph.op("LSTM", motors, *weights, hidden_size=weights[1].shape[2])


def _gru(graph: Graph, arrays: dict[str, np.ndarray], motors: str) -> str:
    """h_1 to h_T, [T, 1, N, H]. Gates here: reset, update, content; in ONNX update first."""
    order = [1, 0, 2]
    weights = [_gates(arrays[name], 3, order) for name in ("weight_ih", "weight_hh", "bias")]
    hidden = weights[1].shape[2]
    recurrent = np.concatenate([np.zeros(2 * hidden, np.float32), arrays["bias_n"]])
    weights[2] = np.concatenate([weights[2], recurrent[None]], axis=1)
    return graph.op("GRU", motors, *weights, hidden_size=hidden, linear_before_reset=1)


def _gates(weights: np.ndarray, num: int, order: list[int]) -> np.ndarray:
    """The gates' rows in another order, with an axis before them for the one direction."""
    parts = np.split(weights, num)
    return np.concatenate([parts[index] for index in order])[None]


def _linear(graph: Graph, network: Network, commands: Commands) -> str:
    (state,) = network.encoder.layers["to_state"]
    halves = zip(np.split(state.weight, 2), np.split(state.bias, 2), strict=True)
    real, imaginary = (
        graph.layers((state._replace(weight=weight, bias=bias),), commands.motors)
        for weight, bias in halves
    )
    arrays = network.encoder.arrays
    followed = graph.op("Max", commands.age, 0.0)
    decay = graph.op("Exp", graph.op("Mul", followed, -np.exp(arrays["log_decay"])))
    angle = graph.op("Mul", followed, arrays["phase"])
    cos, sin = (graph.op("Mul", decay, graph.op(kind, angle)) for kind in ("Cos", "Sin"))
    parts = (
        graph.op("Sub", graph.op("Mul", cos, real), graph.op("Mul", sin, imaginary)),
        graph.op("Add", graph.op("Mul", sin, real), graph.op("Mul", cos, imaginary)),
    )
    total = graph.total(commands.executed, graph.op("Concat", *parts, axis=2))
    return graph.layers(network.encoder.layers["to_code"], total)


def _attention(graph: Graph, network: Network, commands: Commands) -> str:
    layers, options = network.encoder.layers, network.encoder.options
    age = graph.op("Div", commands.age, float(options["age_scale"]))
    tokens = graph.layers(layers["to_token"], graph.op("Concat", commands.motors, age, axis=2))
    size = len(layers["query"][0].bias) // options["num_heads"]

    def heads(name: str) -> str:
        """[N, T, heads, H / heads]."""
        shape = [0, 0, options["num_heads"], size]
        return graph.op("Reshape", graph.layers(layers[name], tokens), shape)

    query, value = (
        graph.op("Transpose", heads(name), perm=[0, 2, 1, 3]) for name in ("query", "value")
    )
    key = graph.op("Transpose", heads("key"), perm=[0, 2, 3, 1])
    logits = graph.op("Div", graph.op("MatMul", query, key), math.sqrt(size))
    seen = graph.op("Unsqueeze", graph.op("Transpose", commands.executed, perm=[0, 2, 1]), [1])
    logits = graph.op("Where", seen, logits, float(np.finfo(np.float32).min))
    mixed = graph.op("MatMul", graph.op("Softmax", logits, axis=3), value)
    joined = graph.op("Reshape", graph.op("Transpose", mixed, perm=[0, 2, 1, 3]), [0, 0, -1])
    attended = graph.op("Add", tokens, graph.layers(layers["output"], joined))
    pooled = [graph.total(mask, attended) for mask in (commands.last, commands.executed)]
    return graph.layers(layers["to_code"], graph.op("Concat", *pooled, axis=1))


def _matrix_product(graph: Graph, network: Network, commands: Commands) -> str:
    layers, size = network.encoder.layers, network.encoder.options["matrix_size"]
    flat = graph.layers(layers["transition"], commands.motors)
    product = _product(graph, graph.op("Reshape", flat, [0, 0, size, size]), commands, size)
    last = graph.layers(layers["readout"], graph.total(commands.last, commands.motors))
    whole = graph.op("MatMul", product, graph.op("Reshape", last, [0, size, size]))
    return graph.op("Reshape", graph.op("Slice", whole, [0], [size - 1], [1]), [0, -1])


def _exponential(graph: Graph, network: Network, commands: Commands) -> str:
    options, generators = network.encoder.options, network.encoder.arrays["generators"]
    size, halvings = options["matrix_size"], options["halvings"]
    flat = generators.reshape(len(generators), -1) / 2**halvings
    part = graph.op("MatMul", commands.motors, flat)
    part = graph.op("Reshape", part, [0, 0, size, size])
    matrices = graph.op("Add", graph.op("Mul", part, 1 / options["terms"]), np.eye(size))
    for term in range(options["terms"] - 1, 0, -1):
        further = graph.op("Mul", graph.op("MatMul", part, matrices), 1 / term)
        matrices = graph.op("Add", further, np.eye(size))
    for _ in range(halvings):
        matrices = graph.op("MatMul", matrices, matrices)
    whole = _product(graph, matrices, commands, size)
    return graph.op("Reshape", graph.op("Slice", whole, [0], [size - 1], [1]), [0, -1])


def _product(graph: Graph, matrices: str, commands: Commands, size: int) -> str:
    """The product over time of the matrices that are executed, [N, T, n, n] -> [N, n, n]."""
    executed = graph.op("Unsqueeze", commands.executed, [3])
    matrices = graph.op("Where", executed, matrices, np.eye(size))
    num = graph.size(commands.motors, 0)
    unit = graph.op("Expand", np.eye(size), graph.op("Concat", num, [size, size], axis=0))
    by_step = graph.op("Transpose", matrices, perm=[1, 0, 2, 3])
    return graph.op("Scan", unit, by_step, body=_multiply(size), num_scan_inputs=1)


def _multiply(size: int) -> GraphProto:
    """One step of the product over time: product <- product A."""
    before, matrix, after = (
        make.make_tensor_value_info(name, TensorProto.FLOAT, ["N", size, size])
        for name in ("before", "matrix", "after")
    )
    step = make.make_node("MatMul", ["before", "matrix"], ["after"])
    return make.make_graph([step], "step", [before, matrix], [after])


def _sum(graph: Graph, network: Network, commands: Commands) -> str:
    total = graph.total(commands.executed, commands.motors)
    return graph.layers(network.encoder.layers["mlp"], total)


def _mlp(graph: Graph, network: Network, commands: Commands) -> str:
    executed = graph.op("Where", commands.executed, commands.motors, 0.0)
    return graph.layers(network.encoder.layers["mlp"], _flat(graph, executed, network))


def _none(graph: Graph, network: Network, commands: Commands) -> str:
    num = graph.size(commands.motors, 0)
    return graph.op("Expand", 0.0, graph.op("Concat", num, [network.code_size], axis=0))


def _identity(graph: Graph, network: Network, commands: Commands) -> str:
    return _flat(graph, commands.motors, network)


def _flat(graph: Graph, motors: str, network: Network) -> str:
    assert network.horizon is not None, "only encoders of a fixed horizon see sequences laid flat"
    return graph.op("Reshape", motors, [0, network.horizon * len(network.motor_scale)])


ENCODERS: dict[str, Callable[[Graph, Network, Commands], str]] = {
    "lstm": _recurrent,
    "gru": _recurrent,
    "linear": _linear,
    "attention": _attention,
    "matrix_product": _matrix_product,
    "exponential": _exponential,
    "sum": _sum,
    "mlp": _mlp,
    "none": _none,
    "identity": _identity,
}
