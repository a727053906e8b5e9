"""What comes with the package acts at once."""

import jax
import numpy as np
import pytest
from PIL import Image

from motorspace._errors import UserError
from motorspace.control.trials import displacement_goals, displacement_trials
from motorspace.navigation.measuring import evaluate_policy
from motorspace.navigation.pretrained import (
    _home,
    load_pretrained,
    pretrained_names,
    store_policy,
)
from motorspace.navigation.watch import policy_film


@pytest.mark.parametrize("name", pretrained_names())
def test_a_pretrained_controller_reaches_goals(name):
    found = load_pretrained(name)
    agent = found.run.config.data.scenario().agent
    goals = displacement_goals(agent, 200, found.controller.horizon, key=jax.random.key(1))
    trials = displacement_trials(found.controller, agent, goals, "hybrid", key=jax.random.key(2))
    assert trials.success() > 0.95
    assert "## Limits" in found.card and name in found.card


def test_there_are_some_and_all_are_small():
    assert {"forward-0.4pi", "holonomic-0.4pi"} <= set(pretrained_names())
    for name in pretrained_names():
        assert sum(path.stat().st_size for path in (_home() / name).iterdir()) < 1_000_000


def test_the_nearest_name_is_named():
    with pytest.raises(UserError, match=r"no pretrained network 'forward-04pi'.*'forward-0.4pi'"):
        load_pretrained("forward-04pi")
    with pytest.raises(UserError, match=r"choose one of forward-0\.4pi"):
        load_pretrained(str(np.nan))


@pytest.mark.slow
@pytest.mark.parametrize("name", pretrained_names())
def test_a_pretrained_policy_finds_home_in_unseen_rooms(name):
    trained = load_pretrained(name).policy
    assert trained.config.task == "home" and "code" in trained.config.observe
    found = evaluate_policy(trained, num=256)
    assert found["unseen.success"] > 0.95 > 0.5 > found["chance.success"]


def test_a_policy_comes_back_as_it_was_stored(tmp_path):
    found = load_pretrained("forward-0.4pi")
    store_policy(found.policy, tmp_path)
    for name in ("policy.json", "policy.safetensors"):
        assert (tmp_path / name).read_bytes() == (_home() / "forward-0.4pi" / name).read_bytes()
    assert found.policy.codes.trained is found.run.model


@pytest.mark.slow
def test_its_episodes_are_a_film(tmp_path):
    film = policy_film(load_pretrained("forward-0.4pi").policy, num=1, seed=4)
    frames = list(film.new_saved_frame_seq())
    episode, moment = frames[-1]
    assert episode.reached and moment == len(episode.poses.x) - 1
    away = np.hypot(episode.poses.x[-1] - episode.goal[0], episode.poses.y[-1] - episode.goal[1])
    assert away < episode.radius
    film.save(tmp_path / "home.gif", writer="pillow")
    with Image.open(tmp_path / "home.gif") as picture:
        assert picture.size == (600, 640) and picture.n_frames > 10
