"""A policy learned from a configuration."""

from collections.abc import Callable
from dataclasses import dataclass

import equinox as eqx
import jax
import jax.numpy as jnp
from jaxtyping import Array, Float

from motorspace._errors import UserError
from motorspace._types import Key
from motorspace.navigation.arena import Arena, State
from motorspace.navigation.arenas import Codes, Size, arena_of
from motorspace.navigation.config import NavigationConfig
from motorspace.navigation.policies import Policy
from motorspace.navigation.ppo import UpdateRecord, improve, optimiser, start

PROBLEMS = 64
"""Problems for each agent to learn from."""

UPDATES_AT_ONCE = 4
"""Updates between two records."""

SETTLING = 100
"""Random commands of each agent by which the scale of observations is measured."""

LearningRecord = dict[str, float | int]
RecordCallback = Callable[[LearningRecord], None]


@dataclass(frozen=True)
class TrainedPolicy:
    """A policy, what determined it and how it was learned.

    Attributes:
        config: Task, body, observation, learner.
        policy: The networks.
        codes: The networks behind observed codes, if any are observed.
        log: One record for every few updates.
    """

    config: NavigationConfig
    policy: Policy
    codes: Codes | None = None
    log: tuple[LearningRecord, ...] = ()


def learn_policy(
    config: NavigationConfig,
    codes: Codes | None = None,
    *,
    callback: RecordCallback = lambda record: None,
) -> TrainedPolicy:
    """Return the policy that a configuration describes, learned by PPO.

    Args:
        config: Task, body, observation, learner.
        codes: The networks behind observed codes.
        callback: Called now and then with a record: environment steps so far, episodes ended and
            the share of them that reached the goal, mean reward.

    Raises:
        UserError: As `arena_of`, for commands that are numbers, and for a loss that is no longer
            finite.
    """
    arena_key, policy_key, settle_key, start_key, key = jax.random.split(
        jax.random.key(config.seed), 5
    )
    size = Size(config.ppo.num_agents, PROBLEMS)
    arena = arena_of(config, codes, "train", size, key=arena_key)
    observed = random_observations(arena, key=settle_key)
    policy = Policy(config.policy, observed.shape[1], arena.action_size, key=policy_key)
    num_updates = -(-config.num_updates // UPDATES_AT_ONCE) * UPDATES_AT_ONCE
    adam = optimiser(config.ppo, num_updates)
    learner = start(arena, policy.normalised(observed), adam, key=start_key)
    log = []
    for _ in range(num_updates // UPDATES_AT_ONCE):
        learner, records = improve(
            arena, learner, config.ppo, adam, num_updates=UPDATES_AT_ONCE, key=key
        )
        log.append(_logged(config, int(learner.update), records))
        callback(log[-1])
    return TrainedPolicy(config, learner.policy, codes, tuple(log))


@eqx.filter_jit
def random_observations(arena: Arena, *, key: Key) -> Float[Array, "S O"]:
    """What agents observe while they execute random commands, agents and moments in rows."""
    begin_key, *keys = jax.random.split(key, SETTLING + 1)

    def step(state: State, key: Key) -> tuple[State, Float[Array, "N O"]]:
        action_key, step_key = jax.random.split(key)
        shape = (arena.num_agents, arena.action_size)
        action = jax.random.uniform(action_key, shape, jnp.float32, -1.0, 1.0)
        after, then = arena.step(state, action, key=step_key)
        return after, then.observation

    _, observed = jax.lax.scan(step, arena.begin(key=begin_key), jnp.stack(keys))
    return observed.reshape(-1, observed.shape[-1])


def _logged(config: NavigationConfig, update: int, records: UpdateRecord) -> LearningRecord:
    episodes = float(records.episodes.sum())
    record = {
        "steps": update * config.ppo.steps_per_update,
        "episodes": episodes,
        "success": float(records.terminated.sum()) / max(episodes, 1.0),
        "reward": float(records.reward.mean()),
        "value_loss": float(records.value_loss.mean()),
        "entropy": float(records.entropy[-1]),
    }
    if not bool(jnp.isfinite(records.value_loss).all()):
        raise UserError(
            f"the loss is no longer finite after {record['steps']} steps",
            remedy="lower the learning rate",
        )
    return record
