"""PPO against answers by hand and a task that it must solve."""

import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np
import pytest

from motorspace import UserError
from motorspace.navigation.config import PolicyConfig, PPOConfig
from motorspace.navigation.policies import Policy
from motorspace.navigation.ppo import Rollout, advantages, improve, optimiser, start
from tests.navigation.point import ToTheMiddle

GAMMA, LAMBDA = 0.5, 0.5


def rollout(reward, value, next_value, terminated, truncated):
    """What one agent did, as far as advantages depend on it."""
    columns = [jnp.asarray(c)[:, None] for c in (reward, value, next_value)]
    flags = [jnp.asarray(c)[:, None] for c in (terminated, truncated)]
    num = len(reward)
    nothing = jnp.zeros((num, 1, 1))
    return Rollout(
        nothing, jnp.zeros((num, 1), bool), nothing, jnp.zeros((num, 1)), columns[1], columns[2],
        columns[0], *flags, jnp.ones((num, 1), bool),
    )  # fmt: skip


def test_a_truncated_step_counts_on_what_follows_and_a_terminated_one_does_not():
    config = PPOConfig(discount=GAMMA, trace=LAMBDA)
    done = rollout(
        reward=[1.0, 2.0, 3.0, 4.0],
        value=[0.5, 1.0, 1.5, 2.0],
        next_value=[1.0, 8.0, 2.0, 6.0],
        terminated=[False, False, False, True],
        truncated=[False, True, False, False],
    )
    last = 4.0 - 2.0
    third = 3.0 + GAMMA * 2.0 - 1.5 + GAMMA * LAMBDA * last
    second = 2.0 + GAMMA * 8.0 - 1.0
    first = 1.0 + GAMMA * 1.0 - 0.5 + GAMMA * LAMBDA * second
    found = advantages(done, config)[:, 0]
    np.testing.assert_allclose(found, [first, second, third, last], rtol=1e-6)


@pytest.mark.parametrize("memory", [0, 8])
def test_a_point_finds_its_goal(memory):
    config = PPOConfig(num_agents=64, num_steps=16, num_minibatches=4, learning_rate=3e-3)
    point, num = ToTheMiddle(), 40
    policy = Policy(PolicyConfig(16, memory), 2, 2, key=jax.random.key(0))
    adam = optimiser(config, num)
    learner = start(point, policy, adam, key=jax.random.key(1))
    learner, records = improve(point, learner, config, adam, num_updates=num, key=jax.random.key(2))
    first, last = records.reward[:3].mean(), records.reward[-3:].mean()
    assert records.terminated[-3:].sum() / records.episodes[-3:].sum() > 0.97
    assert last > 0.6 * first, "rewards are minus distances"
    assert int(learner.update) == num


def test_an_update_depends_on_its_number_and_the_key_alone():
    config = PPOConfig(num_agents=64, num_steps=4, num_minibatches=4)
    point, adam = ToTheMiddle(), optimiser(PPOConfig(), 4)
    policy = Policy(PolicyConfig(8), 2, 2, key=jax.random.key(0))
    key = jax.random.key(2)
    once = twice = start(point, policy, adam, key=jax.random.key(1))
    once, _ = improve(point, once, config, adam, num_updates=2, key=key)
    for _ in range(2):
        twice, _ = improve(point, twice, config, adam, num_updates=1, key=key)
    for one, other in zip(*map(jax.tree.leaves, (once.policy, twice.policy)), strict=True):
        np.testing.assert_allclose(one, other, atol=1e-6) if eqx.is_array(one) else None


def test_all_updates_are_one_program():
    class Counted(ToTheMiddle):
        def step(self, state, action, *, key):
            traced.append(0)
            return super().step(state, action, key=key)

    traced, config = [], PPOConfig(num_agents=64, num_steps=4, num_minibatches=4)
    point, adam = Counted(), optimiser(config, 4)
    policy = Policy(PolicyConfig(8), 2, 2, key=jax.random.key(0))
    learner = start(point, policy, adam, key=jax.random.key(1))
    key, counts = jax.random.key(2), []
    for _ in range(3):
        learner, _ = improve(point, learner, config, adam, num_updates=2, key=key)
        counts.append(len(traced))
    assert counts[0] == counts[-1], "nothing is weakly typed at first, which would compile twice"


def test_a_memory_is_emptied_where_an_episode_begins():
    policy = Policy(PolicyConfig(8, 4), 3, 2, key=jax.random.key(0))
    seen = jax.random.normal(jax.random.key(1), (6, 1, 3))
    begins = jnp.arange(6)[:, None] == 3
    whole = policy.answers(jnp.ones((1, 4)), seen, begins)
    rest = policy.answers(jnp.zeros((1, 4)), seen[3:], jnp.zeros((3, 1), bool))
    np.testing.assert_allclose(whole.mean[3:], rest.mean, rtol=1e-5)
    other = policy.answers(jnp.zeros((1, 4)), seen, begins)
    assert not np.allclose(whole.mean[:3], other.mean[:3])


def test_observations_are_brought_to_one_scale():
    policy = Policy(PolicyConfig(8), 3, 2, key=jax.random.key(0))
    seen = jax.random.normal(jax.random.key(1), (500, 3)) * jnp.array([[100.0, 50.0, 0.0]]) + 7.0
    fitted = policy.normalised(seen)
    np.testing.assert_allclose(fitted.offset, seen.mean(axis=0))
    np.testing.assert_allclose(fitted.scale[:2], seen.std(axis=0)[:2])
    np.testing.assert_allclose(fitted.scale[2], 0.01 * fitted.scale[0])


def test_densities_are_those_of_a_normal_distribution():
    policy = Policy(PolicyConfig(8, log_std=-1.0), 3, 2, key=jax.random.key(0))
    mean, action = jnp.array([0.1, 0.2]), jnp.array([0.3, -0.4])
    std = np.exp(-1.0)
    by_hand = -0.5 * ((0.2**2 + 0.6**2) / std**2) - 2 * np.log(std * np.sqrt(2 * np.pi))
    np.testing.assert_allclose(policy.log_probability(mean, action), by_hand, rtol=1e-5)
    many = policy.sampled(jnp.zeros((4000, 2)), key=jax.random.key(3))
    np.testing.assert_allclose(many.std(), std, rtol=0.03)


@pytest.mark.parametrize(
    ("options", "message"),
    [
        ({"num_agents": 10, "num_minibatches": 3}, "10 agents do not make 3 equal groups"),
        ({"discount": 1.5}, "discount must be from 0 to 1"),
        ({"num_steps": 0}, "num_steps must be at least 1"),
    ],
)
def test_bad_options(options, message):
    with pytest.raises(UserError, match=message):
        PPOConfig(**options)
