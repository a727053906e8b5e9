"""Run folders of format version 1 are read as what they were, or refused with a sentence."""

import json
import math
from dataclasses import replace

import jax
import pytest

from motorspace._errors import UserError
from motorspace.models.config import ModelConfig
from motorspace.models.model import Scaling, build_model
from motorspace.training.checkpoint import named_arrays, packed
from motorspace.training.config import RunConfig, TrainingConfig
from motorspace.training.data import Derived, Given, Simulated
from motorspace.training.folder import load_config
from motorspace.training.run import load_run
from motorspace.worlds.agents import ForwardAgent, HolonomicAgent
from motorspace.worlds.sensors.range_fan import RangeFan

SIMULATION = {
    "agent": "forward",
    "layout": "empty",
    "max_rotation": 0.6,
    "horizon": 2,
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
MODEL = {
    "encoder": "lstm",
    "hidden_size": 8,
    "code_size": 4,
    "width_size": 8,
    "depth": 1,
    "inverse_weight": 0.0,
    "slowness_weight": 0.0,
    "composition_weight": 0.0,
    "isometry_weight": 0.0,
    "train_encoder": True,
    "motor_scaling": "raw",
    "initial_weights": "wide",
}
TRAINING = {
    "epochs": 3,
    "trajectories_per_epoch": 64,
    "fresh": True,
    "batch_size": 32,
    "learning_rate": 0.006,
    "schedule": "cosine",
    "curriculum": 0.3,
    "code_noise": 0.0,
    "average": 0.0,
    "starts": 1,
    "seed": 5,
}
RANGES, PLANAR, ORACLE = (10.0,) * 9, (1.0, 1.0), (1.0,) * 4
LATTICE = {"agent": "lattice", "lattice_size": 3, "horizon": 2, "min_horizon": 1}


def written(folder, sensors=RANGES, motors=PLANAR, *, horizon=2, model=(), **simulation):
    """A folder as the earlier program wrote it."""
    config = {
        "simulation": SIMULATION | simulation,
        "model": MODEL | dict(model),
        "training": TRAINING,
    }
    scaling = {"sensors": list(sensors), "motors": list(motors)}
    described = {"format_version": 1, "config": config, "scaling": scaling, "horizon": horizon}
    folder.mkdir(exist_ok=True)
    (folder / "config.json").write_text(json.dumps(described))
    (folder / "log.jsonl").write_text(json.dumps({"epoch": 3, "code_variance": 0.1}) + "\n")
    return folder


def test_a_forward_run_is_read_with_its_settings_under_their_new_names(tmp_path):
    assert load_config(written(tmp_path)) == RunConfig(
        Simulated(ForwardAgent(0.6 * math.pi), layout="empty", horizon=2),
        ModelConfig("lstm", 8, 4, 8, 1, "raw", "normal_inputs"),
        TrainingConfig(3, 64, batch_size=32, seed=5),
    )


def test_renamed_settings_keep_their_values(tmp_path):
    model = {"encoder": "group", "code_size": 6, "isometry_weight": 1.0, "train_encoder": False}
    folder = written(tmp_path, model=model)
    described = json.loads((folder / "config.json").read_text())
    described["config"]["training"] |= {"average": 0.5, "starts": 3, "fresh": False}
    (folder / "config.json").write_text(json.dumps(described))
    config = load_config(folder)
    assert (config.model.encoder, config.model.code_size) == ("matrix_product", 6)
    training = config.training
    assert (training.ema_decay, training.restarts, training.resample_each_epoch) == (0.5, 3, False)
    assert (training.isometry_weight, training.train_encoder) == (1.0, False)


def test_a_holonomic_run_keeps_all_that_was_simulated(tmp_path):
    changes = {"agent": "holonomic", "head_rule": "turn", "sense_head": True, "num_rays": 5}
    changes |= {"field_of_view": 1.5, "collision": "block", "min_horizon": 1, "layout": "rooms:2"}
    sensors = (10.0,) * 5 + (math.pi / 2,)
    config = load_config(written(tmp_path, sensors, (1.0,) * 4, **changes))
    agent = HolonomicAgent(0.6 * math.pi, head_rule="turn")
    sensor = RangeFan(5, field_of_view=1.5 * math.pi, sense_head=True)
    assert config.data == Simulated(agent, sensor, "rooms:2", 2, 1, "block")


def test_a_lattice_is_named_by_its_side(tmp_path):
    config = load_config(written(tmp_path, (1.0,) * 13, (1.0,) * 6, **LATTICE))
    assert config.data == Simulated("lattice", "node_index", "lattice:3", 2, 1)


def test_an_oracle_is_known_by_the_sizes_of_what_it_was_given(tmp_path):
    folder = written(tmp_path, motors=ORACLE, horizon=1, model={"encoder": "identity"})
    config = load_config(folder)
    base = load_config(written(tmp_path / "plain")).data
    assert config.data == Derived(base, "oracle")


@pytest.mark.parametrize(
    ("sensors", "motors"),
    [((6.0, 7.0), (0.3,)), ((8.2,) * 9, (1.0, 1.0)), (RANGES, (0.1, 0.02, 0.3))],
)
def test_a_run_on_a_log_is_one_on_data_that_only_their_owner_has(tmp_path, sensors, motors):
    config = load_config(written(tmp_path, sensors, motors))
    assert config.data == Given("a log, which run folders of version 1 do not name")


def test_settings_that_an_even_earlier_folder_lacks_have_their_defaults(tmp_path):
    folder = written(tmp_path)
    described = json.loads((folder / "config.json").read_text())
    for part, names in (("simulation", ("sense_head", "head_start")), ("training", ("starts",))):
        for name in names:
            del described["config"][part][name]
    (folder / "config.json").write_text(json.dumps(described))
    assert load_config(folder) == load_config(written(tmp_path / "whole"))


def test_a_layout_file_is_what_it_holds_now_and_that_is_said(tmp_path):
    layout = tmp_path / "mine.layout"
    layout.write_text("bounds 0 0 6 5\n")
    folder = written(tmp_path / "run", layout=str(layout))
    with pytest.warns(UserWarning, match=r"mine\.layout without its content, and is taken"):
        assert load_config(folder).data.layout == Simulated(layout=layout).layout
    layout.unlink()
    with pytest.raises(UserError, match=r"mine\.layout"):
        load_config(folder)


def test_weights_are_read_and_stay_what_they_were(tmp_path):
    folder = written(tmp_path)
    model = build_model(
        load_config(folder).model, Scaling(RANGES, PLANAR), horizon=2, key=jax.random.key(3)
    )
    (folder / "weights.safetensors").write_bytes(packed(model))
    run = load_run(folder)
    assert packed(run.model) == packed(model)
    # The names under which the earlier program kept them.
    assert set(named_arrays(run.model)) == {
        f".{name}"
        for name in (
            "encoder.cell.weight_ih",
            "encoder.cell.weight_hh",
            "encoder.cell.bias",
            "encoder.to_code.weight",
            "encoder.to_code.bias",
            "predictor.mlp.layers[0].weight",
            "predictor.mlp.layers[0].bias",
            "predictor.mlp.layers[1].weight",
            "predictor.mlp.layers[1].bias",
        )
    }
    assert replace(run.config, data=Given()).training.seed == 5


@pytest.mark.parametrize("version", [0, 3, "two", None])
def test_a_format_of_another_version_says_so(tmp_path, version):
    folder = written(tmp_path)
    described = json.loads((folder / "config.json").read_text()) | {"format_version": version}
    (folder / "config.json").write_text(json.dumps(described))
    with pytest.raises(UserError, match=f"format version {version!r}, and this program reads"):
        load_config(folder)


@pytest.mark.parametrize("spoil", ["simulation", "model", "training"])
def test_a_broken_folder_of_version_1_is_one_sentence(tmp_path, spoil):
    folder = written(tmp_path)
    described = json.loads((folder / "config.json").read_text())
    del described["config"][spoil]
    (folder / "config.json").write_text(json.dumps(described))
    with pytest.raises(UserError, match=r"config\.json: the run's configuration cannot be read"):
        load_config(folder)
