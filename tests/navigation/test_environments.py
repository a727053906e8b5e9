"""Tasks behind Gymnasium's interfaces: its own checker, one and many agents, bad input."""

import json
import math
import warnings

import gymnasium
import numpy as np
import pytest
from gymnasium.utils.env_checker import check_env

from motorspace import ForwardAgent, HolonomicAgent, RangeFan, RunConfig, Simulated, UserError
from motorspace.environments import NAVIGATION, register
from motorspace.navigation.environments import NavigationEnv, NavigationVectorEnv
from motorspace.training import folder
from tests.sending import sent

register()


@pytest.mark.parametrize("name", NAVIGATION)
def test_gymnasium_has_no_complaint(name):
    env = gymnasium.make(name, render_mode="rgb_array", num_layouts=2, level=1, max_steps=5)
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        check_env(env.unwrapped)


@pytest.fixture(scope="module")
def env():
    return NavigationEnv("displacement_goal", num_layouts=3, max_steps=6, max_rotation=0.5)


@pytest.fixture(scope="module")
def envs():
    return gymnasium.make_vec(
        "motorspace/Home-v0", num_envs=3, vectorization_mode="vector_entry_point", num_layouts=2,
        max_episode_steps=4, level=1, render_mode="rgb_array",
    )  # fmt: skip


def test_same_seed_same_episode_and_other_layouts_in_others(env):
    first, info = env.reset(seed=5)
    again, _ = env.reset(seed=5)
    assert np.array_equal(first, again)
    shown = {env.reset()[1]["goal"].tobytes() for _ in range(10)}
    assert len(shown) > 5
    assert info["acting"] and not info["blocked"]


def test_the_goal_is_given_in_the_frame_of_the_start(env):
    observation, info = env.reset(seed=1)
    ahead, left = observation[-2:]
    x, _, heading, _ = info["pose"]
    goal = x + ahead * np.cos(heading) - left * np.sin(heading)
    np.testing.assert_allclose(goal, info["goal"][0], atol=1e-3)


def test_an_episode_is_truncated_when_time_is_up(env):
    env.reset(seed=1)
    ends = [env.step(np.array([1.0, -1.0]))[2:4] for _ in range(6)]
    assert ends == [(False, False)] * 5 + [(False, True)], "it turns on the spot"


def test_a_goal_of_ones_own_is_reached(env):
    start = env.reset(seed=3)[1]["pose"][:3]
    observation, info = env.reset(seed=3, options={"goal": (2.0, 0.0)})
    np.testing.assert_allclose(observation[-2:], (2, 0), atol=1e-3)
    np.testing.assert_allclose(info["pose"][:3], start)
    _, reward, terminated, truncated, _ = (env.step([0.0, 1.0]), env.step([0.0, 1.0]))[1]
    assert terminated and not truncated and reward == 1.0


@pytest.mark.parametrize(
    ("options", "message"),
    [
        ({"goal": (1.0, 2.0, 3.0)}, r"goal must be 2 numbers \(longitudinal, lateral\), got 3"),
        ({"goal": (100.0, 0.0)}, "is outside the world; keep x from 0 to 40"),
        ({"goal": (math.nan, 0.0)}, "the goal must be finite"),
        ({"goal": "home"}, "the goal must be numbers, got 'home'"),
        ({"start": (5.0, 5.0, 0.0)}, "a start needs a goal"),
        ({"start": (5.0, 5.0), "goal": (1.0, 0.0)}, "the start must be 3 numbers"),
        ({"start": (0.001, 5.0, 0.0), "goal": (1.0, 0.0)}, "is in a wall"),
    ],
)
def test_goals_that_cannot_be(env, options, message):
    env.reset(seed=0)
    with pytest.raises(UserError, match=message):
        env.reset(seed=0, options=options)


def test_the_vector_environment_resets_on_the_step_after(envs):
    envs.reset(seed=0)
    acting, ended = np.zeros(3, bool), np.zeros(3, bool)
    for _ in range(40):
        observation, reward, terminated, truncated, info = envs.step(np.zeros((3, 2)))
        assert envs.observation_space.contains(observation)
        assert not (acting & ~ended & ~info["acting"]).any(), "who acts goes on acting"
        assert not info["acting"][ended].any(), "who has ended wanders in a new episode"
        assert not reward[ended].any()
        acting, ended = info["acting"], terminated | truncated
        assert acting[ended].all()
    assert len(envs.render()) == 3 and envs.render()[0].shape == (320, 320, 3)


@pytest.mark.parametrize("make", [lambda env, _: env, lambda _, envs: envs.unwrapped])
def test_environments_are_sent_in_the_middle_of_an_episode(make, env, envs):
    one = make(env, envs)
    one.reset(seed=0)
    action = np.zeros(one.action_space.shape)
    copy = sent(one)
    for mine, its in zip(one.step(action)[:4], copy.step(action)[:4], strict=True):
        np.testing.assert_allclose(mine, its, atol=1e-5)


def test_a_run_says_which_body_acts(tmp_path):
    agent, sensor = ForwardAgent(0.3), RangeFan(5)
    config = RunConfig(Simulated(agent, sensor, "empty"))
    described = folder.Description(config, (10.0,) * 5, (1.0, 1.0), 6)
    (tmp_path / "config.json").write_text(json.dumps(described.as_json()))
    env = NavigationEnv("explore", run=tmp_path, num_layouts=1)
    assert env.bank.scenario.agent == agent and env.bank.scenario.sensor == sensor
    with pytest.raises(UserError, match="an environment of the holonomic agent"):
        NavigationEnv("explore", "holonomic", run=tmp_path, num_layouts=1)


@pytest.mark.parametrize(
    ("make", "message"),
    [
        (lambda: NavigationEnv("sleep"), "task must be 'home'"),
        (lambda: NavigationEnv(level=7), "there is no level 7"),
        (lambda: NavigationEnv(legs=6), "there is no option legs"),
        (lambda: NavigationEnv(observe=("code",)), "codes are computed by a trained network"),
        (lambda: NavigationEnv(split="exam"), "there is no layout 'exam'"),
        (lambda: NavigationEnv("home", "lattice"), "moves from node to node|cannot sense"),
        (lambda: NavigationEnv(max_steps=0, num_layouts=1), "max_steps must be at least 1"),
        (lambda: NavigationVectorEnv(num_envs=0), "num_envs must be at least 1"),
        (lambda: NavigationEnv(render_mode="human"), "no render mode 'human'"),
    ],
)
def test_bad_options(make, message):
    with pytest.raises(UserError, match=message):
        make()


def test_a_body_that_slides_has_a_task_too():
    env = NavigationEnv("sensor_goal", HolonomicAgent(), num_layouts=1, level=1)
    observation, _ = env.reset(seed=0)
    assert env.action_space.shape == (4,) and env.observation_space.contains(observation)
