"""Proximal policy optimisation whose updates are one compiled program.

Episodes that end because time is up are not taken for ones that reached an end: what would have
come is added as the value of their last observation (Pardo et al., 2018).
"""

from typing import Any, NamedTuple

import equinox as eqx
import jax
import jax.numpy as jnp
import optax
from jaxtyping import Array, Bool, Float, Int

from motorspace._types import Key, Scalar
from motorspace.navigation.config import PPOConfig
from motorspace.navigation.interface import Environment, Environments, Observations
from motorspace.navigation.policies import Answers, Hiddens, Policy


class Learner(eqx.Module):
    """All that learning carries from one update to the next."""

    policy: Policy
    optimiser: optax.OptState
    environments: Environments
    observation: Observations
    hidden: Hiddens
    begins: Bool[Array, " N"]
    """Whether the observation is the first of an episode."""
    update: Int[Array, ""]


class Rollout(NamedTuple):
    """What N agents did at T steps."""

    observation: Float[Array, "T N O"]
    begins: Bool[Array, "T N"]
    action: Float[Array, "T N A"]
    log_probability: Float[Array, "T N"]
    value: Float[Array, "T N"]
    next_value: Float[Array, "T N"]
    """The value of what the action led to."""
    reward: Float[Array, "T N"]
    terminated: Bool[Array, "T N"]
    truncated: Bool[Array, "T N"]
    acted: Bool[Array, "T N"]


class Batch(NamedTuple):
    """What some agents did, from what they remembered at the beginning."""

    hidden: Hiddens
    rollout: Rollout
    advantage: Float[Array, "T N"]


class UpdateRecord(NamedTuple):
    """What is logged of an update."""

    episodes: Scalar
    """Episodes that ended."""
    terminated: Scalar
    """Those of them that reached an end."""
    reward: Scalar
    """The mean reward of an action."""
    value_loss: Scalar
    entropy: Scalar


def optimiser(config: PPOConfig, num_updates: int) -> optax.GradientTransformation:
    """Adam on clipped gradients, whose step size falls to 0 over all updates."""
    steps = num_updates * config.num_epochs * config.num_minibatches
    schedule = optax.linear_schedule(config.learning_rate, 0.0, steps)
    clipped = optax.clip_by_global_norm(config.max_gradient)
    return optax.chain(clipped, optax.adam(schedule, eps=1e-5))


@eqx.filter_jit
def start(
    environment: Environment, policy: Policy, adam: optax.GradientTransformation, *, key: Key
) -> Learner:
    """The state before the first update."""
    environments = environment.begin(key=key)
    return Learner(
        policy,
        adam.init(eqx.filter(policy, eqx.is_inexact_array)),
        environments,
        environment.observed(environments),
        policy.initial(environment.num_agents),
        jnp.ones(environment.num_agents, bool),
        jnp.zeros((), jnp.int32),
    )


@eqx.filter_jit
def improve(
    environment: Environment,
    learner: Learner,
    config: PPOConfig,
    adam: optax.GradientTransformation,
    *,
    num_updates: int,
    key: Key,
) -> tuple[Learner, UpdateRecord]:
    """The state after `num_updates` more updates, and the record [updates] of each.

    An update's randomness is a function of `key` and of its number alone.
    """
    arrays, fixed = eqx.partition(learner, eqx.is_array)

    def one(arrays: Learner, _: None) -> tuple[Learner, UpdateRecord]:
        learner = eqx.combine(arrays, fixed)
        after, record = improve_once(environment, learner, config, adam, key=key)
        return eqx.filter(after, eqx.is_array), record

    arrays, records = jax.lax.scan(one, arrays, length=num_updates)
    return eqx.combine(arrays, fixed), records


def improve_once(
    environment: Environment,
    learner: Learner,
    config: PPOConfig,
    adam: optax.GradientTransformation,
    *,
    key: Key,
) -> tuple[Learner, UpdateRecord]:
    """The state after one update."""
    act_key, learn_key = jax.random.split(jax.random.fold_in(key, learner.update))
    hidden = learner.hidden
    learner, rollout = act(environment, learner, config.num_steps, key=act_key)
    batch = Batch(hidden, rollout, advantages(rollout, config))
    policy, moments, value_loss = learn(learner, batch, config, adam, key=learn_key)
    learner = eqx.tree_at(
        lambda state: (state.policy, state.optimiser, state.update),
        learner,
        (policy, moments, learner.update + 1),
    )
    return learner, _record(rollout, value_loss, policy)


def act(
    environment: Environment, learner: Learner, num_steps: int, *, key: Key
) -> tuple[Learner, Rollout]:
    """The state after `num_steps` actions of every agent, and what happened."""
    policy, each = learner.policy, jax.vmap(learner.policy)
    now = learner.environments, learner.observation, learner.hidden, learner.begins

    def step(now: Any, key: Key) -> tuple[Any, Rollout]:
        environments, observation, hidden, begins = now
        action_key, step_key = jax.random.split(key)
        answer = each(jnp.where(begins[:, None], 0.0, hidden), observation)
        action = policy.sampled(answer.mean, key=action_key)
        environments, then = environment.step(environments, action, key=step_key)
        ahead = each(answer.hidden, then.final).value
        happened = Rollout(
            observation,
            begins,
            action,
            policy.log_probability(answer.mean, action),
            answer.value,
            ahead,
            then.reward,
            then.terminated,
            then.truncated,
            then.acted,
        )
        ended = then.terminated | then.truncated
        return (environments, then.observation, answer.hidden, ended), happened

    now, rollout = jax.lax.scan(step, now, jax.random.split(key, num_steps))
    return (
        eqx.tree_at(
            lambda state: (state.environments, state.observation, state.hidden, state.begins),
            learner,
            now,
        ),
        rollout,
    )


def advantages(rollout: Rollout, config: PPOConfig) -> Float[Array, "T N"]:
    """Generalised advantage estimates; a truncated step counts on the value of what follows."""
    ended = rollout.terminated | rollout.truncated
    ahead = jnp.where(rollout.terminated, 0.0, rollout.next_value)
    surprise = rollout.reward + config.discount * ahead - rollout.value
    decay = jnp.where(ended, 0.0, config.discount * config.trace)

    def back(
        later: Float[Array, " N"], now: tuple[Float[Array, " N"], Float[Array, " N"]]
    ) -> tuple[Float[Array, " N"], Float[Array, " N"]]:
        surprise, decay = now
        advantage = surprise + decay * later
        return advantage, advantage

    first = jnp.zeros_like(surprise[0])
    return jax.lax.scan(back, first, (surprise, decay), reverse=True)[1]


def learn(
    learner: Learner,
    batch: Batch,
    config: PPOConfig,
    adam: optax.GradientTransformation,
    *,
    key: Key,
) -> tuple[Policy, optax.OptState, Scalar]:
    """The policy after some passes over a batch, agents in random groups."""
    trainable, fixed = eqx.partition(learner.policy, eqx.is_inexact_array)
    num_agents = batch.advantage.shape[1]

    def loss(trainable: Policy, group: Batch) -> tuple[Scalar, Scalar]:
        return objective(eqx.combine(trainable, fixed), group, config)

    def step(carry: Any, agents: Int[Array, " G"]) -> tuple[Any, Scalar]:
        trainable, moments = carry
        rest = jax.tree.map(lambda leaf: leaf[:, agents], (batch.rollout, batch.advantage))
        group = Batch(batch.hidden[agents], *rest)
        gradient, value_loss = jax.grad(loss, has_aux=True)(trainable, group)
        # Optax raises its decay rates, Python floats, to the power of a count of whole numbers.
        with jax.numpy_dtype_promotion("standard"):
            change, moments = adam.update(gradient, moments)
        return (optax.apply_updates(trainable, change), moments), value_loss

    keys = jax.random.split(key, config.num_epochs)
    orders = jax.vmap(lambda key: jax.random.permutation(key, num_agents))(keys)
    groups = orders.reshape(config.num_epochs * config.num_minibatches, -1)
    (trainable, moments), losses = jax.lax.scan(step, (trainable, learner.optimiser), groups)
    return eqx.combine(trainable, fixed), moments, losses.mean()


def objective(policy: Policy, batch: Batch, config: PPOConfig) -> tuple[Scalar, Scalar]:
    """The clipped objective, to be minimised, and the value's part of it."""
    done = batch.rollout
    answers: Answers = policy.answers(batch.hidden, done.observation, done.begins)
    acted = done.acted.astype(jnp.float32)
    weight = acted / jnp.maximum(acted.sum(), 1.0)
    mean = jnp.sum(weight * batch.advantage)
    spread = jnp.sqrt(jnp.sum(weight * (batch.advantage - mean) ** 2))
    advantage = (batch.advantage - mean) / (spread + 1e-8)
    change = policy.log_probability(answers.mean, done.action) - done.log_probability
    ratio = jnp.exp(change)
    clipped = jnp.clip(ratio, 1 - config.clip, 1 + config.clip)
    gain = jnp.sum(weight * jnp.minimum(ratio * advantage, clipped * advantage))
    error = answers.value - (done.value + batch.advantage)
    value_loss = jnp.sum(weight * error**2)
    loss = -gain + config.value_weight * value_loss - config.entropy_weight * policy.entropy
    return loss, value_loss


def _record(rollout: Rollout, value_loss: Scalar, policy: Policy) -> UpdateRecord:
    ended = rollout.terminated | rollout.truncated
    return UpdateRecord(
        ended.sum().astype(jnp.float32),
        rollout.terminated.sum().astype(jnp.float32),
        jnp.sum(rollout.reward) / jnp.maximum(rollout.acted.sum(), 1).astype(jnp.float32),
        value_loss,
        policy.entropy,
    )
