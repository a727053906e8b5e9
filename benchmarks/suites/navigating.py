"""Steps of navigation with learning: all in one program, and by a library on our environments."""

import os

import gymnasium
import jax
from stable_baselines3 import PPO
from stable_baselines3.common.env_util import make_vec_env

import motorspace.environments  # noqa: F401, which registers the environments
from benchmarks.harness import Contender, Launch, report, take_turns
from motorspace.navigation.arenas import Size, arena_of
from motorspace.navigation.config import NavigationConfig, PolicyConfig
from motorspace.navigation.learning import PROBLEMS, random_observations
from motorspace.navigation.policies import Policy
from motorspace.navigation.ppo import improve, optimiser, start

UPDATES = 4
PEER_ENVS, PEER_STEPS = 16, 128


def main() -> None:
    """The task *home* by ranges, bumps and commands, two layers of 64 units."""
    threads = int(os.environ["BENCHMARK_THREADS"])
    contenders = [
        learning("motorspace", NavigationConfig()),
        learning("motorspace, GRU", NavigationConfig(policy=PolicyConfig(memory_size=64))),
        by_library(),
    ]
    rates, first, foreign = take_turns(contenders, turns=3, seconds=3.0)
    report(Launch("navigation with learning", "steps", threads, rates, first, {}, foreign))


def learning(name: str, config: NavigationConfig) -> Contender:
    """Some updates of PPO, again and again from the same weights."""
    keys = jax.random.split(jax.random.key(0), 4)
    arena = arena_of(config, None, "train", Size(config.ppo.num_agents, PROBLEMS), key=keys[0])
    observed = random_observations(arena, key=keys[1])
    policy = Policy(config.policy, observed.shape[1], arena.action_size, key=keys[2])
    adam = optimiser(config.ppo, UPDATES)
    learner = start(arena, policy.normalised(observed), adam, key=keys[3])

    def run() -> None:
        after, _ = improve(
            arena, learner, config.ppo, adam, num_updates=UPDATES, key=jax.random.key(1)
        )
        jax.block_until_ready(after)

    return Contender(name, run, UPDATES * config.ppo.steps_per_update)


def by_library() -> Contender:
    """PPO of Stable-Baselines3 on our single environments, one after the other."""
    envs = make_vec_env(lambda: gymnasium.make("motorspace/Home-v0"), n_envs=PEER_ENVS)
    learner = PPO("MlpPolicy", envs, n_steps=PEER_STEPS, batch_size=512, device="cpu")

    def run() -> None:
        learner.learn(PEER_ENVS * PEER_STEPS, reset_num_timesteps=False)

    return Contender("Stable-Baselines3", run, PEER_ENVS * PEER_STEPS)


if __name__ == "__main__":
    main()
