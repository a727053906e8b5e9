"""Steps of navigation with learning: all in one program, and by a library on our environments."""

import os

import gymnasium
import jax
from stable_baselines3 import PPO
from stable_baselines3.common.env_util import make_vec_env

import motorspace.environments  # noqa: F401, which registers the environments
from benchmarks.harness import Contender, Launch, report, take_turns
from motorspace.navigation.config import NavigationConfig, PolicyConfig
from motorspace.navigation.learning import UPDATES_AT_ONCE, begin_learning

PEER_ENVS, PEER_STEPS = 16, 128


def main() -> None:
    """The task *home* by ranges, bumps and commands, two layers of 64 units."""
    threads = int(os.environ["BENCHMARK_THREADS"])
    contenders = [
        learned("motorspace", NavigationConfig()),
        learned("motorspace, GRU", NavigationConfig(policy=PolicyConfig(memory_size=64))),
        by_library(),
    ]
    rates, first, foreign = take_turns(contenders, turns=3, seconds=3.0)
    report(Launch("navigation with learning", "steps", threads, rates, first, {}, foreign))


def learned(name: str, config: NavigationConfig) -> Contender:
    """Some updates of PPO, again and again from the same weights."""
    learning = begin_learning(config, None)

    def run() -> None:
        after, _ = learning.improved(learning.learner)
        jax.block_until_ready(after)

    return Contender(name, run, UPDATES_AT_ONCE * learning.steps_per_update)


def by_library() -> Contender:
    """PPO of Stable-Baselines3 on our single environments, one after the other."""
    envs = make_vec_env(lambda: gymnasium.make("motorspace/Home-v0"), n_envs=PEER_ENVS)
    learner = PPO("MlpPolicy", envs, n_steps=PEER_STEPS, batch_size=512, device="cpu")

    def run() -> None:
        learner.learn(PEER_ENVS * PEER_STEPS, reset_num_timesteps=False)

    return Contender("Stable-Baselines3", run, PEER_ENVS * PEER_STEPS)


if __name__ == "__main__":
    main()
