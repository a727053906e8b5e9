"""A policy learned from a configuration."""

from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

import equinox as eqx
import jax
import jax.numpy as jnp
from jaxtyping import Array, Float

from motorspace._errors import UserError
from motorspace._types import Key
from motorspace.control.controller import Controller
from motorspace.control.store import load_controller
from motorspace.navigation.arenas import Codes, Size, acted_in, arena_of, codes_of
from motorspace.navigation.config import NavigationConfig
from motorspace.navigation.interface import Environment, Environments
from motorspace.navigation.policies import Policy
from motorspace.navigation.ppo import UpdateRecord, improve, optimiser, start
from motorspace.training.config import RunConfig
from motorspace.training.run import Run, load_run

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
        network: What determined them.
        log: One record for every few updates.
    """

    config: NavigationConfig
    policy: Policy
    codes: Codes | None = None
    network: RunConfig | None = None
    log: tuple[LearningRecord, ...] = ()


def learn_policy(
    config: NavigationConfig,
    run: Run | str | Path | None = None,
    controller: Controller | None = None,
    *,
    callback: RecordCallback = lambda record: None,
) -> TrainedPolicy:
    """Return the policy that a configuration describes, learned by PPO.

    Args:
        config: Task, body, observation, learner.
        run: The run whose codes are observed, or its folder.
        controller: What makes commands of codes, for actions in codes; by default that in the
            folder of the run. Codes that are no products are observed by way of it, too.
        callback: Called now and then with a record: environment steps so far, episodes ended and
            the share of them that reached the goal, mean reward.

    Raises:
        UserError: For codes without a run, actions in codes without a controller, a run of another
            agent, layouts without a problem of the level, and a loss that is no longer finite.
    """
    found = _network(config, run)
    if controller is None and config.act == "codes" and isinstance(run, str | Path):
        controller = load_controller(run)
    codes = None if found is None else codes_of(found, controller)
    return learn_with(config, codes, None if found is None else found.config, callback=callback)


def learn_with(
    config: NavigationConfig,
    codes: Codes | None,
    network: RunConfig | None = None,
    *,
    callback: RecordCallback = lambda record: None,
    split: str = "train",
) -> TrainedPolicy:
    """Return the policy that a configuration describes, learned with networks that are given.

    Args:
        config: Task, body, observation, learner.
        codes: The networks whose codes are observed, or acted in.
        network: What determined them.
        callback: As of `learn_policy`.
        split: The layouts to learn in; see `arena_of`.

    Raises:
        UserError: As `learn_policy`.
    """
    arena_key, policy_key, settle_key, start_key, key = jax.random.split(
        jax.random.key(config.seed), 5
    )
    size = Size(config.ppo.num_agents, PROBLEMS)
    arena = acted_in(config, arena_of(config, codes, split, size, key=arena_key), codes)
    observed = random_observations(arena, key=settle_key)
    policy = Policy(config.policy, observed.shape[1], arena.action_size, key=policy_key)
    steps = arena.commands_per_action * config.ppo.steps_per_update
    num_calls = -(-max(1, round(config.steps / steps)) // UPDATES_AT_ONCE)
    num_updates = num_calls * UPDATES_AT_ONCE
    adam = optimiser(config.ppo, num_updates)
    learner = start(arena, policy.normalised(observed), adam, key=start_key)
    log = []
    for _ in range(num_calls):
        learner, records = improve(
            arena, learner, config.ppo, adam, num_updates=UPDATES_AT_ONCE, key=key
        )
        log.append(_logged(int(learner.update) * steps, records))
        callback(log[-1])
    return TrainedPolicy(config, learner.policy, codes, network, tuple(log))


def _network(config: NavigationConfig, run: Run | str | Path | None) -> Run | None:
    """The run whose codes are observed, if any are."""
    if run is None or not config.needs_run:
        return None
    return run if isinstance(run, Run) else load_run(run)


@eqx.filter_jit
def random_observations(arena: Environment, *, key: Key) -> Float[Array, "S O"]:
    """What agents observe while they execute random commands, agents and moments in rows."""
    begin_key, *keys = jax.random.split(key, 1 + SETTLING // arena.commands_per_action)

    def step(state: Environments, key: Key) -> tuple[Environments, Float[Array, "N O"]]:
        action_key, step_key = jax.random.split(key)
        shape = (arena.num_agents, arena.action_size)
        action = jax.random.uniform(action_key, shape, jnp.float32, -1.0, 1.0)
        after, then = arena.step(state, action, key=step_key)
        return after, then.observation

    _, observed = jax.lax.scan(step, arena.begin(key=begin_key), jnp.stack(keys))
    return observed.reshape(-1, observed.shape[-1])


def _logged(steps: int, records: UpdateRecord) -> LearningRecord:
    episodes = float(records.episodes.sum())
    record = {
        "steps": steps,
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
