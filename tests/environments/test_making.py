"""Environments from names, options, scenarios and runs; tasks; copies; bad actions."""

import json
import math
import subprocess
import sys

import gymnasium
import jax
import jax.numpy as jnp
import numpy as np
import pytest

from motorspace import (
    HolonomicAgent,
    LatticeAgent,
    NodeIndex,
    RangeFan,
    Scenario,
    UserError,
    register,
)
from motorspace.environments import register as register_environments
from motorspace.environments.single import ExplorationEnv
from motorspace.environments.tasks import AbstractTask
from motorspace.environments.vector import ExplorationVectorEnv
from motorspace.worlds.agents import ForwardAgent
from motorspace.worlds.sensors.base import AbstractSensor
from motorspace.worlds.spaces import SensorSpace
from tests.sending import sent

register_environments()
MANY = Scenario("rooms:1", HolonomicAgent(head_rule="turn"), RangeFan(30, sense_head=True))


def in_a_new_process(code):
    done = subprocess.run(
        [sys.executable, "-W", "ignore", "-c", code],
        capture_output=True,
        text=True,
        check=False,
        timeout=120,
    )
    assert done.returncode == 0, done.stderr
    return done.stdout


def test_a_learned_representation_has_its_environment():
    env = ExplorationEnv(scenario=MANY)
    assert env.observation_space.shape == (31,) and env.action_space.shape == (4,)
    assert env.observation_space.low[-1] == np.float32(-math.pi)
    env.action_space.seed(0)
    env.reset(seed=0)
    for _ in range(20):
        assert env.observation_space.contains(env.step(env.action_space.sample())[0])
    assert gymnasium.make("motorspace/Exploration-v0", scenario=MANY).unwrapped.episode.scenario


def test_a_run_names_its_environment(tmp_path):
    from motorspace import RunConfig, Simulated
    from motorspace.training import folder

    config = RunConfig(Simulated(MANY.agent, MANY.sensor, "rooms:1", horizon=2))
    described = folder.Description(config, MANY.space.scale, MANY.commands.scale, 2)
    (tmp_path / "config.json").write_text(json.dumps(described.as_json()))
    for run in (tmp_path, str(tmp_path)):
        found = ExplorationEnv(run=run).episode.scenario
        assert (found.agent, found.sensor) == (MANY.agent, MANY.sensor)
    with pytest.raises(UserError, match="there is no run here"):
        ExplorationEnv(run=tmp_path / "nowhere")


def test_every_option_of_agent_and_sensor():
    env = gymnasium.make(
        "motorspace/Holonomic-v0", layout="four_rooms", max_rotation=0.5, head_rule="turn",
        num_rays=5, max_range=4.0,
    ).unwrapped  # fmt: skip
    found = env.episode.scenario
    assert found.agent == HolonomicAgent(0.5, "turn")
    assert found.sensor == RangeFan(5, 4.0)
    lattice = ExplorationEnv("lattice", layout="lattice:3").episode.scenario
    assert (lattice.agent, lattice.sensor) == (LatticeAgent(), NodeIndex())
    assert lattice.world.width == 3


class Compass(AbstractSensor):
    """A sensor that lives outside the package, with a signed channel of a shape of its own."""

    gain: float = 1.0
    """What the reading is multiplied by."""

    def space(self, world):
        del world
        bound = (math.pi * self.gain,)
        return SensorSpace((-bound[0],), bound, ("heading",), (1, 1))

    def sense(self, world, pose):
        return self.gain * pose.heading[None]


class Snail(ForwardAgent):
    """An agent that lives outside the package."""


register("compass")(Compass)
register("snail")(Snail)


def test_classes_of_ones_own_have_environments():
    env = gymnasium.make(
        "motorspace/Exploration-v0", agent="snail", sensor="compass", gain=2.0, max_rotation=0.1
    )
    observation, info = env.reset(seed=1)
    assert observation.shape == (1, 1)
    np.testing.assert_allclose(observation[0, 0], 2 * info["pose"][2], rtol=1e-6)
    assert env.unwrapped.episode.scenario.agent == Snail(0.1)
    objects = ExplorationEnv(Snail(0.1), sensor=Compass(2.0))
    assert np.array_equal(objects.reset(seed=1)[0], observation)


class Reach(AbstractTask):
    """To move to the right."""

    def reward(self, transition):
        return transition.after.x - transition.before.x

    def terminated(self, transition):
        return transition.after.x > 20.0


def test_a_task_rewards_and_ends_an_episode():
    one = ExplorationEnv(task=Reach(), layout="empty")
    many = ExplorationVectorEnv(num_envs=8, task=Reach(), layout="empty")
    _, before = one.reset(seed=0)
    _, reward, terminated, _, after = one.step([0.1, 1.0])
    np.testing.assert_allclose(reward, after["pose"][0] - before["pose"][0], rtol=1e-5)
    assert terminated == (after["pose"][0] > 20)
    many.reset(seed=0)
    _, reward, terminated, truncated, info = many.step(np.zeros((8, 2)))
    assert terminated.tolist() == (info["pose"][:, 0] > 20).tolist()
    assert 0 < terminated.sum() < 8 and not truncated.any() and reward.any()
    _, reward, _, _, again = many.step(np.zeros((8, 2)))
    assert not reward[terminated].any(), "who has ended begins anew"
    moved = np.abs(again["pose"] - info["pose"]).max(axis=1)
    assert (moved[terminated] > 1.5).any()


@pytest.mark.parametrize(
    ("make", "message"),
    [
        (lambda: ExplorationEnv(render_mode="human"), "no render mode 'human'; use rgb_array"),
        (lambda: ExplorationEnv(max_steps=0), "max_steps must be at least 1, got 0"),
        (lambda: ExplorationVectorEnv(num_envs=0), "num_envs must be at least 1, got 0"),
        (lambda: ExplorationEnv(layout="nowhere"), "there is no layout 'nowhere'"),
        (lambda: ExplorationEnv("fly"), "there is no agent named 'fly'; choose one of"),
        (lambda: ExplorationEnv(max_rotation=-1.0), "max_rotation must be above 0"),
        (lambda: ExplorationEnv(max_rotation=math.inf), "max_rotation must be above 0"),
        (lambda: ExplorationEnv(num_legs=6), "no option num_legs; this agent and this sensor have"),
        (lambda: ExplorationEnv("lattice", max_rotation=0.3), "no option max_rotation"),
        (lambda: ExplorationEnv(scenario=MANY, num_rays=3), "scenario already says what num_rays"),
        (lambda: ExplorationEnv(run="x", layout="empty"), "run already says what layout is"),
        (lambda: ExplorationEnv(run="x", scenario=MANY), "a scenario and a run are two"),
        (
            lambda: ExplorationEnv("forward", scenario=MANY),
            "environment of the forward agent, .* HolonomicAgent; use motorspace/Exploration-v0",
        ),
        (
            lambda: gymnasium.make("motorspace/Forward-v0", max_steps=900).reset(),
            "Gymnasium ends an episode after 200 steps, before max_steps 900; give max_episode",
        ),
    ],
)
def test_bad_options(make, message):
    with pytest.raises(UserError, match=message):
        make()


NAN, INF = math.nan, math.inf


@pytest.mark.parametrize(
    ("kind", "action", "message"),
    [
        ("forward", [NAN, 0.0], "an action must be finite"),
        ("forward", [0.0, INF], "an action must be finite"),
        ("forward", [0.0], r"must have the shape \(2,\), got \(1,\).* rotation, move"),
        ("forward", [0.0, 0.0, 0.0], r"shape \(2,\), got \(3,\)"),
        ("forward", [[0.0, 0.0]], r"shape \(2,\), got \(1, 2\)"),
        ("forward", "left", "an action must be numbers, got 'left'"),
        ("forward", None, "an action must be finite|must be numbers|shape"),
        ("lattice", 6, "whole numbers from 0 to 5, got 6"),
        ("lattice", -1, "whole numbers from 0 to 5, got -1"),
        ("lattice", 1.7, "whole numbers from 0 to 5, got 1.7"),
        ("lattice", [1], r"shape \(\), got \(1,\)"),
        ("lattice", True, "whole numbers from 0 to 5, got True"),
    ],
)
def test_bad_actions_are_refused_and_change_nothing(kind, action, message):
    env = ENVS[kind]
    env.reset(seed=0)
    before = np.asarray(env._result)
    with pytest.raises(UserError, match=message):
        env.step(action)
    np.testing.assert_array_equal(env._result, before)


ENVS = {"forward": ExplorationEnv(), "lattice": ExplorationEnv("lattice")}


def test_bad_actions_of_many_agents():
    envs = ExplorationVectorEnv(num_envs=3)
    envs.reset(seed=0)
    for action, message in (
        (np.zeros((2, 2)), r"actions of 3 agents must have the shape \(3, 2\), got \(2, 2\)"),
        (np.full((3, 2), NAN), "actions of 3 agents must be finite"),
    ):
        with pytest.raises(UserError, match=message):
            envs.step(action)


def test_actions_beyond_the_box_are_clipped():
    env = ENVS["forward"]
    ends = []
    for action in ([0.2, 1.0], [0.2, 7.0]):
        env.reset(seed=4)
        ends.append(env.step(action)[4]["pose"])
    np.testing.assert_array_equal(*ends)


def test_steps_need_a_reset():
    for env, action in ((ExplorationEnv(), [0, 0]), (ExplorationVectorEnv(), [[0, 0]])):
        with pytest.raises(gymnasium.error.ResetNeeded):
            env.step(action)


@pytest.mark.parametrize("make", [ExplorationEnv, lambda: ExplorationVectorEnv(num_envs=2)])
def test_environments_are_sent_in_the_middle_of_an_episode(make):
    env = make()
    env.reset(seed=0)
    action = np.zeros(env.action_space.shape)
    env.step(action)
    copy = sent(env)
    for one, other in zip(env.step(action)[:4], copy.step(action)[:4], strict=True):
        np.testing.assert_array_equal(one, other)
    np.testing.assert_array_equal(env.reset()[0], copy.reset()[0], "their random numbers agree")


def test_gymnasium_says_how_long_an_episode_is():
    env = gymnasium.make("motorspace/Forward-v0", max_episode_steps=300)
    env.reset(seed=0)
    assert [env.step(np.zeros(2))[3] for _ in range(300)].index(True) == 299
    own = ExplorationEnv(max_steps=2)
    own.reset(seed=0)
    assert [own.step(np.zeros(2))[3] for _ in range(2)] == [False, True]


@pytest.mark.parametrize("mode", ["vector_entry_point", "sync"])
def test_make_vec_takes_gymnasiums_own_options(mode):
    envs = gymnasium.make_vec(
        "motorspace/Forward-v0", num_envs=2, vectorization_mode=mode, render_mode="rgb_array",
        max_episode_steps=2,
    )  # fmt: skip
    envs.reset(seed=0)
    assert [envs.step(np.zeros((2, 2)))[3].tolist() for _ in range(2)] == [[False] * 2, [True] * 2]
    pictures = envs.render()
    assert len(pictures) == 2 and pictures[0].shape == (320, 320, 3)
    assert not np.array_equal(*pictures)
    envs.close()


ASYNC = """
import gymnasium, motorspace
from motorspace._errors import UserError
if __name__ == "__main__":
    envs = gymnasium.make_vec("motorspace/Forward-v0", num_envs=2, vectorization_mode="async",
                              vector_kwargs={"context": "CONTEXT"})
    try:
        observations, _ = envs.reset(seed=0)
        print(observations.shape)
    except UserError as error:
        print(error)
    envs.close()
"""


def test_workers_that_are_forked_are_refused():
    said = in_a_new_process(ASYNC.replace("CONTEXT", "fork"))
    assert 'vector_kwargs={"context": "spawn"}' in said and "vector_entry_point" in said


def test_workers_that_are_spawned_work(tmp_path):
    script = tmp_path / "spawn.py"
    script.write_text(ASYNC.replace("CONTEXT", "spawn"))
    done = subprocess.run(
        [sys.executable, script], capture_output=True, text=True, check=False, timeout=120
    )
    assert done.stdout.strip() == "(2, 9)", done.stderr


@pytest.mark.parametrize("first", ["import motorspace, gymnasium", "import gymnasium, motorspace"])
def test_importing_motorspace_is_enough(first):
    code = f"{first}; print(gymnasium.spec('motorspace/Forward-v0').kwargs)"
    assert in_a_new_process(code) == "{'agent': 'forward'}\n"


def test_gymnasium_can_import_motorspace_by_itself():
    code = "import gymnasium; print(gymnasium.make('motorspace:motorspace/Lattice-v0').spec.id)"
    assert in_a_new_process(code) == "motorspace/Lattice-v0\n"


def test_registering_loads_nothing_heavy():
    code = (
        "import sys, motorspace.environments as e; e.register_with_gymnasium();"
        "print('jax' in sys.modules, 'gymnasium' in sys.modules); import gymnasium;"
        "print('jax' in sys.modules, 'motorspace/Forward-v0' in gymnasium.registry)"
    )
    assert in_a_new_process(code) == "False False\nFalse True\n"


def test_episodes_are_the_same_where_float64_is_enabled():
    poses = []
    for enabled in (False, True):
        with jax.enable_x64(enabled):
            env = ExplorationEnv(scenario=MANY)
            env.reset(seed=2)
            poses.append(env.step(np.full(4, 0.3))[4]["pose"])
    np.testing.assert_allclose(*poses, atol=1e-6)
    assert jnp.zeros(1).dtype == jnp.float32
