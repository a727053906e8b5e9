"""A guide makes of what a judge knows motor commands that lead there, around walls."""

from types import SimpleNamespace

import jax
import jax.numpy as jnp
import numpy as np
import pytest

from motorspace.control.guide import Guide
from motorspace.control.planning import Effort
from motorspace.control.trials import moved
from motorspace.judge.judge import Judge
from motorspace.judge.places import Hypotheses
from motorspace.trajectories.commands import nominal
from tests.control import exact

HERE, GOAL = np.full(9, 1.0), np.full(9, 2.0)
WAY = np.array([1.2, 0.9, 0.8])
"""Where the goal is, seen from here."""


def read(codes):
    """The displacements that exact codes are, [3, N]."""
    cos, _, x, sin, _, y = np.asarray(codes, np.float64).T
    return np.stack([x, y, np.arctan2(sin, cos)])


def judge(places, clear=100.0):
    """A judge that knows these places by their readings, with as much room in every direction."""
    made = Judge.__new__(Judge)
    made.where = lambda sensors: places[float(sensors[0])]
    made.walls = SimpleNamespace(
        ranges=lambda eyes, angles: jnp.full((eyes.shape[1], len(angles)), clear)
    )
    odometry = SimpleNamespace(
        displacements=lambda done: nominal(exact.AGENT, np.moveaxis(done, 0, 1)).T
    )
    mounting = SimpleNamespace(seen=lambda displacements: displacements)
    body = SimpleNamespace(odometry=odometry, mounting=mounting)
    made.calibration = SimpleNamespace(codes=SimpleNamespace(read=read), body=body)
    return made


def hypotheses(*eyes, weight):
    return Hypotheses(np.array(eyes, float).T, np.array(weight))


@pytest.fixture(scope="module")
def places():
    """The agent is at the origin. The goal's look-alike is likelier, and out of reach."""
    return {
        1.0: hypotheses((0.0, 0.0, 0.0), weight=[1.0]),
        2.0: hypotheses((30.0, 5.0, 0.0), WAY, weight=[0.8, 0.2]),
    }


@pytest.fixture(scope="module")
def guide(places):
    return Guide(exact.controller(), judge(places))


def test_a_place_out_of_reach_is_not_where_the_agent_goes(guide):
    course = guide.course(HERE, GOAL)
    np.testing.assert_allclose(course.moved, WAY, atol=1e-9)
    np.testing.assert_allclose(course.here, 0.0)


def test_a_displacement_within_the_bank_has_its_code(guide):
    x, y, turn = WAY
    cos, sin = np.cos(turn), np.sin(turn)
    np.testing.assert_allclose(guide.code_of(WAY), [cos, -sin, x, sin, cos, y], atol=0.1)


def test_the_plan_leads_to_what_is_sensed_elsewhere(guide):
    effort = Effort(guesses=16, starts=8, refinements=8)
    motors = guide.plan(HERE, GOAL, effort=effort, key=jax.random.key(0))
    np.testing.assert_allclose(moved(exact.AGENT, jnp.asarray(motors)), WAY, atol=0.15)


def test_a_sequence_that_meets_a_wall_is_not_free(places):
    narrow = Guide(exact.controller(), judge(places, clear=0.5))
    motors = np.array([[[0.0, 0.4]] * 3, [[0.0, 0.4], [0.1, 0.9], [0.0, 0.1]]], np.float32)
    assert narrow.free(np.zeros(3), motors).tolist() == [True, False]
