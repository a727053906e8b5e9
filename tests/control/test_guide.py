"""A guide makes of what a judge knows motor commands that lead there, around walls."""

from types import SimpleNamespace

import jax
import jax.numpy as jnp
import numpy as np
import pytest

from motorspace import se2
from motorspace._types import Pose
from motorspace.control.guide import BLOCKED, Course, Guide, features
from motorspace.control.journey import Journey, seek
from motorspace.control.planning import Effort
from motorspace.control.trials import moved
from motorspace.judge.judge import Judge
from motorspace.judge.places import Hypotheses
from motorspace.judge.roadmap import Roadmap
from motorspace.mapping.walls import map_walls
from motorspace.trajectories.commands import nominal
from motorspace.worlds.scenario import Scenario
from tests.control import exact

HERE, GOAL = np.full(9, 1.0), np.full(9, 2.0)
WAY = np.array([1.2, 0.9, 0.8])
"""Where the goal is, seen from here."""


class Body:
    """Whose odometry is exact."""

    def moved(self, motors):
        return nominal(exact.AGENT, np.moveaxis(motors, 0, 1)).T

    def at_rest(self, eyes, motor):
        return eyes


def square(side):
    """Points on the walls of a square room around the origin."""
    along = np.linspace(-side, side, 4_000)
    across = np.full(4_000, side)
    pairs = [(along, across), (along, -across), (across, along), (-across, along)]
    return np.concatenate([np.stack(pair) for pair in pairs], axis=1)


def judge(places, side=6.0):
    """A judge that knows these places by their readings, in a square room."""
    made = Judge.__new__(Judge)
    made.where = lambda sensors: places[float(sensors[0])]
    made.walls = map_walls(square(side), reach=10.0)
    made.places = SimpleNamespace(tracked=lambda sensors, expected: expected)
    made.calibration = SimpleNamespace(codes=None, body=Body())
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


def test_a_sequence_that_meets_a_wall_has_no_room(places):
    narrow = Guide(exact.controller(), judge(places, side=0.5))
    motors = np.array([[[0.0, 0.4]] * 3, [[0.0, 0.4], [3.1, 0.7], [0.0, 0.1]]])
    assert (narrow.room(np.zeros(3), motors) > 0).tolist() == [False, True]


def test_of_several_answers_one_without_a_wall_is_carried_out(guide):
    answer = guide.answer(Course(np.zeros(3), WAY), key=jax.random.key(1))
    assert answer.miss < BLOCKED
    behind = Course(np.array([5.5, 0.0, 0.0]), np.array([1.5, 0.0, 0.0]))
    assert guide.answer(behind, key=jax.random.key(1)).miss > BLOCKED


@pytest.fixture(scope="module")
def far(places):
    """A room whose far end is several sequences away."""
    return {**places, 2.0: hypotheses((5.0, 5.0, 0.5), weight=[1.0])}


def lattice(side=6.0):
    x, y = np.meshgrid(*[np.arange(-side + 0.5, side, 0.5)] * 2)
    return np.stack([x.ravel(), y.ravel(), 0 * x.ravel()])


def test_a_journey_leads_to_a_far_place_and_ends_there(far):
    known = judge(far)
    guide, roadmap = Guide(exact.controller(), known), Roadmap(known.walls, lattice())
    journey = Journey(guide, roadmap, HERE, GOAL)
    here = np.zeros((3, 1))
    for round_key in jax.random.split(jax.random.key(0), 12):
        motors = journey.plan(key=round_key)
        if motors is None:
            break
        here = se2.compose(here, Body().moved(motors[:, None]))
        off = features(here[:, 0]) - features(np.array([5.0, 5.0, 0.5]))
        journey.sensed(motors, GOAL if np.linalg.norm(off) < 0.3 else HERE)
    assert journey.arrived
    assert np.allclose(journey.belief.likeliest, here[:, 0])


def test_where_the_goal_is_not_sensed_the_journey_goes_elsewhere(far):
    known = judge({**far, 2.0: hypotheses((0.0, 0.0, 0.0), (4.0, 0.0, 0.0), weight=[0.7, 0.3])})
    guide, roadmap = Guide(exact.controller(), known), Roadmap(known.walls, lattice())
    journey = Journey(guide, roadmap, HERE, GOAL)
    for round_key in jax.random.split(jax.random.key(0), 2):
        motors = journey.plan(key=round_key)
    assert Body().moved(motors[:, None])[0] > 0.5


def test_an_agent_that_senses_the_goal_stays(far):
    known = judge(far)
    guide, roadmap = Guide(exact.controller(), known), Roadmap(known.walls, lattice())
    assert Journey(guide, roadmap, GOAL, GOAL).plan(key=jax.random.key(0)) is None


class Marked(Scenario):
    """An empty world in which one place looks unlike all others."""

    def sense(self, pose):
        there = jnp.hypot(pose.x - 25.0, pose.y - 25.0) < 0.35
        return jnp.where(there, GOAL[:, None], HERE[:, None]).reshape(9)


def test_an_agent_seeks_where_the_goal_is_sensed(far):
    known, scenario = judge(far), Marked("empty", exact.AGENT)
    guide, roadmap = Guide(exact.controller(), known), Roadmap(known.walls, lattice())
    start = Pose(*jnp.array([20.0, 20.0, 0.0, 0.0]))
    way = seek(guide, roadmap, scenario, start, GOAL, rounds=12, key=jax.random.key(0))
    assert float(jnp.hypot(way.poses.x[-1] - 25.0, way.poses.y[-1] - 25.0)) < 0.35
    assert way.motors.shape == (len(way.poses.x) - 1, 2) and len(way.motors) < 36
    assert way.carried_out.all() and not way.blocked.any()
    there = jax.tree.map(lambda field: field[-1], way.poses)
    stays = seek(guide, roadmap, scenario, there, GOAL, rounds=12, key=jax.random.key(0))
    assert stays.motors.shape == (0, 2) and stays.poses.x.shape == (1,)
