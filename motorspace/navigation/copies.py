"""What single and vector environments share: agents that begin anew in any of many layouts."""

from collections.abc import Callable
from pathlib import Path
from typing import Any, NamedTuple

import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np
from gymnasium import spaces
from jaxtyping import Array, Bool, Float, Int

from motorspace._types import Flags, Key
from motorspace.environments.scenarios import chosen_scenario
from motorspace.navigation.arena import Arena, Outcome, State
from motorspace.navigation.arenas import Codes, Size, arena_of
from motorspace.navigation.config import NavigationConfig
from motorspace.navigation.problems import Problem
from motorspace.worlds.catalog import AGENTS, SENSORS
from motorspace.worlds.simulation import select, to_agents_last, to_rows

PROBLEMS = 16
"""Problems in each layout."""


class Now(NamedTuple):
    """N agents, each in one of the layouts; agents in the last axis."""

    layouts: Int[Array, " N"]
    state: State


class Seen(NamedTuple):
    """What Gymnasium returns of N agents, as NumPy arrays of their own."""

    observation: Float[np.ndarray, "N O"]
    pose: Float[np.ndarray, "N 4"]
    goal: Float[np.ndarray, "N 4"]
    acting: Bool[np.ndarray, " N"]
    reward: Float[np.ndarray, " N"]
    terminated: Bool[np.ndarray, " N"]
    truncated: Bool[np.ndarray, " N"]
    blocked: Bool[np.ndarray, " N"]

    @property
    def info(self) -> dict[str, Any]:
        """What is true and not observed."""
        return {name: getattr(self, name) for name in ("pose", "goal", "acting", "blocked")}


class Compiled(NamedTuple):
    """The rules of N agents, compiled."""

    begin: Callable[[Key], Now]
    begin_with: Callable[[Int[Array, " N"], Problem], Now]
    advance: Callable[[Now, Float[Any, "N A"]], tuple[Now, Outcome]]
    replace: Callable[[Flags, Any, Any], Any]


def navigation_config(
    task: str,
    agent: Any = None,
    *,
    sensor: Any = None,
    run: str | Path | None = None,
    **options: Any,
) -> NavigationConfig:
    """The configuration that an environment's options describe.

    Args:
        task: The name of a task.
        agent: The kind of agent, or one made before; forward by default, or the run's.
        sensor: The kind of sensor, or one made before.
        run: The folder of a run, which says what agent and sensor are.
        **options: Fields of `NavigationConfig`, and options of the agent and the sensor.

    Raises:
        UserError: For options that there are not or that do not fit, and a run of another agent.
    """
    fields = {n: options.pop(n) for n in NavigationConfig.__dataclass_fields__ if n in options}
    found = chosen_scenario(agent, sensor=sensor, run=run, options=options)
    if isinstance(fields.get("observe"), list):
        fields["observe"] = tuple(fields["observe"])
    parts = {"agent": AGENTS.part_of(found.agent), "sensor": SENSORS.part_of(found.sensor)}
    return NavigationConfig(**fields | parts | {"task": task})


def bank_of(config: NavigationConfig, codes: Codes | None, split: str) -> Arena:
    """One agent in each of the layouts, with problems there."""
    size = Size(config.num_layouts, PROBLEMS)
    return arena_of(config, codes, split, size, key=jax.random.key(config.seed))


def observation_box(arena: Arena) -> spaces.Box:
    """The bounds of what one agent observes."""
    low, high = (np.asarray(b, np.float32) for b in arena.observer.bounds(arena.scenario))
    return spaces.Box(low, high, dtype=np.float32)


def of_layouts(bank: Arena, layouts: Int[Array, " N"]) -> Arena:
    """Agents in the layouts with these numbers, with the problems there."""

    def chosen(tree: Any) -> Any:
        return jax.tree.map(lambda leaf: leaf[..., layouts], tree)

    scenario = eqx.tree_at(lambda s: s.world, bank.scenario, chosen(bank.scenario.world))
    setting = bank.setting._replace(scenario=scenario, corners=chosen(bank.setting.corners))
    return eqx.tree_at(lambda a: (a.setting, a.problems), bank, (setting, chosen(bank.problems)))


def compiled(bank: Arena, num: int) -> Compiled:
    """The rules of `num` agents, with the layouts as constants: as arguments they cost more."""

    def begin(key: Key) -> Now:
        layout_key, problem_key = jax.random.split(key)
        layouts = jax.random.randint(layout_key, (num,), 0, bank.num_agents, jnp.int32)
        return Now(layouts, of_layouts(bank, layouts).begin(key=problem_key))

    def begin_with(layouts: Int[Array, " N"], problem: Problem) -> Now:
        return Now(layouts, of_layouts(bank, layouts).begin_with(problem))

    def advance(now: Now, action: Float[Any, "N A"]) -> tuple[Now, Outcome]:
        arena = of_layouts(bank, now.layouts)
        state, outcome = arena.advance(now.state, arena.motors(to_agents_last(action)))
        return Now(now.layouts, state), outcome

    return Compiled(jax.jit(begin), jax.jit(begin_with), jax.jit(advance), jax.jit(select))


def seen(now: Now, space: spaces.Box, outcome: Outcome | None = None) -> Seen:
    """What Gymnasium returns; without an outcome, at the start of an episode."""
    state, nothing = now.state, jnp.zeros(len(now.layouts), bool)
    if outcome is None:
        outcome = Outcome(nothing.astype(jnp.float32), nothing, nothing, nothing, nothing)
    # Rounding may put a reading a little beyond its bounds.
    observation = np.clip(np.asarray(to_rows(state.observation)), space.low, space.high)
    goal, pose = (
        np.stack([np.asarray(f) for f in (p.x, p.y, p.heading, p.head)], axis=-1)
        for p in (state.problem.goal, state.pose)
    )
    facts = (outcome.terminated, outcome.truncated, outcome.blocked)
    return Seen(
        observation,
        pose,
        goal,
        np.asarray(state.steps) >= np.asarray(state.problem.num_wander),
        np.asarray(outcome.reward, float),
        *(np.array(fact) for fact in facts),
    )
