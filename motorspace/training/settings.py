"""Configurations from flat settings, as flags and sweeps give them: {name: value}.

The options of agent, sensor and reader and the fields of the data, the model and the training
have names of their own, so one name says which part a setting belongs to. What does not apply to
the chosen agent, sensor or reader is refused.
"""

import dataclasses
import math
from collections.abc import Mapping
from difflib import get_close_matches
from pathlib import Path
from typing import Any, NamedTuple

from motorspace._errors import UserError
from motorspace._kinds import Parameter, parameters_of
from motorspace.models.config import ModelConfig
from motorspace.training.config import RunConfig, TrainingConfig
from motorspace.training.data import Derived, Given, Logged, Simulated
from motorspace.training.presets import PresetName, Settings
from motorspace.worlds.catalog import AGENTS, SENSORS, home_of

SIMULATED = (
    Parameter(
        "layout",
        None,
        "Walls: a bundled layout, a layout file, rooms:SEED or lattice:SIDE.",
        type=str,
    ),
    Parameter("horizon", None, "Motor commands per trajectory (T).", type=int),
    Parameter(
        "min_horizon",
        None,
        "Shortest trajectory, where lengths are drawn from min_horizon to horizon.",
        type=int,
    ),
    Parameter(
        "collision",
        "resample",
        "A command that a wall forbids: resample draws another, block discards its translation.",
        ("resample", "block"),
    ),
)
LOGGED = (
    Parameter("horizon", 6, "Scans from the beginning of a transition to its end."),
    Parameter(
        "min_horizon",
        None,
        "Training also sees transitions over fewer scans, down to these.",
        type=int,
    ),
    Parameter(
        "per_scan",
        True,
        "Chain the motor increments between two scans into one command.",
    ),
    Parameter("num_blocks", 20, "Blocks of time that are dealt out to training and test."),
)


class Group(NamedTuple):
    """Settings that belong together."""

    title: str
    parameters: tuple[Parameter, ...]


def simulated_groups(agent: str, sensor: str | None = None) -> list[Group]:
    """Every setting of a run in simulation."""
    sensor = sensor or home_of(agent).sensor
    return [
        Group(f"agent {agent}", AGENTS.parameters(agent)),
        Group(f"sensor {sensor}", SENSORS.parameters(sensor)),
        Group("simulation", SIMULATED),
        *_network_groups(),
    ]


def logged_groups(reader: str) -> list[Group]:
    """Every setting of a run on a log."""
    from motorspace.recordings.catalog import READERS

    return [
        Group(f"reader {reader}", READERS.parameters(reader)),
        Group("log", LOGGED),
        *_network_groups(),
    ]


def _network_groups() -> list[Group]:
    return [
        Group("network", parameters_of(ModelConfig)),
        Group("training", parameters_of(TrainingConfig)),
    ]


def configured(
    agent: str, settings: Settings, *, sensor: str | None = None, preset: PresetName = "paper"
) -> RunConfig:
    """The configuration of a run in simulation that some settings ask for.

    What `settings` hold wins over the preset. Values are as people write them: angles in units
    of pi. Raises `UserError` for settings that do not apply.
    """
    sensor = sensor or home_of(agent).sensor
    values = _in_radians(settings, simulated_groups(agent, sensor))
    data = Simulated(
        AGENTS.part(agent, _of(values, AGENTS.parameters(agent))),
        SENSORS.part(sensor, _of(values, SENSORS.parameters(sensor))),
        **_of(values, SIMULATED),
    )
    return _with_network(RunConfig(data, preset=preset), values)


def configured_on_log(
    log: Path, settings: Settings, *, reader: str | None = None, preset: PresetName = "paper"
) -> RunConfig:
    """The configuration of a run on a log; see `configured`."""
    from motorspace.recordings.catalog import READERS, reader_for

    kind = reader or reader_for(log)
    values = _in_radians(settings, logged_groups(kind))
    part = READERS.part(kind, _of(values, READERS.parameters(kind)))
    data = Logged(log, part, **_of(values, LOGGED))
    return _with_network(RunConfig(data, preset=preset), values)


def changed(config: RunConfig, settings: Settings) -> RunConfig:
    """The configuration with other values of some fields, whichever part they belong to.

    Angles are in radians, as in the configuration. Raises `UserError` for unknown names.
    """
    return _with_network(dataclasses.replace(config, data=_data(config.data, settings)), settings)


def _data(data: Any, settings: Settings) -> Any:
    if isinstance(data, Derived):
        return dataclasses.replace(data, base=_data(data.base, settings))
    if isinstance(data, Given):
        return data
    fields = _of(settings, [Parameter(f.name, None) for f in dataclasses.fields(data)])
    families = {"agent": AGENTS, "sensor": SENSORS} if isinstance(data, Simulated) else {}
    for name, registry in families.items():
        part = fields.get(name, getattr(data, name))
        options = dict(part.options) | _of(settings, registry.parameters(part.kind))
        fields[name] = registry.part(part.kind, options)
    return dataclasses.replace(data, **fields)


def _with_network(config: RunConfig, settings: Settings) -> RunConfig:
    return dataclasses.replace(
        config,
        model=dataclasses.replace(config.model, **_of(settings, parameters_of(ModelConfig))),
        training=dataclasses.replace(
            config.training, **_of(settings, parameters_of(TrainingConfig))
        ),
    )


def _of(settings: Settings, parameters: Any) -> dict[str, Any]:
    return {p.name: settings[p.name] for p in parameters if p.name in settings}


def _in_radians(settings: Settings, groups: list[Group]) -> dict[str, Any]:
    """The settings with angles in radians. Raises `UserError` for a name in no group."""
    known: Mapping[str, Parameter] = {p.name: p for group in groups for p in group.parameters}
    for name in settings:
        if name not in known:
            near = get_close_matches(name, known, 1)
            raise UserError(
                f"the setting {name!r} does not apply to {groups[0].title} and {groups[1].title}",
                remedy=f"perhaps {near[0]!r}" if near else f"choose from {', '.join(known)}",
            )
    return {
        name: value * math.pi if known[name].in_pi else value for name, value in settings.items()
    }
