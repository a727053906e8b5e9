"""Arenas from configurations."""

from collections.abc import Sequence
from typing import NamedTuple

import jax
import jax.numpy as jnp

from motorspace._errors import UserError
from motorspace._types import Key
from motorspace.models.model import Model
from motorspace.navigation.arena import Arena, Rules
from motorspace.navigation.chained import chained_code
from motorspace.navigation.config import NavigationConfig
from motorspace.navigation.levels import level_of, rooms
from motorspace.navigation.observations import (
    AbstractPart,
    Bump,
    Given,
    LastCommand,
    Observer,
    Ranges,
    Stack,
    TrueDisplacement,
)
from motorspace.navigation.planner import survey
from motorspace.navigation.problems import Setting, sample_problems
from motorspace.navigation.tasks import task_named
from motorspace.training.run import Run, initial_run
from motorspace.worlds.catalog import AGENTS, SENSORS
from motorspace.worlds.scenario import Scenario
from motorspace.worlds.stacking import deal_worlds
from motorspace.worlds.world import AbstractWorld


class Codes(NamedTuple):
    """The networks whose codes can be observed."""

    trained: Model
    untrained: Model
    """The same network before its first epoch."""


def codes_of(run: Run) -> Codes:
    """The networks of a run."""
    return Codes(run.model, initial_run(run.config).model)


class Size(NamedTuple):
    """How many agents there are in an arena, and problems for each of them."""

    num_agents: int
    num_problems: int


def setting_of(
    config: NavigationConfig, worlds: Sequence[AbstractWorld], num_agents: int
) -> Setting:
    """The body and its sensor in these worlds, and where ways bend in them."""
    world = deal_worlds(worlds, num_agents)
    scenario = Scenario(world, AGENTS.build(config.agent), SENSORS.build(config.sensor))
    return Setting(scenario, survey(worlds).at(jnp.arange(num_agents) % len(worlds)))


def observer_of(
    config: NavigationConfig, setting: Setting, codes: Codes | None, *, key: Key
) -> Observer:
    """The parts that a configuration names, and what the task gives.

    Raises:
        UserError: For codes without a run, and as `chained_code`.
    """
    task, scenario = task_named(config.task), setting.scenario

    def code(name: str) -> AbstractPart:
        if codes is None:
            raise UserError(
                f"what {name!r} observes is computed by a trained network",
                remedy="give the run of one",
            )
        model = codes.trained if name == "code" else codes.untrained
        return chained_code(model, scenario.agent, task, key=key)

    momentary: dict[str, AbstractPart] = {
        "ranges": Ranges(scenario.space),
        "bump": Bump(),
        "command": LastCommand(setting.commands),
    }
    stacked = tuple(momentary[name] for name in config.observe if name in momentary)
    known = momentary | {"stack": Stack(stacked), "displacement": TrueDisplacement()}

    def part(name: str) -> AbstractPart:
        return known[name] if name in known else code(name)

    return Observer((*map(part, config.observe), Given(task)))


def arena_of(
    config: NavigationConfig, codes: Codes | None, split: str, size: Size, *, key: Key
) -> Arena:
    """The arena that a configuration describes, in the layouts of training or in others.

    Args:
        config: Task, body, observation, level.
        codes: The networks behind observed codes.
        split: Whether the layouts are those of training or unseen ones.
        size: Agents and problems.
        key: The source of the problems. The observer does not depend on it.

    Raises:
        UserError: For observed codes without a run, a run of another agent, and layouts that
            offer no problem of the level.
    """
    level, task = level_of(config.level), task_named(config.task)
    setting = setting_of(config, rooms(level, split, config.num_layouts), size.num_agents)
    probe_key = jax.random.fold_in(jax.random.key(config.seed), 1)
    observer = observer_of(config, setting, codes, key=probe_key)
    problems = sample_problems(
        setting,
        level,
        num=size.num_problems,
        wanders=task.wanders,
        somewhere=not task.has_goal,
        key=key,
    )
    shaped = config.reward == "shaped"
    rules = Rules(config.episode_steps, shaped, config.sense_blocked, config.ppo.discount)
    return Arena(setting, task, observer, problems, rules)
