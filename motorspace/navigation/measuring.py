"""A policy beside chance and beside one who knows the map, in layouts seen and unseen."""

from dataclasses import replace

import jax

from motorspace._types import Key
from motorspace.navigation.actors import AbstractActor, Chance, Learned, LearnedInCodes, Planner
from motorspace.navigation.arena import Arena
from motorspace.navigation.arenas import Codes, Size, arena_of
from motorspace.navigation.config import NavigationConfig
from motorspace.navigation.evaluation import Numbers, measures, run_episodes
from motorspace.navigation.explorer import explorer
from motorspace.navigation.learning import TrainedPolicy

AGENTS_AT_ONCE = 256

NUM_PROBLEMS = 2048
"""Problems in seen layouts, and as many in unseen ones, where nobody says another number."""

BOTH = "train+test"


def evaluate_policy(
    trained: TrainedPolicy,
    *,
    num: int | None = None,
    sampled: bool = True,
    beside: bool = True,
    seed: int = 0,
) -> Numbers:
    """Return how well a policy solves fresh problems, beside chance and the planner.

    Args:
        trained: The policy.
        num: Problems in the layouts of training, and as many in unseen ones.
        sampled: Whether commands are sampled from the policy, as in training, or its middle ones.
        beside: Whether chance and the planner are measured as well.
        seed: The seed of the problems.

    Returns:
        The measures of `evaluate_actor` as `seen.*` and `unseen.*` for the policy, `chance.*` and
        `planner.*` in unseen layouts.
    """
    arena = _arena(trained.config, trained.codes, num, seed)
    seen, unseen = _halves(arena, actor_of(trained, sampled=sampled), seed)
    own = {f"seen.{name}": v for name, v in seen.items()}
    own |= {f"unseen.{name}": v for name, v in unseen.items()}
    return own | (evaluate_others(trained.config, num=num, seed=seed) if beside else {})


def evaluate_others(config: NavigationConfig, *, num: int | None = None, seed: int = 0) -> Numbers:
    """Return how well chance and the planner solve problems in unseen layouts.

    Args:
        config: The task. What is observed makes no difference.
        num: How many problems.
        seed: The seed of the problems.

    Returns:
        `chance.*` and `planner.*`; of *explore* the planner enters the nearest new cell.
    """
    arena = _blind_arena(config, num, seed, "test")
    planner = Planner() if arena.task.has_goal else explorer(arena)
    others: dict[str, AbstractActor] = {"chance": Chance(), "planner": planner}
    return {
        f"{row}.{name}": value
        for row, actor in others.items()
        for name, value in _measured(arena, actor, seed).items()
    }


def evaluate_in(
    trained: TrainedPolicy | None,
    config: NavigationConfig,
    split: str,
    *,
    num: int | None = None,
    seed: int = 0,
) -> Numbers:
    """Return how well a policy solves fresh problems in given layouts.

    Args:
        trained: The policy; None for chance.
        config: The task, and the body.
        split: `"train"`, `"test"`, or the name of a world such as `"paper"`.
        num: How many problems.
        seed: The seed of the problems.
    """
    if trained is None:
        return _measured(_blind_arena(config, num, seed, split), Chance(), seed)
    arena = _arena(config, trained.codes, num, seed, split)
    return _measured(arena, actor_of(trained, sampled=True), seed)


def actor_of(trained: TrainedPolicy, *, sampled: bool) -> AbstractActor:
    """Returns who acts by a policy, in commands or in codes."""
    codes = trained.codes
    if trained.config.act == "commands" or codes is None or codes.code_commands is None:
        return Learned(trained.policy, sampled)
    return LearnedInCodes(trained.policy, codes.code_commands, sampled)


def _arena(
    config: NavigationConfig, codes: Codes | None, num: int | None, seed: int, split: str = BOTH
) -> Arena:
    """Seen and unseen layouts in turn, half of the agents in each: all is one program."""
    num = NUM_PROBLEMS if num is None else num
    num_agents = min(num, AGENTS_AT_ONCE)
    size = Size(len(split.split("+")) * num_agents, max(1, num // num_agents))
    return arena_of(config, codes, split, size, key=_keys(seed)[0])


def _blind_arena(config: NavigationConfig, num: int | None, seed: int, split: str = BOTH) -> Arena:
    """The same for those who observe nothing that a network makes."""
    return _arena(replace(config, observe=("ranges",), act="commands"), None, num, seed, split)


def _measured(arena: Arena, actor: AbstractActor, seed: int) -> Numbers:
    return measures(arena, run_episodes(arena, actor, key=_keys(seed)[1]))


def _halves(arena: Arena, actor: AbstractActor, seed: int) -> tuple[Numbers, Numbers]:
    """The measures in seen and in unseen layouts."""
    done = run_episodes(arena, actor, key=_keys(seed)[1])
    seen, unseen = (
        jax.tree.map(lambda leaf, place=place: leaf[..., place::2], done) for place in range(2)
    )
    return measures(arena, seen), measures(arena, unseen)


def _keys(seed: int) -> tuple[Key, Key]:
    """For the problems, and for what is random about who solves them."""
    problem_key, key = jax.random.split(jax.random.fold_in(jax.random.key(seed), 7))
    return problem_key, key
