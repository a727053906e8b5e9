"""Flat settings, as flags and sweeps give them, reach the part that they belong to."""

import json
import math
from dataclasses import replace

import pytest

from motorspace._errors import UserError
from motorspace.models.config import ModelConfig
from motorspace.training.config import RunConfig, TrainingConfig, config_from_json
from motorspace.training.data import Derived, Given, Logged, Simulated
from motorspace.training.presets import BEST, LATTICE, preset_settings
from motorspace.training.settings import changed, configured, configured_on_log
from motorspace.worlds.agents import ForwardAgent, HolonomicAgent
from motorspace.worlds.sensors.range_fan import RangeFan


@pytest.fixture
def log(tmp_path):
    path = tmp_path / "log.csv"
    path.write_text("time,motor_a,sensor_a\n" + "".join(f"{t},1,2\n" for t in range(30)))
    return path


def test_settings_reach_agent_sensor_simulation_network_and_training():
    settings = {
        "max_rotation": 0.4,
        "head_rule": "turn",
        "num_rays": 5,
        "field_of_view": 1.5,
        "layout": "empty",
        "collision": "block",
        "encoder": "gru",
        "width_size": 7,
        "epochs": 3,
        "ema_decay": 0.5,
    }
    expected = RunConfig(
        Simulated(
            HolonomicAgent(0.4 * math.pi, head_rule="turn"),
            RangeFan(5, field_of_view=1.5 * math.pi),
            "empty",
            collision="block",
        ),
        ModelConfig(encoder="gru", width_size=7),
        TrainingConfig(epochs=3, ema_decay=0.5),
    )
    assert configured("holonomic", settings) == expected


def test_a_log_has_the_settings_of_its_reader(log):
    config = configured_on_log(
        log, {"horizon": 2, "num_rays": 5, "epochs": 3, "num_blocks": 10}, reader="carmen"
    )
    assert config.data == Logged(log, "carmen", horizon=2, num_blocks=10, num_rays=5)
    assert config.training.epochs == 3
    assert configured_on_log(log, {}).data == Logged(log, "table")


@pytest.mark.parametrize(
    ("agent", "settings", "message"),
    [
        ("forward", {"head_rule": "set"}, "'head_rule' does not apply to agent forward and"),
        ("forward", {"max_rotatoin": 1}, "does not apply to .*; perhaps 'max_rotation'"),
        ("lattice", {"num_rays": 3}, "'num_rays' does not apply"),
        ("forward", {"num_blocks": 3}, "'num_blocks' does not apply to agent forward and sensor"),
        ("forward", {"starts": 3}, "perhaps 'restarts'"),
        ("forward", {"zzz": 3}, "choose from max_rotation, num_rays, .*, seed"),
        ("crab", {}, "there is no agent named 'crab'"),
    ],
)
def test_settings_that_do_not_apply_are_refused_naming_the_nearest(agent, settings, message):
    with pytest.raises(UserError, match=message):
        configured(agent, settings)


def test_settings_of_a_simulation_do_not_apply_to_a_log(log):
    for name in ("layout", "max_rotation", "collision", "num_rays"):
        with pytest.raises(UserError, match=f"{name!r} does not apply to reader table and log"):
            configured_on_log(log, {name: 1})


WRITTEN = [
    {"restarts": 1},
    {"encoder": "lstm", "code_size": 50},
    {"code_noise": 0.0},
    {"learning_rate": 6e-3, "curriculum": 0.3},
    {"hidden_size": 100, "isometry_weight": 0.0, "epochs": 5000},
]


@pytest.mark.parametrize("written", WRITTEN, ids=lambda w: " ".join(w))
def test_what_a_user_writes_wins_over_the_preset_even_if_it_is_the_default(written):
    config = configured("forward", written, preset="best")
    fields = vars(config.model) | vars(config.training)
    assert {name: fields[name] for name in written} == written
    rest = BEST.keys() - written.keys()
    assert {name: fields[name] for name in rest} == {name: BEST[name] for name in rest}
    told = config.as_json()
    again = config_from_json(json.loads(json.dumps(told)), where="")
    assert again == config


def test_presets_know_the_budget_of_the_lattice():
    best, paper = (configured("lattice", {}, preset=p) for p in ("best", "paper"))
    assert paper.training == TrainingConfig(**LATTICE)
    assert paper.model == ModelConfig()
    assert (best.training.epochs, best.training.learning_rate) == (500, BEST["learning_rate"])
    assert best == RunConfig(Simulated("lattice"), preset="best")
    with pytest.raises(UserError, match="there is no preset 'worst'; choose one of paper, best"):
        preset_settings("worst", "forward")


def test_a_configuration_is_changed_wherever_the_setting_belongs():
    config = RunConfig(Simulated("holonomic"), preset="best")
    after = changed(config, {"max_rotation": 1.0, "max_range": 4.0, "horizon": 3, "epochs": 9})
    assert after.data == Simulated(HolonomicAgent(1.0), RangeFan(max_range=4.0), horizon=3)
    assert after.model == config.model
    assert after.training == replace(config.training, epochs=9)
    assert changed(config, {}) == config


def test_parts_are_exchanged_whole_and_then_changed():
    config = RunConfig(Simulated("holonomic"))
    after = changed(config, {"agent": "forward", "max_rotation": 1.0})
    assert after.data == Simulated(ForwardAgent(1.0))
    with pytest.raises(UserError, match="'head_rule' does not apply to this configuration"):
        changed(config, {"agent": "forward", "head_rule": "turn"})


def test_derived_data_change_with_their_base_and_logs_with_their_reader(log):
    base = Simulated()
    config = changed(RunConfig(Derived(base, "scaled_rotations")), {"angle": 1.1, "horizon": 2})
    assert config.data == Derived(replace(base, horizon=2), "scaled_rotations", 1.1)
    logged = changed(RunConfig(Logged(log, "carmen")), {"num_rays": 3, "per_scan": False})
    assert logged.data == Logged(log, "carmen", per_scan=False, num_rays=3)


@pytest.mark.parametrize("name", ["epoch", "max_rotatoin", "path", "angle", "code_sise"])
def test_what_no_part_of_a_configuration_has_is_refused(name):
    with pytest.raises(UserError, match=f"{name!r} does not apply to this configuration"):
        changed(RunConfig(Simulated()), {name: 1})
    with pytest.raises(UserError, match="'layout' does not apply"):
        changed(RunConfig(Given()), {"layout": "empty"})
