"""A configuration is plain data: to JSON and back, one hash, and nothing out of range."""

import json
import math
import subprocess
import sys
from dataclasses import FrozenInstanceError, replace

import pytest

from motorspace._errors import UserError
from motorspace._kinds import Part
from motorspace.models.config import ModelConfig
from motorspace.training.config import RunConfig, TrainingConfig, config_from_json
from motorspace.training.data import Derived, Given, Logged, Simulated
from motorspace.worlds.agents import HolonomicAgent
from motorspace.worlds.sensors.range_fan import RangeFan

TABLE = "time,motor_a,sensor_a\n" + "".join(f"{t},{t % 3},{t % 7}\n" for t in range(40))
OWN_LAYOUT = "bounds 0 0 4 3\n"


@pytest.fixture
def log(tmp_path):
    path = tmp_path / "robot log.csv"
    path.write_text(TABLE)
    return path


def every_kind_of_data(log):
    simulated = Simulated(
        HolonomicAgent(0.5, head_rule="turn"), RangeFan(5, 4.0), OWN_LAYOUT, 4, 2, "block"
    )
    logged = Logged(log, "carmen", horizon=3, min_horizon=1, per_scan=False, num_rays=5)
    return {
        "simulated": simulated,
        "lattice": Simulated("lattice", layout="lattice:3"),
        "logged": logged,
        "table": Logged(str(log)),
        "derived": Derived(simulated, "scaled_rotations", 1.1),
        "derived from a log": Derived(logged, "oracle"),
        "given": Given("what my robot did"),
        "painted": Simulated(sensor="retina", paint="texture:4"),
        "views": Given("what my robot saw", shape=(24, 32, 3)),
    }


def as_written(config):
    return json.loads(json.dumps(config.as_json()))


def test_every_kind_of_data_is_the_same_after_json(log):
    for data in every_kind_of_data(log).values():
        config = RunConfig(data, preset="best", training=TrainingConfig(epochs=3, seed=5))
        again = config_from_json(as_written(config), where="here")
        assert again == config
        assert again.hash() == config.hash()


def test_all_of_them_have_hashes_of_their_own(log):
    hashes = {RunConfig(data).hash() for data in every_kind_of_data(log).values()}
    assert len(hashes) == len(every_kind_of_data(log))


def test_the_hash_is_stable():
    """Results of earlier versions name their configurations by it."""
    assert RunConfig().hash() == "74efbaa368bf"
    assert RunConfig(Simulated("lattice"), preset="best").hash() == "95f71f6d1699"


def test_every_field_of_a_configuration_changes_its_hash():
    config = RunConfig(Simulated("holonomic"), training=TrainingConfig(batch_size=5))
    changed = {config.hash()}
    parts = {
        "data": {"layout": "empty", "horizon": 3, "min_horizon": 2, "collision": "block"}
        | {"paint": "flat:3"},
        "model": {"encoder": "gru", "hidden_size": 1, "code_size": 1, "width_size": 1, "depth": 1}
        | {"motor_scaling": "maximum", "initial_weights": "scaled"},
        "training": {
            name: {bool: not value, int: 7, float: 0.5, str: "constant"}[type(value)]
            for name, value in vars(TrainingConfig()).items()
        }
        | {"precision": "tf32"},
    }
    num = 1
    for part, fields in parts.items():
        assert fields.keys() | {"agent", "sensor"} >= vars(getattr(config, part)).keys()
        for name, value in fields.items():
            other = replace(config, **{part: replace(getattr(config, part), **{name: value})})
            changed.add(other.hash())
            num += 1
    for agent in (HolonomicAgent(1.0), HolonomicAgent(head_rule="turn")):
        changed.add(RunConfig(Simulated(agent)).hash())
        num += 1
    assert len(changed) == num


def test_objects_names_and_parts_describe_the_same_agent():
    named, made, part = (Simulated(a) for a in ("forward", RANGES["agent"], Part("forward")))
    assert named == made == part
    assert named.sensor == Part("range_fan", tuple(RANGES["sensor"].items()))
    assert Simulated("lattice").layout == "lattice:6"
    assert (Simulated("lattice").horizon, Simulated("lattice").min_horizon) == (5, 1)


def test_a_layout_file_is_kept_by_its_content_and_a_name_by_its_name(tmp_path):
    path = tmp_path / "mine.layout"
    path.write_text(f"# my room\n{OWN_LAYOUT}")
    for given in (path, str(path), OWN_LAYOUT):
        assert Simulated(layout=given) == Simulated(layout=OWN_LAYOUT)
    assert str(tmp_path) not in json.dumps(Simulated(layout=path).as_json())
    assert Simulated(layout="rooms:3").layout == "rooms:3"


def test_a_log_is_kept_by_its_hash_and_refused_once_it_has_changed(log):
    data = Logged(log)
    assert data.recording().sensors.shape == (40, 1)
    moved = log.with_name("moved.csv")
    log.rename(moved)
    with pytest.raises(UserError, match=r"robot log\.csv: the log cannot be read"):
        data.recording()
    assert data.at(moved).recording().sensors.shape == (40, 1)
    assert replace(data.at(moved), path=data.path) == data
    moved.write_text(TABLE + "40,1,1\n")
    with pytest.raises(UserError, match="this is not the log that the run has learned from"):
        data.at(moved)


def test_data_do_not_change_once_made():
    with pytest.raises(FrozenInstanceError):
        Simulated().horizon = 3
    with pytest.raises(FrozenInstanceError):
        RunConfig().data = Given()


OUT_OF_RANGE = [
    ("epochs", 0),
    ("trajectories_per_epoch", 0), ("trajectories_per_epoch", 50),
    ("batch_size", 0), ("batch_size", 2001), ("restarts", 0),
    ("learning_rate", 0.0), ("learning_rate", -1.0), ("learning_rate", math.nan),
    ("learning_rate", math.inf),
    ("curriculum", -0.1), ("curriculum", 2.0), ("code_noise", -1.0), ("code_noise", math.inf),
    ("ema_decay", 1.5), ("ema_decay", 1.0), ("ema_decay", -1.0), ("ema_decay", math.nan),
    ("inverse_weight", -0.1), ("slowness_weight", -0.1), ("composition_weight", math.nan),
    ("isometry_weight", math.inf),
    ("seed", -1), ("seed", 2**31),
    ("hidden_size", 0), ("code_size", 0), ("width_size", 0), ("depth", 0), ("depth", -1),
    ("encoder", "group"), ("horizon", 0), ("min_horizon", 0),
    ("min_horizon", 7), ("layout", "nowhere"), ("layout", "rooms:-1"),
    ("layout", "rooms:99999999999999999999"), ("layout", "lattice:0"), ("agent", "crab"),
    ("sensor", "nose"), ("angle", 0.0), ("num_blocks", 0),
]  # fmt: skip


@pytest.mark.parametrize(("name", "value"), OUT_OF_RANGE, ids=lambda value: str(value)[:24])
def test_values_out_of_range_are_one_sentence_that_names_them(log, name, value):
    kinds = [
        lambda **made: TrainingConfig(**made),
        lambda **made: ModelConfig(**made),
        lambda **made: Simulated(**made),
        lambda **made: Derived(**({"base": Simulated(), "change": "oracle"} | made)),
        lambda **made: Logged(log, "carmen", **made),
    ]
    fields = (TrainingConfig, ModelConfig, Simulated, Derived, Logged)
    make = next(
        make for make, kind in zip(kinds, fields, strict=True) if name in kind.__dataclass_fields__
    )
    with pytest.raises(UserError) as refused:
        make(**{name: value})
    assert "\n" not in str(refused.value)
    assert name in str(refused.value) or str(value) in str(refused.value)


WRONG_TYPES = """
from motorspace._errors import UserError
from motorspace.models.config import ModelConfig
from motorspace.training.config import TrainingConfig
from motorspace.training.data import Derived, Given, Simulated

for make, values in (
    (TrainingConfig, [("epochs", 2.5), ("epochs", "5"), ("epochs", True), ("seed", 0.5)]),
    (TrainingConfig, [("learning_rate", "fast"), ("curriculum", True), ("code_noise", None)]),
    (TrainingConfig, [("schedule", "linear"), ("train_encoder", 1), ("train_encoder", "no")]),
    (ModelConfig, [("hidden_size", 8.0), ("motor_scaling", "double"), ("depth", None)]),
    (ModelConfig, [("initial_weights", "wide"), ("encoder", 3)]),
    (Simulated, [("horizon", 1.5), ("min_horizon", "2"), ("collision", "bounce")]),
    (lambda **made: Derived(Simulated(), **made), [("change", "inverted")]),
    (lambda **made: Derived(made["base"], "oracle"), [("base", Given())]),
):
    for name, value in values:
        try:
            make(**{name: value})
            raise SystemExit(f"accepted: {name} = {value!r}")
        except UserError as refused:
            assert name in str(refused), refused
"""


NUMBERS = """
from motorspace.training.config import RunConfig, TrainingConfig
from motorspace.training.data import Derived, Simulated
from motorspace.worlds.sensors.range_fan import RangeFan

def config(ten, one, zero):
    training = TrainingConfig(learning_rate=one, code_noise=zero, curriculum=zero)
    base = Simulated("forward", RangeFan(max_range=ten))
    return RunConfig(Derived(base, "scaled_rotations", one), training=training)

whole, exact = config(10, 1, 0), config(10.0, 1.0, 0.0)
assert whole == exact and whole.hash() == exact.hash()
"""


@pytest.mark.parametrize("script", [WRONG_TYPES, NUMBERS], ids=["wrong types", "whole numbers"])
def test_types_are_checked_and_whole_numbers_are_floats_where_those_belong(script):
    # In a process of its own, without the checks of annotations, which come first in tests.
    subprocess.run([sys.executable, "-c", script], check=True)


def test_a_run_on_a_log_is_no_base_for_changes_of_simulations(log):
    with pytest.raises(UserError, match="'shuffled' cannot be derived from a log"):
        Derived(Logged(log), "shuffled")


@pytest.mark.parametrize(
    ("part", "change", "message"),
    [
        ("agent", {"kind": "crab"}, "there is no agent named 'crab'.*--import MODULE"),
        ("sensor", {"kind": "nose"}, "there is no sensor named 'nose'.*--import MODULE"),
        ("agent", {"speed": 3}, "the agent 'forward' has no option speed"),
        ("layout", "lattice:x", "the side of a lattice"),
        ("horizon", None, "broken, or of another version"),
    ],
)
def test_what_a_configuration_names_and_is_not_there_is_named_with_the_file(part, change, message):
    written = as_written(RunConfig())
    if isinstance(change, dict):
        written["data"][part] |= change
    elif change is None:
        written["data"]["horizont"] = written["data"].pop(part)
    else:
        written["data"][part] = change
    with pytest.raises(UserError, match=message) as refused:
        config_from_json(written, where="run/config.json")
    assert str(refused.value).startswith(("run/config.json: ", "layout "))


def test_an_encoder_that_is_not_there_is_named_with_the_file_and_never_imported():
    written = as_written(RunConfig())
    written["model"]["encoder"] = "os"
    with pytest.raises(UserError, match=r"run: there is no encoder named 'os'.*--import MODULE"):
        config_from_json(written, where="run")


RANGES = {
    "agent": Part("forward", (("max_rotation", 0.8 * math.pi),)),
    "sensor": {
        "num_rays": 9,
        "max_range": 10.0,
        "field_of_view": math.pi,
        "sense_head": False,
    },
}
