"""Motor sequences by themselves."""

import jax
import jax.numpy as jnp
import numpy as np
import pytest

from motorspace import ForwardAgent, HolonomicAgent, LatticeAgent, Pose
from motorspace.trajectories.commands import PADDED_LENGTH, nominal, padded, random_commands
from motorspace.worlds.simulation import nominal_displacement


@pytest.mark.parametrize("agent", [ForwardAgent(), HolonomicAgent(), LatticeAgent()])
def test_random_commands_are_those_of_the_space(agent, getkey):
    keys = jax.random.split(getkey(), (4, 3))
    found = random_commands(agent, keys)
    assert found.shape == (4, 3, agent.commands.size)
    np.testing.assert_array_equal(found[2, 1], agent.commands.sample(key=keys[2, 1]))


@pytest.mark.parametrize("length", [3, PADDED_LENGTH + 2])
def test_the_nominal_displacement_of_each_sequence(length, getkey):
    agent = HolonomicAgent()
    motors = np.asarray(random_commands(agent, jax.random.split(getkey(), (5, length))))
    here = Pose(*jnp.zeros((4,)))
    alone = nominal_displacement(agent, here, jnp.asarray(motors[3]), jnp.asarray(length))
    np.testing.assert_allclose(nominal(agent, motors)[3], alone, atol=1e-5)


def test_padding_adds_zeros_and_takes_nothing_away():
    motors = np.ones((2, 3, 4))
    filled = padded(motors)
    assert filled.shape == (2, PADDED_LENGTH, 4) and filled.dtype == np.float32
    np.testing.assert_array_equal(filled[:, :3], motors)
    assert not filled[:, 3:].any()
