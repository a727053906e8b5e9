"""PPO beside Stable-Baselines3's on the same task with the same settings."""

import jax
import numpy as np
import pytest

from motorspace.navigation.config import PolicyConfig, PPOConfig
from motorspace.navigation.policies import Policy
from motorspace.navigation.ppo import improve, optimiser, start
from tests.navigation.point import LONGEST, NEAR, STEP, ToTheMiddle

NUM_AGENTS, NUM_UPDATES, SEEDS = 64, 40, 8
CONFIG = PPOConfig(num_agents=NUM_AGENTS, num_steps=16, num_minibatches=4, learning_rate=3e-3)


def ours(seed):
    """The mean reward of each update."""
    point, adam = ToTheMiddle(NUM_AGENTS), optimiser(CONFIG, NUM_UPDATES)
    weights, begin, key = jax.random.split(jax.random.key(seed), 3)
    policy = Policy(PolicyConfig(64), 2, 2, key=weights)
    learner = start(point, policy, adam, key=begin)
    _, record = improve(point, learner, CONFIG, adam, num_updates=NUM_UPDATES, key=key)
    return np.asarray(record.reward)


def theirs(seed):
    """The mean reward of each update of Stable-Baselines3."""
    from stable_baselines3 import PPO

    envs = vector_env(seed)
    learner = PPO(
        "MlpPolicy", envs, n_steps=CONFIG.num_steps, n_epochs=CONFIG.num_epochs,
        batch_size=CONFIG.steps_per_update // CONFIG.num_minibatches,
        learning_rate=lambda left: CONFIG.learning_rate * left, seed=seed, device="cpu",
        gamma=CONFIG.discount, gae_lambda=CONFIG.trace, clip_range=CONFIG.clip,
        policy_kwargs={"net_arch": [64, 64], "log_std_init": PolicyConfig().log_std},
    )  # fmt: skip
    learner.learn(NUM_UPDATES * CONFIG.steps_per_update)
    return envs.rewards.reshape(NUM_UPDATES, -1).mean(axis=1)


def vector_env(seed):
    """The point's task as Stable-Baselines3 asks for it, with every reward kept."""
    from gymnasium import spaces
    from stable_baselines3.common.vec_env import VecEnv

    class Points(VecEnv):
        def __init__(self):
            box = spaces.Box(-10.0, 10.0, (2,), np.float32)
            super().__init__(NUM_AGENTS, box, spaces.Box(-1.0, 1.0, (2,), np.float32))
            self.random, self.kept = np.random.default_rng(seed), []

        @property
        def rewards(self):
            return np.concatenate(self.kept)

        def reset(self):
            self.place = self.random.uniform(-1, 1, (NUM_AGENTS, 2)).astype(np.float32)
            self.steps = np.zeros(NUM_AGENTS, int)
            return self.place.copy()

        def step_async(self, actions):
            self.actions = np.clip(actions, -1, 1)

        def step_wait(self):
            self.place = self.place + np.float32(STEP) * self.actions
            self.steps += 1
            away = np.linalg.norm(self.place, axis=1)
            terminated = away < NEAR
            truncated = ~terminated & (self.steps >= LONGEST)
            ended = terminated | truncated
            infos = [
                {"TimeLimit.truncated": bool(cut), "terminal_observation": place.copy()}
                for cut, place in zip(truncated, self.place, strict=True)
            ]
            fresh = self.random.uniform(-1, 1, (NUM_AGENTS, 2)).astype(np.float32)
            self.place = np.where(ended[:, None], fresh, self.place)
            self.steps[ended] = 0
            self.kept.append(-away)
            return self.place.copy(), -away, ended, infos

        def close(self):
            pass

        def get_attr(self, name, indices=None):
            return [getattr(self, name, None)] * NUM_AGENTS

        def set_attr(self, name, value, indices=None):
            raise NotImplementedError

        def env_method(self, name, *args, indices=None, **kwargs):
            raise NotImplementedError

        def env_is_wrapped(self, wrapper, indices=None):
            return [False] * NUM_AGENTS

        def seed(self, seed=None):
            return [None] * NUM_AGENTS

    return Points()


@pytest.mark.slow
def test_rewards_rise_as_with_stable_baselines():
    pytest.importorskip("stable_baselines3", reason="the extra peers is not installed")
    mine, peers = (np.stack([learn(seed) for seed in range(SEEDS)]) for learn in (ours, theirs))
    assert mine.shape == peers.shape == (SEEDS, NUM_UPDATES)
    for phase in (slice(8, 16), slice(16, 24), slice(32, 40)):
        one, other = mine[:, phase].mean(axis=1), peers[:, phase].mean(axis=1)
        error = np.sqrt(one.var(ddof=1) / SEEDS + other.var(ddof=1) / SEEDS)
        print(phase, one.mean(), other.mean(), error)
        assert abs(one.mean() - other.mean()) < 2.5 * error
