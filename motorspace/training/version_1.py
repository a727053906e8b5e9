"""Run folders of format version 1, in which the configuration did not name all of its data."""

import math
from collections.abc import Mapping
from typing import Any

from motorspace.models.config import ModelConfig
from motorspace.training.config import RunConfig, TrainingConfig
from motorspace.training.data import Derived, Given, Simulated
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
ORACLE_MOTORS = 4
"""Channels of the oracle's one command, which is the displacement: (x, y, cos, sin)."""


def config_of_version_1(described: Mapping[str, Any]) -> RunConfig:
    """The configuration in a `config.json` of version 1.

    Such a file says what was simulated, but neither that a run learned from displacements nor
    from a log. The first shows in the sizes of what it was given. A log shows in scales of the
    sensors that are no simulation's; the run then is one on data that were given.
    """
    old, scaling = described["config"], described["scaling"]
    model = {name: VALUES.get(value, value) for name, value in old["model"].items()}
    training = {RENAMED.get(name, name): value for name, value in old["training"].items()}
    training |= {name: model.pop(name) for name in MOVED if name in model}
    data: Any = simulated_of_version_1(old["simulation"])
    motors, sensors = scaling["motors"], tuple(scaling["sensors"])
    scenario = data.scenario()
    if sensors != scenario.sensor.space(scenario.world).scale:
        data = Given("a log, which run folders of version 1 do not name")
    elif (
        model["encoder"] == "identity"
        and described["horizon"] == 1
        and len(motors) == ORACLE_MOTORS
    ):
        data = Derived(data, "oracle")
    return RunConfig(data, ModelConfig(**model), TrainingConfig(**training))


def simulated_of_version_1(old: Mapping[str, Any]) -> Simulated:
    """What was simulated: thirteen fields, angles in units of pi."""
    lattice = old["agent"] == "lattice"
    layout = f"lattice:{old['lattice_size']}" if lattice else old["layout"]
    agent, sensor = old["agent"], "node_index" if lattice else "range_fan"
    values = dict(old)
    for name in ("max_rotation", "field_of_view"):
        values[name] = old[name] * math.pi

    def options(registry: Any, kind: str) -> dict[str, Any]:
        return {p.name: values[p.name] for p in registry.parameters(kind)}

    return Simulated(
        AGENTS.part(agent, options(AGENTS, agent)),
        SENSORS.part(sensor, options(SENSORS, sensor)),
        layout,
        old["horizon"],
        old["min_horizon"],
        old["collision"],
    )
