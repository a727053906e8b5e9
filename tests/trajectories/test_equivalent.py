"""Sequences that are built to lead to the same displacement do."""

import math

import jax
import jax.numpy as jnp
import numpy as np
import pytest

from motorspace import ForwardAgent, HolonomicAgent, LatticeAgent, Pose, UserError
from motorspace.trajectories.equivalent import equivalent_sequences
from motorspace.worlds.simulation import nominal_displacement

ROTATIONS = [0.2, 0.6, 0.8, 1.2]


def displacements(agent, made):
    num, horizon, _ = made.motors.shape
    zero = jnp.zeros(num)
    motors = jnp.moveaxis(jnp.asarray(made.motors, jnp.float32), 0, -1)
    steps = jnp.full(num, horizon)
    longitudinal, lateral, turn = nominal_displacement(agent, Pose(*[zero] * 4), motors, steps)
    return np.stack([longitudinal, lateral, np.cos(turn), np.sin(turn)], axis=1)


@pytest.mark.parametrize("rotation", ROTATIONS)
@pytest.mark.parametrize("body", [ForwardAgent, HolonomicAgent])
def test_a_group_leads_to_one_displacement_with_commands_that_the_agent_can_be_given(
    body, rotation
):
    agent = body(rotation * math.pi)
    made = equivalent_sequences(agent, num_groups=20, horizon=6, key=jax.random.key(0))
    reached = displacements(agent, made).reshape(-1, 8, 4)
    np.testing.assert_allclose(reached, reached[:, :1].repeat(8, 1), atol=1e-5)
    assert (made.motors <= np.array(agent.commands.high) + 1e-9).all()
    assert (made.motors >= np.array(agent.commands.low) - 1e-9).all()


def test_groups_differ_from_each_other_and_members_within_one():
    agent = HolonomicAgent(0.8 * math.pi)
    made = equivalent_sequences(agent, num_groups=30, horizon=6, key=jax.random.key(1))
    assert made.names == (
        "split_rotation",
        "split_translation",
        "full_turns",
        "undone",
        "head",
    )
    assert len(made.motors) == len(made.groups) == 5 * 30 * 8
    flat = made.motors.reshape(-1, 8, 24)
    assert (flat.std(axis=1).max(axis=1) > 0.01).all()
    reached = displacements(agent, made)[::8]
    assert len(np.unique(np.round(reached, 3), axis=0)) == 150


def test_full_turns_are_counted():
    made = equivalent_sequences(
        ForwardAgent(0.8 * math.pi), num_groups=50, horizon=6, key=jax.random.key(2)
    )
    turned = made.kinds == made.names.index("full_turns")
    assert set(np.unique(made.full_turns[turned])) >= {-1, 0, 1}
    assert (made.full_turns[~turned] == 0).all()
    # Turns count as far as they differ within a group: what its members share is context.
    rotation = made.motors[turned, :, 0].sum(axis=1)
    base = rotation - 2 * math.pi * made.full_turns[turned]
    np.testing.assert_allclose(base.reshape(50, 8), base.reshape(50, 8)[:, :1].repeat(8, 1))


def test_small_rotations_allow_neither_full_turns_nor_turning_round():
    made = equivalent_sequences(
        ForwardAgent(0.2 * math.pi), num_groups=5, horizon=6, key=jax.random.key(3)
    )
    assert made.names == ("split_rotation", "split_translation")


class LateTurner(ForwardAgent):
    """Moves ahead, then turns, not as its commands say."""

    def move(self, pose, motor):
        (moved,) = super().move(pose, motor.at[0].set(0.0))
        return (self.turn(moved, motor),)


class Slider(ForwardAgent):
    """Turns while it slides: a rotation cannot be shared out, a translation can."""

    def move(self, pose, motor):
        (moved,) = super().move(pose, motor)
        return (Pose(moved.x + jnp.abs(motor[0]), moved.y, moved.heading, moved.head),)


def test_kinds_that_an_own_body_does_not_obey_are_left_out():
    made = equivalent_sequences(Slider(), num_groups=5, horizon=4, key=jax.random.key(0))
    assert made.names == ("split_translation",)
    with pytest.raises(UserError, match="LateTurner are known to lead to the same place"):
        equivalent_sequences(LateTurner(), num_groups=5, horizon=4, key=jax.random.key(0))


def test_the_lattice_agent_is_refused():
    with pytest.raises(UserError, match="LatticeAgent do not say which channels turn it"):
        equivalent_sequences(LatticeAgent(), num_groups=5, horizon=6, key=jax.random.key(0))
