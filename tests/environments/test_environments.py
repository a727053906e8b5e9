"""The Gymnasium environments against Gymnasium's own checker and the simulator."""

import warnings

import gymnasium
import numpy as np
import pytest
from gymnasium.utils.env_checker import check_env

from motorspace import Retina, layout
from motorspace.environments import IDS, register
from motorspace.environments.single import ExplorationEnv
from motorspace.environments.vector import ExplorationVectorEnv
from motorspace.navigation.environments import NavigationEnv

register()
IDS = tuple(IDS)


@pytest.mark.parametrize("name", IDS)
def test_gymnasium_has_no_complaint(name):
    env = gymnasium.make(name, render_mode="rgb_array")
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        check_env(env.unwrapped)


@pytest.mark.parametrize("name", IDS)
def test_stable_baselines_has_no_complaint(name):
    checker = pytest.importorskip("stable_baselines3.common.env_checker")
    checker.check_env(gymnasium.make(name).unwrapped)


@pytest.mark.parametrize("name", IDS)
def test_same_seed_same_episode(name):
    first, second = gymnasium.make(name), gymnasium.make(name)
    first.action_space.seed(3)
    assert np.array_equal(first.reset(seed=5)[0], second.reset(seed=5)[0])
    for _ in range(50):
        action = first.action_space.sample()
        (one, *_, info), (two, *_) = first.step(action), second.step(action)
        assert np.array_equal(one, two)
        assert info["pose"].shape == (4,)
    assert not np.array_equal(first.reset(seed=6)[0], second.reset(seed=5)[0])


def test_an_episode_is_truncated_and_never_terminated():
    env = gymnasium.make("motorspace/Forward-v0", max_steps=3)
    env.reset(seed=0)
    ends = [env.step(env.action_space.sample())[2:4] for _ in range(3)]
    assert ends == [(False, False), (False, False), (False, True)]


@pytest.mark.parametrize("name", IDS)
def test_the_vector_environment_resets_on_the_step_after(name):
    envs = gymnasium.make_vec(
        name, num_envs=3, max_steps=4, vectorization_mode="vector_entry_point"
    )
    envs.action_space.seed(0)
    envs.reset(seed=0)
    before = None
    for step in range(1, 11):
        sensors, reward, terminated, truncated, info = envs.step(envs.action_space.sample())
        assert envs.observation_space.contains(sensors)
        assert not terminated.any() and not reward.any()
        assert truncated.tolist() == [step in (4, 9)] * 3
        if step == 5:
            assert not info["blocked"].any()
            assert not np.allclose(info["pose"], before)
        before = info["pose"]


def test_single_and_vector_environments_obey_the_same_rules():
    single = gymnasium.make("motorspace/Holonomic-v0").unwrapped
    several = gymnasium.make_vec(
        "motorspace/Holonomic-v0", num_envs=1, vectorization_mode="vector_entry_point"
    )
    single.reset(seed=0)
    several.reset(seed=0)
    several.unwrapped._results = single._result[None]
    single.action_space.seed(1)
    for _ in range(10):
        action = single.action_space.sample()
        one, *_ = single.step(action)
        many, *_ = several.step(action[None])
        np.testing.assert_allclose(one, many[0], atol=1e-5)


def test_a_thousand_agents_at_once():
    envs = gymnasium.make_vec(
        "motorspace/Forward-v0", num_envs=1000, vectorization_mode="vector_entry_point"
    )
    envs.reset(seed=0)
    for _ in range(5):
        sensors, *_ = envs.step(np.tile(np.array([0.3, 1.0], np.float32), (1000, 1)))
    assert sensors.shape == (1000, 9)
    assert sensors.min() > 0 and sensors.max() == 10.0


def test_pictures_are_fresh_and_show_something():
    env = gymnasium.make("motorspace/Forward-v0", render_mode="rgb_array")
    env.reset(seed=0)
    first = env.render()
    env.step(np.array([0.5, 1.0], np.float32))
    second = env.render()
    assert first.dtype == np.uint8 and len(np.unique(first.reshape(-1, 3), axis=0)) == 4
    assert not np.array_equal(first, second)


def test_agents_with_eyes_see_the_colours_of_their_world():
    """Alone and many at once; in a navigation task every agent is in a room of its own."""
    options = {"sensor": "retina", "layout": layout("paper", paint="texture:4"), "num_rays": 8}
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        check_env(ExplorationEnv(render_mode="rgb_array", **options), skip_render_check=True)
    env = ExplorationVectorEnv(num_envs=5, **options)
    seen, _ = env.reset(seed=0)
    assert seen.shape == (5, 8, 3) and len(np.unique(seen, axis=0)) == 5
    after = env.step(env.action_space.sample())[0]
    assert env.observation_space.contains(after) and np.abs(after - seen).max() > 0.1
    rooms = NavigationEnv("home", sensor=Retina(4, samples=1), num_layouts=2)
    observed, _ = rooms.reset(seed=0)
    assert rooms.observation_space.contains(observed)
