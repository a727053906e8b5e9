"""What the reference rows of a table are fitted on."""

import jax
import numpy as np
import pytest

from motorspace import ForwardAgent, LatticeAgent, LatticeWorld, NodeIndex, Scenario, UserError
from motorspace.trajectories.derived import (
    displacement_as_motors,
    scaled_rotations,
    shuffled,
    supervised,
)
from motorspace.trajectories.sampling import sample

DRAWN = sample(Scenario("empty"), num=50, horizon=3, key=jax.random.key(0))
MOVED = np.asarray(DRAWN.displacements.achieved)
FEATURES = np.stack([*MOVED[:, :2].T, np.cos(MOVED[:, 2]), np.sin(MOVED[:, 2])], axis=1)


def test_the_oracle_is_given_the_displacement_for_a_command():
    oracle = displacement_as_motors(DRAWN, 3.0)
    np.testing.assert_allclose(oracle.motors[:, 0], FEATURES / [3, 3, 1, 1], atol=1e-6)
    assert (oracle.num_steps == 1).all()
    np.testing.assert_array_equal(oracle.later_sensors, DRAWN.experience.later_sensors)


def test_rotations_are_scaled_before_the_displacement_is_computed():
    right = scaled_rotations(ForwardAgent(), DRAWN, angle=1.0)
    np.testing.assert_allclose(right.motors, displacement_as_motors(DRAWN, 3.0).motors, atol=1e-5)
    none = scaled_rotations(ForwardAgent(), DRAWN, angle=0.0).motors[:, 0]
    ahead = np.asarray(DRAWN.experience.motors)[..., 1].sum(axis=1) / 3
    np.testing.assert_allclose(
        none, np.stack([ahead, 0 * ahead, 1 + 0 * ahead, 0 * ahead], 1), atol=1e-6
    )


def test_an_agent_that_does_not_say_what_turns_it_is_refused():
    lattice = Scenario(LatticeWorld(), LatticeAgent(), NodeIndex())
    drawn = sample(lattice, num=4, horizon=2, key=jax.random.key(0))
    with pytest.raises(UserError, match="LatticeAgent do not say which channels turn it"):
        scaled_rotations(LatticeAgent(), drawn, angle=1.1)


def test_shuffling_parts_sequences_from_what_they_led_to():
    found = shuffled(DRAWN, key=jax.random.key(1))
    before, after = np.asarray(DRAWN.experience.later_sensors), np.asarray(found.later_sensors)
    assert not np.array_equal(before, after)
    np.testing.assert_array_equal(np.sort(before[:, 0]), np.sort(after[:, 0]))
    np.testing.assert_array_equal(found.motors, DRAWN.experience.motors)


def test_the_supervised_network_predicts_the_displacement_from_nothing_else():
    found = supervised(DRAWN)
    np.testing.assert_allclose(found.later_sensors, FEATURES, atol=1e-6)
    assert not found.sensors.any() and found.sensors.shape == (50, 4)
