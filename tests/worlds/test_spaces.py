"""Command and sensor spaces: bounds, random values, actions."""

import jax
import jax.numpy as jnp
import numpy as np
import pytest

from motorspace import UserError
from motorspace.worlds.spaces import ContinuousCommands, DiscreteCommands, SensorSpace

COMMANDS = ContinuousCommands((-2.0, 0.0, 1.0), (2.0, 3.0, 5.0), ("turn", "ahead", "speed"))


def test_samples_fill_the_bounds_whatever_they_are():
    keys = jax.random.split(jax.random.key(0), 4000)
    found = np.asarray(jax.vmap(lambda key: COMMANDS.sample(key=key))(keys))
    np.testing.assert_allclose(found.min(0), COMMANDS.low, atol=0.02)
    np.testing.assert_allclose(found.max(0), COMMANDS.high, atol=0.02)
    assert COMMANDS.scale == (2.0, 3.0, 5.0)


def test_actions_fill_the_bounds_and_are_clipped():
    actions = jnp.array([[-1.0, 0.0, 1.0, 9.0]] * 3)
    expected = [[-2, 0, 2, 2], [0, 1.5, 3, 3], [1, 3, 5, 5]]
    np.testing.assert_allclose(COMMANDS.from_unit(actions), expected)
    np.testing.assert_allclose(COMMANDS.from_unit(actions[:, 1]), [0, 1.5, 3])


def test_commands_are_clipped():
    np.testing.assert_allclose(COMMANDS.clip(jnp.array([-9.0, 2.0, 9.0])), [-2, 2, 5])
    nearly = jnp.array([0.2, 0.9, 0.1])
    np.testing.assert_array_equal(DiscreteCommands(3).clip(nearly), [0, 1, 0])


def test_shares_of_numpy_stay_numpy():
    found = COMMANDS.spread(np.array([0.5, 0.5, 0.5]))
    assert isinstance(found, np.ndarray)
    np.testing.assert_array_equal(found, [0.0, 1.5, 3.0])


def test_discrete_commands_are_one_hot():
    np.testing.assert_array_equal(
        DiscreteCommands(3).from_index(np.array([2, 0])), np.eye(3)[:, [2, 0]]
    )
    assert DiscreteCommands(3).names == ("0", "1", "2")


@pytest.mark.parametrize(
    ("make", "message"),
    [
        (lambda: ContinuousCommands((0.0,), (1.0, 2.0), ("a",)), "1 low, 2 high, 1 names"),
        (lambda: ContinuousCommands((1.0,), (0.0,), ("a",)), "command 'a' cannot go from 1.0"),
        (lambda: ContinuousCommands((0.0,), (np.inf,), ("a",)), "cannot go from 0.0 to inf"),
        (lambda: ContinuousCommands((0.0,), (1.0,), ("a",), turning=(1,)), "no command channel 1"),
        (lambda: DiscreteCommands(0), "number of commands must be at least 1, got 0"),
        (lambda: DiscreteCommands(2, ("a",)), "2 commands have 1 names"),
        (lambda: SensorSpace((1.0,), (1.0,), ("a",)), "sensor 'a' cannot go from 1.0 to 1.0"),
        (lambda: SensorSpace((0.0,), (1.0,), ("a",), (2, 2)), "do not fill the shape"),
    ],
)
def test_impossible_spaces_are_refused(make, message):
    with pytest.raises(UserError, match=message):
        make()


def test_readings_have_a_shape_and_a_scale():
    space = SensorSpace((-3.0, 0.0), (1.0, 2.0), ("a", "b"))
    assert space.shape == (2,) and space.scale == (3.0, 2.0)
    assert SensorSpace((0.0,) * 6, (1.0,) * 6, ("p",) * 6, (1, 2, 3)).shape == (1, 2, 3)
