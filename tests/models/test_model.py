"""The whole network: scaling, initial weights, and which parts are there."""

from dataclasses import replace

import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np
import pytest

from motorspace.models.config import ModelConfig
from motorspace.models.model import Extras, Scaling, build_model

KEY = jax.random.key(0)
SCALING = Scaling((10.0, 5.0), (2.0, 1.0))
CONFIG = ModelConfig(hidden_size=16, code_size=4, width_size=32, depth=2)


def test_commands_and_sensors_are_divided_by_their_scale():
    scaled = build_model(CONFIG, SCALING, horizon=3, key=KEY)
    plain = build_model(CONFIG, Scaling((1.0, 1.0), (1.0, 1.0)), horizon=3, key=KEY)
    motors, steps = jnp.array([[2.0, 1.0]] * 3), jnp.array(3)
    code = scaled.encode(motors, steps)
    np.testing.assert_allclose(code, plain.encode(jnp.ones((3, 2)), steps), rtol=1e-5)
    expected = plain.predict(jnp.array([0.5, 1.0]), code) * np.array([10.0, 5.0])
    np.testing.assert_allclose(scaled.predict(jnp.array([5.0, 5.0]), code), expected, rtol=1e-5)


def test_the_inverse_model_is_there_only_when_it_has_a_weight():
    assert build_model(CONFIG, SCALING, horizon=3, key=KEY).inverse is None
    extras = Extras(inverse=True)
    inverse = build_model(CONFIG, SCALING, horizon=3, extras=extras, key=KEY).inverse
    code = inverse(jnp.ones(2), jnp.zeros(2))
    assert code.shape == (4,) and (code > 0).all() and (code < 1).all()


def test_the_paper_sizes_are_the_defaults():
    model = build_model(ModelConfig(), Scaling((1.0,) * 9, (1.0,) * 2), horizon=6, key=KEY)
    assert model.encoder.cell.weight_hh.shape == (400, 100)
    assert model.encoder.to_code.weight.shape == (50, 100)
    shapes = [layer.weight.shape for layer in model.predictor.mlp.layers]
    assert shapes == [(200, 59), (200, 200), (200, 200), (9, 200)]


@pytest.mark.parametrize("initial_weights", ["normal_inputs", "scaled", "uniform"])
def test_same_key_same_weights(initial_weights):
    config = replace(CONFIG, initial_weights=initial_weights)
    first, again, other = (
        build_model(config, SCALING, horizon=3, key=jax.random.key(seed)) for seed in (1, 1, 2)
    )
    assert eqx.tree_equal(first, again)
    assert not eqx.tree_equal(first, other)


def test_scaled_weights_keep_the_variance_and_open_the_forget_gate():
    model = build_model(ModelConfig(), Scaling((1.0,) * 9, (1.0,) * 2), horizon=6, key=KEY)
    layer = model.predictor.mlp.layers[1]
    np.testing.assert_allclose(np.std(layer.weight), np.sqrt(2 / 200), rtol=0.05)
    assert (layer.bias == 0).all()
    np.testing.assert_array_equal(model.encoder.cell.bias[100:200], 1.0)
    np.testing.assert_allclose(np.std(model.encoder.cell.weight_ih), 1.0, rtol=0.1)
    narrow = build_model(ModelConfig(initial_weights="scaled"), model.scaling, horizon=6, key=KEY)
    np.testing.assert_allclose(np.std(narrow.encoder.cell.weight_ih), np.sqrt(2 / 102), rtol=0.1)
    np.testing.assert_array_equal(narrow.encoder.cell.weight_hh, model.encoder.cell.weight_hh)
    gate = np.asarray(model.encoder.cell.weight_hh[:100])
    np.testing.assert_allclose(gate @ gate.T, np.eye(100), atol=1e-5)
