"""Arenas from configurations."""

from collections.abc import Sequence
from functools import lru_cache
from typing import NamedTuple

import jax
import jax.numpy as jnp
import numpy as np

from motorspace._errors import UserError
from motorspace._kinds import Part
from motorspace._types import Key
from motorspace.control.controller import Controller
from motorspace.models.model import Model
from motorspace.navigation.arena import Arena, Rules
from motorspace.navigation.chained import chained_code
from motorspace.navigation.coded import CodeCommands, InCodes, code_commands
from motorspace.navigation.composed import ComposedCode, Composition, composition
from motorspace.navigation.config import NavigationConfig
from motorspace.navigation.levels import layouts, level_of
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
from motorspace.navigation.problems import Problem, Setting, sample_problems
from motorspace.navigation.tasks import task_named
from motorspace.training.run import Run, initial_run
from motorspace.worlds.catalog import AGENTS, SENSORS
from motorspace.worlds.scenario import Scenario
from motorspace.worlds.stacking import deal_worlds
from motorspace.worlds.world import AbstractWorld


class Codes(NamedTuple):
    """The networks whose codes can be observed, and acted in."""

    trained: Model
    untrained: Model
    """The same network before its first epoch."""
    code_commands: CodeCommands | None = None
    """What makes commands of codes."""
    composition: Composition | None = None
    """What is left of a code after some commands, where codes are no products."""


def codes_of(run: Run, controller: Controller | None = None) -> Codes:
    """The networks of a run, and what its controller adds."""
    codes = Codes(run.model, initial_run(run.config).model)
    if controller is None:
        return codes
    return codes._replace(
        code_commands=code_commands(controller), composition=composition(controller)
    )


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
        if name == "code" and codes.composition is not None:
            return ComposedCode(codes.trained, codes.composition, scenario.agent, task)
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
        split: `"train"`, `"test"`, `"train+test"`, or the name of a world.
        size: How many agents, and problems for each.
        key: The source of the problems.

    Raises:
        UserError: For codes without a run, a run of another agent, and layouts that together
            offer no problem of the level.
    """
    # Whatever is observed, the same task is posed in the same places: that is made once.
    setting, problems = _posed(_Places.of(config, split, size, key))
    probe_key = jax.random.fold_in(jax.random.key(config.seed), 1)
    observer = observer_of(config, setting, codes, key=probe_key)
    shaped = config.reward == "shaped"
    rules = Rules(config.episode_steps, shaped, config.sense_blocked, config.ppo.discount)
    return Arena(setting, task_named(config.task), observer, problems, rules)


def acted_in(config: NavigationConfig, arena: Arena, codes: Codes | None) -> Arena | InCodes:
    """The arena with the actions that the configuration names.

    Raises:
        UserError: For codes without a controller.
    """
    if config.act == "commands":
        return arena
    if codes is None or codes.code_commands is None:
        raise UserError(
            "codes become commands by a controller",
            remedy="give that of the run: ms.load_controller(RUN), or motorspace control RUN",
        )
    return InCodes(arena, codes.code_commands)


class _Places(NamedTuple):
    """What determines the problems of an arena, and can be looked up."""

    task: str
    agent: Part
    sensor: Part
    level: int
    num_layouts: int
    split: str
    size: Size
    key: bytes

    @classmethod
    def of(cls, config: NavigationConfig, split: str, size: Size, key: Key) -> "_Places":
        words = np.asarray(jax.random.key_data(key)).tobytes()
        named = config.task, config.agent, config.sensor, config.level, config.num_layouts
        return cls(*named, split, size, words)


@lru_cache(maxsize=6)
def _posed(places: _Places) -> tuple[Setting, Problem]:
    level, task = level_of(places.level), task_named(places.task)
    config = NavigationConfig(places.task, places.agent, places.sensor)
    worlds = layouts(level, places.split, places.num_layouts)
    setting = setting_of(config, worlds, places.size.num_agents)
    problems = sample_problems(
        setting,
        level,
        num=places.size.num_problems,
        wanders=task.wanders,
        somewhere=not task.has_goal,
        key=jax.random.wrap_key_data(jnp.asarray(np.frombuffer(places.key, np.uint32))),
    )
    return setting, problems
