"""The scenario of an environment, from the options that it is made with."""

from collections.abc import Mapping
from pathlib import Path
from typing import Any

from motorspace._errors import UserError
from motorspace._kinds import Registry
from motorspace.training.data import simulated
from motorspace.training.folder import load_config
from motorspace.worlds.agents import AbstractAgent
from motorspace.worlds.catalog import AGENTS, SENSORS, home_of
from motorspace.worlds.scenario import Scenario, WorldLike
from motorspace.worlds.sensors.base import AbstractSensor

AgentLike = AbstractAgent | str
SensorLike = AbstractSensor[Any] | str


def chosen_scenario(
    agent: AgentLike | None,
    *,
    sensor: SensorLike | None = None,
    layout: WorldLike | None = None,
    scenario: Scenario | None = None,
    run: str | Path | None = None,
    options: Mapping[str, Any] = {},
) -> Scenario:
    """The scenario that is given, that of a run, or one of these parts and options.

    Raises:
        UserError: For options that contradict each other, and as `Scenario` itself.
    """
    if scenario is None and run is None:
        return _of_parts("forward" if agent is None else agent, sensor, layout, options)
    given = {"sensor": sensor, "layout": layout, **options}
    if scenario is not None and run is not None:
        raise UserError("a scenario and a run are two environments", remedy="give one of them")
    if extra := [name for name, value in given.items() if value is not None]:
        raise UserError(
            f"the {'run' if scenario is None else 'scenario'} already says what"
            f" {', '.join(extra)} is",
            remedy="leave it out",
        )
    found = simulated(load_config(str(run)).data).scenario() if scenario is None else scenario
    _check_agent(agent, found.agent)
    return found


def _check_agent(wanted: AgentLike | None, found: AbstractAgent) -> None:
    """Raise `UserError` for an environment of one agent that is made with another."""
    if isinstance(wanted, str) and AGENTS.class_of(wanted) is not type(found):
        raise UserError(
            f"this is an environment of the {wanted} agent, and the agent given is a"
            f" {type(found).__name__}",
            remedy="use motorspace/Exploration-v0",
        )


def _of_parts(
    agent: AgentLike,
    sensor: SensorLike | None,
    layout: WorldLike | None,
    options: Mapping[str, Any],
) -> Scenario:
    home = home_of(agent if isinstance(agent, str) else "")
    sensor = home.sensor if sensor is None else sensor
    families = (_names(AGENTS, agent), _names(SENSORS, sensor))
    known = [name for names in families for name in names]
    if unknown := sorted(options.keys() - set(known)):
        raise UserError(
            f"there is no option {', '.join(unknown)}",
            remedy=f"this agent and this sensor have {', '.join(known) or 'none'}",
        )
    if shared := sorted(options.keys() & families[0] & families[1]):
        raise UserError(
            f"both the agent and the sensor have an option {', '.join(shared)}",
            remedy="give the agent and the sensor as objects",
        )
    body, sense = (
        _built(registry, part, {n: v for n, v in options.items() if n in names})
        for registry, part, names in zip((AGENTS, SENSORS), (agent, sensor), families, strict=True)
    )
    return Scenario(home.layout if layout is None else layout, body, sense)


def _names(registry: Registry[Any], part: Any) -> set[str]:
    """The options of a kind; an object has been given its own."""
    return {p.name for p in registry.parameters(part)} if isinstance(part, str) else set()


def _built(registry: Registry[Any], part: Any, options: Mapping[str, Any]) -> Any:
    return registry.build(registry.part(part, options)) if isinstance(part, str) else part
