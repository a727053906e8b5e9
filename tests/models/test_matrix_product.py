"""The encoder whose commands are matrices: it composes, whatever its weights."""

import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np
import pytest

from motorspace._errors import UserError
from motorspace.models.config import ModelConfig
from motorspace.models.encoders.matrix_product import MatrixProductEncoder
from motorspace.models.model import Scaling, build_model


def encoder(code_size=20):
    return MatrixProductEncoder(2, 16, code_size, key=jax.random.key(0))


def speaking(made):
    """The encoder with a readout that has something to say, as after training."""
    width = made.readout.layers[-1].weight.shape
    weights = jax.random.normal(jax.random.key(3), width) / 10
    return eqx.tree_at(lambda e: e.readout.layers[-1].weight, made, weights)


def test_the_readout_begins_as_the_identity():
    motor = jnp.array([0.3, -1.2])
    for made, differs in ((encoder(), False), (speaking(encoder()), True)):
        matrix = made._matrix(made.transition, motor)[:-1].reshape(-1)
        assert (not jnp.allclose(made(motor[None], jnp.array(1)), matrix)) == differs


def test_rows_beyond_the_sequence_do_not_matter():
    motors = jax.random.normal(jax.random.key(1), (6, 2))
    short = encoder()(motors[:4], jnp.array(4))
    filled = encoder()(motors, jnp.array(4))
    np.testing.assert_allclose(short, filled, rtol=1e-5)
    assert short.shape == (20,)


def test_what_goes_before_enters_by_its_product_alone():
    made = speaking(encoder())
    first, second, after = jax.random.normal(jax.random.key(2), (3, 2, 2))

    def matrix(motors):
        """The product of the commands, without what the last one does to the sensors alone."""
        code = made(motors, jnp.array(len(motors)))
        last = made._matrix(made.readout, motors[-1])
        full = jnp.eye(5).at[:-1].set(code.reshape(4, 5))
        return full @ jnp.linalg.inv(last)

    both = matrix(jnp.concatenate([first, second, after]))
    parts = matrix(first) @ matrix(second) @ matrix(after)
    np.testing.assert_allclose(both, parts, atol=1e-4)


def test_codes_of_another_size_are_refused():
    with pytest.raises(UserError, match=r"a code of 50 units is no matrix.*n \(n - 1\)"):
        encoder(50)


def test_the_whole_model_keeps_the_initial_weights_of_the_encoder():
    config = ModelConfig(encoder="matrix_product", code_size=6, hidden_size=64)
    model = build_model(config, Scaling((10.0,) * 9, (1.0, 1.0)), horizon=6, key=jax.random.key(0))
    made = model.encoder
    assert isinstance(made, MatrixProductEncoder)
    motors = jax.random.uniform(jax.random.key(1), (100, 2), minval=-2.5, maxval=2.5)
    commands, last = jax.vmap(made.matrices)(motors)
    np.testing.assert_allclose(last, jnp.broadcast_to(jnp.eye(3), last.shape), atol=1e-6)
    assert 0.3 < float(jnp.abs(commands - jnp.eye(3)[None]).max()) < 5
