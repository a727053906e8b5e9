"""Initial weights that training gets off the ground from."""

from typing import TypeVar

import equinox as eqx
import jax
import jax.numpy as jnp
from jaxtyping import Array, Float

from motorspace._types import Key
from motorspace.models.encoders.base import AbstractMotorEncoder

Tree = TypeVar("Tree")


def reinitialised(model: Tree, *, normal_inputs: bool, key: Key) -> Tree:
    """The model with variance-preserving weights and zero biases.

    Linear layers follow He et al. (2015), an LSTM's input weights Glorot and Bengio (2010); its
    recurrent matrix is orthogonal per gate and its forget gate starts open (bias 1). With
    `normal_inputs` its input weights are standard normal instead: a gate then bends about once
    per radian, as it must to fold turns that lead to the same orientation.
    """
    is_layer = lambda node: isinstance(node, eqx.nn.Linear | eqx.nn.LSTMCell)  # noqa: E731
    keeps = lambda node: isinstance(node, AbstractMotorEncoder) and node.brings_weights  # noqa: E731
    is_leaf = lambda node: is_layer(node) or keeps(node)  # noqa: E731
    leaves, structure = jax.tree.flatten(model, is_leaf=is_leaf)
    keys = jax.random.split(key, len(leaves))
    fresh = [
        _scaled_layer(leaf, normal_inputs=normal_inputs, key=k) if is_layer(leaf) else leaf
        for leaf, k in zip(leaves, keys, strict=True)
    ]
    return jax.tree.unflatten(structure, fresh)


def _scaled_layer(
    layer: eqx.nn.Linear | eqx.nn.LSTMCell, *, normal_inputs: bool, key: Key
) -> eqx.nn.Linear | eqx.nn.LSTMCell:
    if isinstance(layer, eqx.nn.Linear):
        out_size, in_size = layer.weight.shape
        weight = jax.nn.initializers.he_normal(1, 0)(key, (out_size, in_size))
        layer = eqx.tree_at(lambda m: m.weight, layer, weight)
        if layer.bias is None:
            return layer
        return eqx.tree_at(lambda m: m.bias, layer, jnp.zeros((out_size,)))
    input_key, hidden_key = jax.random.split(key)
    hidden_size, in_size = layer.hidden_size, layer.input_size
    if normal_inputs:
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
