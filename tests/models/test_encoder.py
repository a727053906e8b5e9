"""The encoders, the paper's one against a plain implementation of its equations."""

import jax
import jax.numpy as jnp
import numpy as np
import pytest

from motorspace.models.config import ModelConfig
from motorspace.models.encoders.recurrent import GRUEncoder, LSTMEncoder
from motorspace.models.model import Scaling, build_model

SCALING = Scaling((10.0,) * 9, (1.0, 1.0))
MOTORS = jax.random.uniform(jax.random.key(1), (5, 2), minval=-1.0)


def sigmoid(x):
    return 1 / (1 + np.exp(-x))


def plain_lstm(encoder, motors):
    """Input, forget, cell and output gate, one command after the other, float64."""
    w_in, w_hidden, bias, w_code, b_code = (
        np.asarray(a, np.float64)
        for a in (
            encoder.cell.weight_ih,
            encoder.cell.weight_hh,
            encoder.cell.bias,
            encoder.to_code.weight,
            encoder.to_code.bias,
        )
    )
    h = c = np.zeros(w_hidden.shape[1])
    for motor in np.asarray(motors, np.float64):
        i, f, g, o = np.split(w_in @ motor + w_hidden @ h + bias, 4)
        c = sigmoid(f) * c + sigmoid(i) * np.tanh(g)
        h = sigmoid(o) * np.tanh(c)
    return sigmoid(w_code @ h + b_code)


@pytest.mark.parametrize("num_steps", [1, 3, 5])
def test_the_lstm_encoder_is_the_plain_recurrence(num_steps):
    encoder = LSTMEncoder(2, 16, 7, key=jax.random.key(0))
    found = encoder(MOTORS, jnp.array(num_steps))
    np.testing.assert_allclose(found, plain_lstm(encoder, MOTORS[:num_steps]), atol=1e-6)


@pytest.mark.parametrize("recurrent", [LSTMEncoder, GRUEncoder])
def test_rows_beyond_the_steps_do_not_matter(recurrent):
    encoder = recurrent(2, 16, 7, key=jax.random.key(0))
    other = MOTORS.at[3:].set(9.0)
    steps = jnp.array(3)
    np.testing.assert_array_equal(encoder(MOTORS, steps), encoder(other, steps))
    assert (encoder(MOTORS, jnp.array(5)) != encoder(other, jnp.array(5))).any()


@pytest.mark.parametrize("recurrent", [LSTMEncoder, GRUEncoder])
def test_a_recurrent_encoder_knows_the_order(recurrent):
    encoder = recurrent(2, 16, 7, key=jax.random.key(0))
    steps = jnp.array(5)
    assert np.abs(encoder(MOTORS, steps) - encoder(MOTORS[::-1], steps)).max() > 1e-4


@pytest.mark.parametrize(
    "kind", ["lstm", "gru", "linear", "attention", "matrix_product", "sum", "mlp"]
)
def test_no_kind_sees_rows_beyond_the_steps_of_a_longer_array(kind):
    config = ModelConfig(encoder=kind, hidden_size=16, code_size=6)
    model = build_model(config, SCALING, horizon=5, key=jax.random.key(2))
    steps = jnp.array(3)
    other = MOTORS.at[3:].set(9.0)
    np.testing.assert_allclose(model.encode(MOTORS, steps), model.encode(other, steps), atol=1e-6)
    if kind != "mlp":
        short = model.encode(MOTORS[:3], steps)
        np.testing.assert_allclose(model.encode(MOTORS, steps), short, atol=1e-6)


@pytest.mark.parametrize(
    ("kind", "size"),
    [
        ("lstm", 8),
        ("gru", 8),
        ("linear", 8),
        ("attention", 8),
        ("matrix_product", 6),
        ("sum", 8),
        ("mlp", 8),
        ("none", 8),
        ("identity", 10),
    ],
)
def test_every_kind_gives_a_code_that_the_predictor_takes(kind, size):
    code_size = size if kind != "identity" else 8
    config = ModelConfig(encoder=kind, hidden_size=16, code_size=code_size, width_size=16, depth=1)
    model = build_model(config, SCALING, horizon=5, key=jax.random.key(2))
    code = model.encode(MOTORS, jnp.array(5))
    assert code.shape == (size,)
    assert model.predict(jnp.ones(9), code).shape == (9,)
    if kind in ("lstm", "gru", "linear", "attention", "sum", "mlp"):
        assert (code > 0).all() and (code < 1).all()
    if kind == "sum":
        backwards = model.encode(MOTORS[::-1], jnp.array(5))
        np.testing.assert_allclose(code, backwards, atol=1e-6)
