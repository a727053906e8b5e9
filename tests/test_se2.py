"""Displacements obey the laws of SE(2), in NumPy and in JAX."""

import jax
import jax.numpy as jnp
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from motorspace import Pose
from motorspace.se2 import advance, chain, compose, cos_sin, inverse, relative, wrap

coordinate = st.floats(-20, 20, width=32)
angle = st.floats(-3, 3, width=32)
displacement = st.tuples(coordinate, coordinate, angle).map(lambda d: jnp.array(d, jnp.float32))


COMPOSE, INVERSE, RELATIVE = jax.jit(compose), jax.jit(inverse), jax.jit(relative)


def matrix(d):
    """The homogeneous matrix of a displacement, float64."""
    x, y, turn = (float(v) for v in d)
    cos, sin = np.cos(turn), np.sin(turn)
    return np.array([[cos, -sin, x], [sin, cos, y], [0, 0, 1]])


@settings(max_examples=60, deadline=None)
@given(displacement, displacement)
def test_compose_is_the_matrix_product(first, then):
    np.testing.assert_allclose(
        matrix(COMPOSE(first, then)), matrix(first) @ matrix(then), atol=1e-4
    )


@settings(max_examples=60, deadline=None)
@given(displacement)
def test_inverse_is_the_matrix_inverse(d):
    np.testing.assert_allclose(matrix(INVERSE(d)), np.linalg.inv(matrix(d)), atol=1e-4)


@settings(max_examples=60, deadline=None)
@given(displacement, displacement, displacement)
def test_relative_displacements_chain(a, b, c):
    chained = COMPOSE(RELATIVE(a, b), RELATIVE(b, c))
    np.testing.assert_allclose(matrix(chained), matrix(RELATIVE(a, c)), atol=2e-4)


def test_relative_is_measured_in_the_frame_of_the_sensors():
    start = Pose(*jnp.array([1.0, 2.0, np.pi / 4, np.pi / 4]))
    end = Pose(*jnp.array([0.0, 5.0, np.pi, 0.0]))
    # Gazing along +y: three ahead, one to the left, a quarter turn to the left.
    np.testing.assert_allclose(relative(start.frame, end.frame), [3.0, 1.0, np.pi / 2], atol=1e-6)


def test_advance_moves_ahead_and_to_the_left():
    start = Pose(*jnp.array([1.0, 1.0, np.pi / 2, 0.3]))
    end = advance(start, jnp.float32(2.0), jnp.float32(0.5))
    np.testing.assert_allclose(
        [end.x, end.y, end.heading, end.head], [0.5, 3, np.pi / 2, 0.3], rtol=1e-6
    )


@pytest.mark.parametrize(("angle", "wrapped"), [(7.0, 7 - 2 * np.pi), (-4.0, 2 * np.pi - 4)])
def test_wrap(angle, wrapped):
    np.testing.assert_allclose(wrap(jnp.float32(angle)), wrapped, atol=1e-6)


def test_wrap_keeps_pi_and_turns_minus_pi_over():
    assert wrap(jnp.float32(jnp.pi)) == jnp.float32(jnp.pi)
    assert wrap(-jnp.float32(jnp.pi)) == jnp.float32(jnp.pi)


def test_cosine_and_sine_are_those_of_float64():
    angles = np.concatenate([np.linspace(-20, 20, 100_001), np.pi / 4 * np.arange(-16, 17)])
    angles = angles.astype(np.float32)
    cos, sin = cos_sin(jnp.asarray(angles))
    np.testing.assert_allclose(cos, np.cos(angles.astype(float)), atol=2e-7)
    np.testing.assert_allclose(sin, np.sin(angles.astype(float)), atol=2e-7)


def test_numpy_arrays_stay_numpy_in_their_own_precision():
    d = np.random.default_rng(0).uniform(-3, 3, (3, 50))
    for found in (compose(d, d), inverse(d), relative(d, 2 * d), chain(d.T), wrap(d)):
        assert isinstance(found, np.ndarray) and found.dtype == np.float64
    np.testing.assert_allclose(compose(d, inverse(d)), 0, atol=1e-12)


def test_jax_arrays_stay_jax_under_jit():
    d = np.random.default_rng(0).uniform(-3, 3, (20, 6, 3))
    found = jax.jit(chain)(jnp.asarray(d, jnp.float32))
    assert isinstance(found, jax.Array)
    np.testing.assert_allclose(found, chain(d), atol=1e-4)


def test_a_chain_is_its_displacements_composed():
    d = np.random.default_rng(1).uniform(-2, 2, (6, 3))
    expected = np.zeros(3)
    for step in d:
        expected = compose(expected, step)
    np.testing.assert_allclose(chain(d), expected, atol=1e-12)


def test_numpy_angles_are_wrapped_to_the_side_of_pi():
    turns = np.array([np.pi, -np.pi, 3 * np.pi, 0.5, -7.0])
    np.testing.assert_allclose(wrap(turns), [np.pi, np.pi, np.pi, 0.5, 2 * np.pi - 7])
    # The other side, [-pi, pi), is the mirror image, to the bit.
    other = (turns + np.pi) % (2 * np.pi) - np.pi
    np.testing.assert_array_equal(-wrap(-turns), other)
