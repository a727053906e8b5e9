"""A policy beside chance and beside one who knows the map, in layouts seen and unseen."""

import jax

from motorspace.navigation.actors import AbstractActor, Chance, Learned, Planner
from motorspace.navigation.arena import Arena
from motorspace.navigation.arenas import Size, arena_of
from motorspace.navigation.evaluation import Numbers, evaluate_actor
from motorspace.navigation.learning import TrainedPolicy

AGENTS_AT_ONCE = 256

NUM_PROBLEMS = 2048
"""Problems in seen layouts, and as many in unseen ones, where nobody says another number."""


def evaluate_policy(
    trained: TrainedPolicy, *, num: int | None = None, sampled: bool = True, seed: int = 0
) -> Numbers:
    """Return how well a policy solves fresh problems, beside chance and the planner.

    Args:
        trained: The policy.
        num: Problems in the layouts of training, and as many in unseen ones.
        sampled: Whether commands are sampled from the policy, as in training, or its middle ones.
        seed: The seed of the problems.

    Returns:
        The measures of `evaluate_actor` as `seen.*` and `unseen.*` for the policy, `chance.*` and
        `planner.*` in unseen layouts.
    """
    num = NUM_PROBLEMS if num is None else num
    num_agents = min(num, AGENTS_AT_ONCE)
    size = Size(num_agents, max(1, num // num_agents))
    problem_key, key = jax.random.split(jax.random.fold_in(jax.random.key(seed), 7))
    seen, unseen = (
        arena_of(trained.config, trained.codes, split, size, key=problem_key)
        for split in ("train", "test")
    )
    actor = Learned(trained.policy, sampled)
    rows: dict[str, tuple[Arena, AbstractActor]] = {
        "seen": (seen, actor),
        "unseen": (unseen, actor),
        "chance": (unseen, Chance()),
    }
    if unseen.task.has_goal:
        rows["planner"] = (unseen, Planner())
    return {
        f"{row}.{measure}": value
        for row, (arena, who) in rows.items()
        for measure, value in evaluate_actor(arena, who, key=key).items()
    }
