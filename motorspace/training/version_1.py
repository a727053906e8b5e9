"""Run folders of format version 1, in which the configuration did not name all of its data."""

import math
import warnings
from collections.abc import Mapping
from dataclasses import replace
from typing import Any

from motorspace._kinds import Registry
from motorspace.models.config import ModelConfig
from motorspace.training.config import RunConfig, TrainingConfig
from motorspace.training.data import Derived, Given, Simulated, simulated
from motorspace.worlds.catalog import AGENTS, SENSORS

RENAMED = {
    "starts": "restarts",
    "average": "ema_decay",
    "fresh": "resample_each_epoch",
}
MOVED = (
    "inverse_weight",
    "slowness_weight",
    "composition_weight",
    "isometry_weight",
    "train_encoder",
)
VALUES = {"group": "matrix_product", "wide": "normal_inputs"}
ORACLE_MOTORS = (1.0,) * 4
"""Scale of the oracle's one command, which is the displacement: (x, y, cos, sin)."""


DEFAULTS: Mapping[str, Any] = {
    "agent": "forward",
    "layout": "paper",
    "max_rotation": 0.8,
    "horizon": 6,
    "min_horizon": None,
    "num_rays": 9,
    "max_range": 10.0,
    "field_of_view": 1.0,
    "collision": "resample",
    "head_rule": "set",
    "head_start": "aligned",
    "sense_head": False,
    "lattice_size": 6,
}
"""What was simulated unless the file says otherwise; angles in units of pi."""


def config_of_version_1(described: Mapping[str, Any], *, where: object) -> RunConfig:
    """The configuration in a `config.json` of version 1.

    Such a file says what was simulated, but neither that a run learned from displacements nor
    from a log. The first shows in the sizes of what it was given. A log shows in scales of
    sensors and commands that are no simulation's; the run then is one on data that were given.

    Warns of a layout file, of which such a file keeps the path alone.
    """
    old, scaling = described["config"], described["scaling"]
    model = {name: VALUES.get(value, value) for name, value in old["model"].items()}
    training = {RENAMED.get(name, name): value for name, value in old["training"].items()}
    training |= {name: model.pop(name) for name in MOVED if name in model}
    simulation = DEFAULTS | old["simulation"]
    data: Any = simulated_of_version_1(simulation)
    sensors, motors = tuple(scaling["sensors"]), tuple(scaling["motors"])
    config = RunConfig(data, ModelConfig(**model), TrainingConfig(**training))
    if not _fits(config, sensors, motors):
        return replace(config, data=Given("a log, which run folders of version 1 do not name"))
    if "\n" in data.layout:
        warnings.warn(
            f"{where}: the run names the layout file {simulation['layout']} without its content, "
            "and is taken to have learned in what the file holds now",
            stacklevel=2,
        )
    if _learned_from_displacements(config, described["horizon"], motors):
        return replace(config, data=Derived(data, "oracle"))
    return config


def _fits(config: RunConfig, sensors: tuple[float, ...], motors: tuple[float, ...]) -> bool:
    """Whether a simulation's sensors and commands have these scales."""
    scenario = simulated(config.data).scenario()
    commands = scenario.agent.commands
    raw = config.model.motor_scaling == "raw"
    scales = (1.0,) * commands.size if raw else commands.scale, ORACLE_MOTORS
    return sensors == scenario.sensor.space(scenario.world).scale and motors in scales


def _learned_from_displacements(config: RunConfig, horizon: int, motors: tuple[float, ...]) -> bool:
    return config.model.encoder == "identity" and horizon == 1 and motors == ORACLE_MOTORS


def simulated_of_version_1(old: Mapping[str, Any]) -> Simulated:
    """What was simulated."""
    lattice = old["agent"] == "lattice"
    layout = f"lattice:{old['lattice_size']}" if lattice else old["layout"]
    agent, sensor = old["agent"], "node_index" if lattice else "range_fan"
    values = dict(old)
    for name in ("max_rotation", "field_of_view"):
        values[name] = old[name] * math.pi

    def options(registry: Registry[Any], kind: str) -> dict[str, Any]:
        return {p.name: values[p.name] for p in registry.parameters(kind)}

    return Simulated(
        AGENTS.part(agent, options(AGENTS, agent)),
        SENSORS.part(sensor, options(SENSORS, sensor)),
        layout,
        old["horizon"],
        old["min_horizon"],
        old["collision"],
    )
