"""Codes that are matrices: what chance has set in them, undone by a convention."""

import math

import jax
import numpy as np
import pytest

from motorspace import ForwardAgent, HolonomicAgent
from motorspace.analysis import distances
from motorspace.analysis.coordinates import displacement_coordinates
from motorspace.analysis.standard_form import standard_form
from motorspace.evaluation.subject import Subject, commands
from motorspace.trajectories.commands import nominal

NUM = 600


def motion(displacements):
    """Displacements as 3 x 3 matrices."""
    x, y, turn = displacements.T
    cos, sin, zero, one = np.cos(turn), np.sin(turn), np.zeros(len(turn)), np.ones(len(turn))
    rows = [[cos, -sin, x], [sin, cos, y], [zero, zero, one]]
    return np.moveaxis(np.array(rows), 2, 0)


def ranked(codes, displacements, motors):
    """Rank correlations of the distances of codes, motors and displacements."""
    points = displacement_coordinates(displacements).points
    kinds = codes, motors.reshape(len(motors), -1), points
    return distances.rank_correlations(*map(distances.centred_distances, kinds))


@pytest.fixture(scope="module", params=["forward", "holonomic"])
def sequences(request):
    """Random sequences, their displacements, and those of single commands."""
    rotation = 0.6 * math.pi
    agent = ForwardAgent(rotation) if request.param == "forward" else HolonomicAgent(rotation)
    motors = commands(Subject(None, agent, 6), (NUM, 6), key=jax.random.key(0))
    single = commands(Subject(None, agent, 1), (10_000, 1), key=jax.random.key(1))
    return motors, nominal(agent, motors), nominal(agent, single)


def test_what_chance_has_set_is_undone(sequences):
    motors, displacements, commands = sequences
    unit_and_point = np.array([[0.3, 0.1, 0.5], [-0.1, 0.3, -0.9], [0, 0, 1]])
    readout = np.array([[0.8, 0.5, 1.0], [-0.2, 0.3, 0.4], [0, 0, 1]])
    back = np.linalg.inv(unit_and_point)
    product = unit_and_point @ motion(displacements) @ back @ readout
    codes = product[:, :2].reshape(NUM, 6)
    transitions = unit_and_point @ motion(commands) @ back
    readouts = np.broadcast_to(readout, transitions.shape)
    standard = standard_form(codes, transitions, readouts)
    assert ranked(codes, displacements, motors)[0, 2] < 0.98
    assert ranked(standard, displacements, motors)[0, 2] > 0.9999


def test_codes_that_only_turn_keep_their_rotations():
    turns = np.random.default_rng(0).uniform(-np.pi, np.pi, (NUM, 1))
    matrices = motion(np.concatenate([np.zeros((NUM, 2)), turns], axis=1))
    codes = matrices[:, :2].reshape(NUM, 6)
    identity = np.broadcast_to(np.eye(3), (NUM, 3, 3))
    np.testing.assert_allclose(standard_form(codes, matrices, identity), codes, atol=1e-12)


def test_the_partial_correlation_is_of_what_is_left_however_little(sequences):
    motors, displacements, _ = sequences
    points = displacement_coordinates(displacements).points
    exact = ranked(points, displacements, motors)
    nearly = ranked(points * np.array([1, 1, 1.01, 1.01]), displacements, motors)
    assert nearly[0, 2] > 0.9999
    # No continuity: a hundredth more of orientation is far from none.
    assert abs(distances.partial(nearly)) > 0.003 > 1e-6 > abs(distances.partial(exact))
    assert abs(distances.semipartial(nearly)) < 1e-3
    explained = distances.partial(nearly) * (1 - nearly[0, 2] ** 2) ** 0.5
    assert distances.semipartial(nearly) == pytest.approx(explained)


def test_a_point_of_the_body_a_little_ahead_has_a_partial_correlation():
    agent = ForwardAgent(0.4 * math.pi)
    motors = commands(Subject(None, agent, 6), (NUM, 6), key=jax.random.key(0))
    exact = nominal(agent, motors)
    turns = exact[:, 2]
    ahead = displacement_coordinates(exact).points
    ahead[:, :2] += 0.01 * np.stack([np.cos(turns), np.sin(turns)], axis=1)
    found = ranked(ahead, exact, motors)
    assert found[0, 2] > 0.99999
    assert distances.partial(found) == pytest.approx(-0.15, abs=0.03)
    assert abs(distances.semipartial(found)) < 5e-4
