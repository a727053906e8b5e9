"""Configurations from flat settings, as flags and sweeps give them: {name: value}.

The options of agent, sensor and reader and the fields of the data, the model and the training
have names of their own, so one name says which part a setting belongs to. What does not apply to
the chosen agent, sensor or reader is refused.
"""

import dataclasses
from collections.abc import Iterable
from difflib import get_close_matches
from pathlib import Path
from typing import Any, NamedTuple

from motorspace._errors import UserError
from motorspace._kinds import Parameter, Part, Registry, parameters_of, to_radians
from motorspace.models.config import ModelConfig
from motorspace.training.config import RunConfig, TrainingConfig
from motorspace.training.data import Derived, Logged, Simulated
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
    Parameter(
        "paint",
        None,
        "Colours of the walls, for a retina: flat, flat:SEED, texture:WAVELENGTH:SHARE:SEED; by "
        "default the layout's own.",
        type=str,
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

    Args:
        config: The configuration.
        settings: {field of it, or option of its agent, sensor or reader: value}. Angles are in
            radians, as in the configuration.

    Raises:
        UserError: For a name that no part of the configuration has, and values out of range.

    Example:
        >>> changed(RunConfig(), {"horizon": 3, "max_range": 5.0}).data.horizon
        3
    """
    network = [p.name for group in _network_groups() for p in group.parameters]
    known = [*_names(config.data, settings), *network]
    _refuse_unknown(settings, known, "this configuration")
    return _with_network(dataclasses.replace(config, data=_data(config.data, settings)), settings)


def _names(data: Any, settings: Settings) -> list[str]:
    """Fields of the data, and options of their parts."""
    names = [field.name for field in dataclasses.fields(data)]
    if isinstance(data, Derived):
        return names + _names(data.base, settings)
    parts = [(r, _part(n, data, settings)) for n, r in _registries(data).items()]
    return names + [p.name for registry, part in parts for p in registry.parameters(part.kind)]


def _registries(data: Any) -> dict[str, Registry[Any]]:
    """The fields of the data that hold a part, and the classes that each may name."""
    if isinstance(data, Simulated):
        return {"agent": AGENTS, "sensor": SENSORS}
    if isinstance(data, Logged):
        from motorspace.recordings.catalog import READERS

        return {"reader": READERS}
    return {}


def _part(name: str, data: Any, settings: Settings) -> Part:
    """The agent, sensor or reader that the data will have, before its options are changed."""
    given = settings.get(name, getattr(data, name))
    return _registries(data)[name].part(given) if isinstance(given, str) else given


def _data(data: Any, settings: Settings) -> Any:
    fields = _of(settings, [Parameter(f.name, None) for f in dataclasses.fields(data)])
    if isinstance(data, Derived):
        return dataclasses.replace(data, **{"base": _data(data.base, settings)} | fields)
    for name, registry in _registries(data).items():
        part = _part(name, data, settings)
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
    known = {p.name: p for group in groups for p in group.parameters}
    titles = [group.title for group in groups if group.parameters][:2]
    _refuse_unknown(settings, known, " and ".join(titles))
    return {name: to_radians(known[name], value) for name, value in settings.items()}


def _refuse_unknown(settings: Settings, known: Iterable[str], what: str) -> None:
    for name in settings:
        if name not in (names := list(known)):
            near = get_close_matches(name, names, 1)
            raise UserError(
                f"the setting {name!r} does not apply to {what}",
                remedy=f"perhaps {near[0]!r}" if near else f"choose from {', '.join(names)}",
            )
