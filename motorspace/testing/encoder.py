"""What any motor encoder must satisfy."""

import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np

from motorspace.models.encoders.base import AbstractMotorEncoder, EncoderSize
from motorspace.testing.require import require

NUM = 8
SIZE = EncoderSize(motor_size=3, horizon=4, hidden_size=16, code_size=6)


def check_encoder(encoder: type[AbstractMotorEncoder], size: EncoderSize = SIZE) -> None:
    """Check an encoder: how it is created, what it encodes, that it can be trained.

    Args:
        encoder: The class to check.
        size: What it is made for.

    Raises:
        AssertionError: Naming what is wrong.

    Example:
        >>> from motorspace.models.encoders.recurrent import GRUEncoder
        >>> check_encoder(GRUEncoder)  # doctest: +SKIP
    """
    key, motors_key = jax.random.split(jax.random.key(0))
    made = encoder.create(size, key=key)
    same = jax.tree.map(
        lambda a, b: bool(jnp.array_equal(a, b)),
        *(eqx.filter(m, eqx.is_array) for m in (made, encoder.create(size, key=key))),
    )
    require(all(jax.tree.leaves(same)), "the same key must give the same initial weights")
    motors = jax.random.normal(motors_key, (NUM, size.horizon, size.motor_size))
    full = jnp.full(NUM, size.horizon)
    encode = eqx.filter_jit(eqx.filter_vmap(made))
    codes = encode(motors, full)
    require(codes.ndim == 2, f"a code must be one vector, got the shape {codes.shape[1:]}")
    require(bool(jnp.isfinite(codes).all()), "codes must be finite")
    np.testing.assert_allclose(
        made(motors[0], full[0]), codes[0], atol=1e-5, err_msg="one and many, or jit, differ"
    )
    _check_lengths(made, encode, motors)
    if encoder.learned:
        _check_gradient(made, motors)
    penalty = made.penalty(motors)
    require(
        penalty.shape == () and bool(penalty >= 0), "the penalty must be a scalar of at least 0"
    )


def _check_lengths(made: AbstractMotorEncoder, encode, motors) -> None:  # type: ignore[no-untyped-def]
    """Rows beyond `num_steps` are no part of the sequence: in a batch they are zero."""
    if not made.any_length:
        return
    short = jnp.full(NUM, motors.shape[1] - 1)
    padded = motors.at[:, -1].set(0.0)
    longer = jnp.pad(padded, ((0, 0), (0, 2), (0, 0)))
    np.testing.assert_allclose(
        encode(longer, short),
        encode(padded, short),
        atol=1e-5,
        err_msg="rows beyond `num_steps` change the code",
    )


def _check_gradient(made: AbstractMotorEncoder, motors) -> None:  # type: ignore[no-untyped-def]
    def spread(encoder: AbstractMotorEncoder) -> jax.Array:
        steps = jnp.full(NUM, motors.shape[1])
        return jnp.var(jax.vmap(encoder)(motors, steps), axis=0).sum()

    gradients = jax.tree.leaves(eqx.filter_grad(spread)(made))
    require(bool(gradients), "a learned encoder must have weights")
    finite = all(bool(jnp.isfinite(g).all()) for g in gradients)
    require(finite, "the gradient of the codes must be finite")
