"""Tasks in many worlds at once, against the simulator one world at a time."""

import math

import jax
import jax.numpy as jnp
import numpy as np
import pytest

from motorspace import Part, Pose, UserError
from motorspace.navigation.actors import Chance, Planner
from motorspace.navigation.arena import Arena, Rules
from motorspace.navigation.arenas import Size, arena_of, observer_of, setting_of
from motorspace.navigation.config import NavigationConfig, navigation_from_json
from motorspace.navigation.evaluation import Episodes, evaluate_actor, numbers
from motorspace.navigation.given import given_problem
from motorspace.navigation.levels import LEVELS, rooms
from motorspace.navigation.problems import posed
from motorspace.navigation.tasks import task_named
from motorspace.worlds.agents import ForwardAgent
from motorspace.worlds.layouts import Layout
from motorspace.worlds.scenario import Scenario
from motorspace.worlds.simulation import step

BODY = Part("forward", (("max_rotation", 0.4 * math.pi),))
OBSERVED = ("ranges", "bump", "command", "stack", "displacement")


def config(task, **options):
    return NavigationConfig(task=task, agent=BODY, num_layouts=2, **{"observe": OBSERVED} | options)


@pytest.fixture(scope="module")
def arenas():
    """An arena of each task: six agents in two layouts, two problems each."""
    names = ("home", "displacement_goal", "sensor_goal", "explore")
    return {
        name: arena_of(config(name), None, "train", Size(6, 2), key=jax.random.key(0))
        for name in names
    }


@pytest.fixture(scope="module")
def courses(arenas):
    """Twelve random commands in each arena."""
    return {name: course(arena) for name, arena in arenas.items()}


def course(arena, num=12):
    def forth(state, key):
        motor = jax.vmap(lambda key: arena.scenario.commands.sample(key=key), out_axes=-1)(
            jax.random.split(key, arena.num_agents)
        )
        after, outcome = arena.advance(state, motor)
        return after, (after, outcome, motor)

    first = arena.begin_at(jnp.zeros(arena.num_agents, jnp.int32))
    rest = jax.jit(lambda s, k: jax.lax.scan(forth, s, k))(
        first, jax.random.split(jax.random.key(1), num)
    )[1]
    return first, *rest


@pytest.mark.parametrize("task", ["displacement_goal", "sensor_goal", "explore"])
def test_every_agent_moves_as_it_would_alone_in_its_world(courses, arenas, task):
    first, states, outcomes, motors = courses[task]
    worlds = rooms(LEVELS[2], "train", 2)
    for number in (0, 3):
        x, y, heading, head = (leaf[number] for leaf in jax.tree.leaves(first.pose))
        pose = Pose(x, y, heading, head)
        for moment in range(12):
            pose, blocked = step(
                worlds[number % 2], ForwardAgent(0.4 * math.pi), pose, motors[moment, :, number]
            )
            assert blocked == outcomes.blocked[moment, number]
        np.testing.assert_allclose(pose.x, states.pose.x[-1, number], rtol=1e-5)
        alone = Scenario(worlds[number % 2], ForwardAgent(0.4 * math.pi)).sense(pose)
        seen = states.observation[-1, :9, number] * 10
        np.testing.assert_allclose(seen, alone, atol=1e-3)


@pytest.mark.parametrize("task", ["home", "displacement_goal", "sensor_goal"])
def test_goals_are_as_far_as_the_level_says_and_free(arenas, task):
    problems, level = arenas[task].problems, LEVELS[2]
    assert (problems.distance >= level.nearest).all()
    assert (problems.distance <= level.farthest).all()
    straight = np.hypot(problems.start.x - problems.goal.x, problems.start.y - problems.goal.y)
    if task == "home":
        assert not straight.any(), "home is where the episode begins"
    else:
        assert (straight <= problems.distance + 1e-4).all()
        bent = np.asarray(problems.around)
        np.testing.assert_allclose(problems.distance[~bent], straight[~bent], rtol=1e-5)


def test_one_who_must_find_home_wanders_first(courses, arenas):
    first, states, outcomes, _ = courses["home"]
    assert (first.problem.num_wander >= LEVELS[2].wander[0]).all()
    assert not outcomes.acted.any() and not outcomes.reward.any()
    assert not states.walked.any() and not states.observation[:, -1].any()


def test_what_is_given_and_the_true_displacement(courses):
    first, *_ = courses["displacement_goal"]
    hint = first.observation[-2:]
    true = first.observation[-6:-4] * 10
    np.testing.assert_allclose(hint, true, atol=1e-3)
    away = np.hypot(*np.asarray(hint))
    straight = np.hypot(first.pose.x - first.problem.goal.x, first.pose.y - first.problem.goal.y)
    np.testing.assert_allclose(away, straight, rtol=1e-3)
    _, states, *_ = courses["sensor_goal"]
    np.testing.assert_allclose(states.observation[-1, -9:], states.problem.wanted[-1], rtol=1e-6)


def test_the_stack_holds_what_was_seen_before(courses):
    _, states, *_ = courses["displacement_goal"]
    now, before = slice(0, 12), slice(12, 24)
    np.testing.assert_array_equal(states.observation[5, before], states.observation[4, now])


def test_cells_are_rewarded_once(courses):
    _, states, outcomes, _ = courses["explore"]
    entered = np.asarray(states.seen[-1].sum(axis=0))
    np.testing.assert_allclose(outcomes.reward.sum(axis=0), 0.1 * entered, rtol=1e-5)
    assert entered.min() >= 1 and not outcomes.terminated.any()


def test_an_unsensed_bump_is_not_observed():
    sensed, not_sensed = (
        arena_of(
            config("displacement_goal", observe=("ranges", "command"), sense_blocked=flag),
            None, "train", Size(6, 2), key=jax.random.key(0),
        )
        for flag in (True, False)
    )  # fmt: skip
    assert sensed.rules.sense_blocked and not not_sensed.rules.sense_blocked
    with pytest.raises(UserError, match="a bump that is not sensed cannot be observed"):
        config("home", sense_blocked=False)


def test_shaped_rewards_add_up_to_the_way_come_nearer(arenas):
    arena = arena_of(
        config("displacement_goal", reward="shaped"), None, "train", Size(6, 2),
        key=jax.random.key(0),
    )  # fmt: skip
    first, states, outcomes, _ = course(arena)
    assert not outcomes.terminated.any()
    sparse, gamma = 0.0, arena.rules.discount
    potential = np.concatenate([first.potential[None], states.potential])
    discounted = gamma ** np.arange(12)[:, None] * np.asarray(outcomes.reward)
    expected = sparse + gamma**12 * potential[-1] - potential[0]
    np.testing.assert_allclose(discounted.sum(axis=0), expected, atol=1e-5)
    np.testing.assert_allclose(potential[0], -0.1 * first.problem.distance, rtol=1e-6)


def test_one_who_knows_the_map_reaches_every_goal_and_chance_does_not(arenas):
    key = jax.random.key(3)
    best = evaluate_actor(arenas["displacement_goal"], Planner(), key=key)
    chance = evaluate_actor(arenas["displacement_goal"], Chance(), key=key)
    assert best["success"] == 1.0 and best["spl"] > 0.7
    assert chance["success"] < 0.6 and chance["spl"] < best["spl"]
    assert best["num"] == 12


def test_success_is_weighted_by_the_way():
    done = Episodes(
        jnp.array([[True, True, False]]), jnp.array([[3, 5, 9]]), jnp.array([[2, 1, 2]]),
        jnp.array([[4.0, 8.0, 1.0]]),
        jnp.array([[5.0, 5.0, 5.0]]), jnp.array([[False, True, False]]), jnp.zeros((1, 3), int),
    )  # fmt: skip
    found = numbers(done, radius=1.0)
    assert found["success"] == pytest.approx(2 / 3)
    assert found["spl"] == pytest.approx((1.0 + 0.5) / 3)
    assert found["success.around"] == 1.0 and found["steps"] == 4.0 and found["decisions"] == 1.5


def test_layouts_of_training_and_test_differ():
    train, test = (rooms(LEVELS[2], split, 3) for split in ("train", "test"))
    shown = {world.walls.tobytes() for world in (*train, *test)}
    assert len(shown) == 6


def test_a_configuration_comes_back_from_json():
    given = config("home", level=3, reward="shaped")
    assert navigation_from_json(given.as_json(), where="here") == given


@pytest.mark.parametrize(
    ("options", "message"),
    [
        ({"task": "sleep"}, "task must be 'home'"),
        ({"level": 9}, "there is no level 9; choose one of 1, 2, 3"),
        ({"observe": ("smell",)}, "nothing is called 'smell' that could be observed"),
        ({"observe": ()}, "nothing is observed"),
        ({"reward": "food"}, "reward must be 'sparse' or 'shaped'"),
        ({"num_layouts": 0}, "num_layouts must be at least 1"),
        ({"steps": 0}, "steps must be at least 1"),
    ],
)
def test_bad_options(options, message):
    with pytest.raises(UserError, match=message):
        NavigationConfig(**options)


def test_a_goal_behind_a_closed_wall_is_refused():
    closed = Layout("closed", (0.0, 0.0, 20.0, 20.0), (((10.0, 0.0), (10.0, 20.0)),)).world()
    given = config("displacement_goal")
    setting = setting_of(given, [closed], 1)
    observer = observer_of(given, setting, None, key=jax.random.key(0))
    here = Pose(*jnp.full((4, 1), 5.0))
    problem = posed(setting, here, here)
    arena = Arena(setting, task_named(given.task), observer, problem, Rules(10))
    with pytest.raises(UserError, match="no way leads from the start to the goal"):
        given_problem(arena, problem, start=(5.0, 5.0, 0.0), goal=(10.0, 0.0))
    found = given_problem(arena, problem, start=(5.0, 5.0, 0.0), goal=(3.0, 1.0))
    np.testing.assert_allclose(found.distance, np.hypot(3, 1), rtol=1e-5)
