"""Exported networks compute what the run computes, in ONNX and in NumPy alone."""

import json
import subprocess
import sys

import equinox as eqx
import jax.numpy as jnp
import numpy as np
import pytest

from motorspace._errors import UserError
from motorspace.export.network import TOLERANCE, largest_difference, network_of
from motorspace.export.numpy_model import load
from motorspace.export.onnx import export_onnx, onnx_files
from motorspace.export.standalone import export_numpy, numpy_files
from motorspace.models.encoders.base import AbstractMotorEncoder
from motorspace.models.encoders.baselines import SumEncoder
from motorspace.training.run import Run
from tests.export.networks import HORIZON, KINDS, run_of, sequences

onnxruntime = pytest.importorskip("onnxruntime")


@pytest.mark.parametrize("kind", KINDS)
def test_every_encoder_is_the_same_in_onnx_numpy_and_jax(kind, tmp_path):
    run = run_of(kind)
    export_onnx(run, tmp_path)
    export_numpy(run, tmp_path)
    model = load(tmp_path)
    encoder, predictor = (
        onnxruntime.InferenceSession(tmp_path / f"{name}.onnx") for name in ("encoder", "predictor")
    )
    motors, num_steps = sequences(64, 6 if network_of(run).horizon is None else HORIZON)
    codes = np.asarray(run.encode(motors, num_steps))
    for found in (
        model.encode(motors, num_steps),
        encoder.run(["codes"], {"motors": motors, "num_steps": num_steps})[0],
    ):
        np.testing.assert_allclose(found, codes, atol=1e-5, rtol=1e-5)
    sensors = np.random.default_rng(5).random((64, 5), np.float32)
    (later,) = predictor.run(["later_sensors"], {"sensors": sensors, "codes": codes})
    np.testing.assert_allclose(model.predict(sensors, codes), later, atol=1e-5, rtol=1e-5)


@pytest.mark.parametrize("kind", [k for k in KINDS if k not in ("mlp", "identity")])
@pytest.mark.parametrize(("num", "horizon"), [(1, 1), (3, 11)])
def test_numbers_and_lengths_of_sequences_are_free(kind, num, horizon):
    run = run_of(kind)
    motors, num_steps = sequences(num, horizon)
    session = onnxruntime.InferenceSession(onnx_files(run)["encoder.onnx"])
    (found,) = session.run(None, {"motors": motors, "num_steps": num_steps})
    assert found.shape == (num, 6)
    one_by_one = [
        session.run(None, {"motors": motors[i : i + 1, :n], "num_steps": num_steps[i : i + 1]})[0]
        for i, n in enumerate(num_steps)
    ]
    np.testing.assert_allclose(found, np.concatenate(one_by_one), atol=1e-5, rtol=1e-4)


FRESH = """
import sys
for name in ("jax", "equinox", "motorspace"):
    sys.modules[name] = None
sys.path.insert(0, sys.argv[1])
import numpy as np
from motorspace_model import load
model, given = load(sys.argv[1]), np.load(sys.argv[2])
codes = model.encode(given["motors"], given["num_steps"])
np.savez(sys.argv[3], codes=codes, later=model.predict(given["sensors"], codes))
outside = {name.partition(".")[0] for name in sys.modules} & {"scipy", "jaxtyping", "onnx"}
sys.exit(", ".join(outside) or 0)
"""


def test_the_exported_module_runs_where_there_is_no_jax(tmp_path):
    run, given, found = run_of("lstm"), tmp_path / "given.npz", tmp_path / "found.npz"
    export_numpy(run, tmp_path / "out")
    motors, num_steps = sequences(16, 6)
    sensors = np.random.default_rng(5).random((16, 5), np.float32)
    np.savez(given, motors=motors, num_steps=num_steps, sensors=sensors)
    command = [sys.executable, "-I", "-c", FRESH, tmp_path / "out", given, found]
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
    codes = run.encode(motors, num_steps)
    np.testing.assert_allclose(np.load(found)["codes"], codes, atol=1e-5)
    later = [run.model.predict(jnp.asarray(s), c) for s, c in zip(sensors, codes, strict=True)]
    np.testing.assert_allclose(np.load(found)["later"], later, atol=1e-5, rtol=1e-5)


def test_the_files_say_what_they_are(tmp_path):
    run = run_of("lstm")
    export_numpy(run, tmp_path)
    described = json.loads((tmp_path / "model.json").read_text())
    assert described["config"]["model"]["encoder"] == described["encoder"] == "lstm"
    assert described["largest_difference"] <= TOLERANCE
    assert described["motor_scale"] == [2.5, 1.0]
    session = onnxruntime.InferenceSession(onnx_files(run)["encoder.onnx"])
    about = session.get_modelmeta().custom_metadata_map
    assert json.loads(about["config"]) == described["config"]
    assert [(i.name, i.shape) for i in session.get_inputs()] == [
        ("motors", ["N", "T", 2]),
        ("num_steps", ["N"]),
    ]


def test_the_same_run_gives_the_same_files():
    assert numpy_files(run_of("gru")) == numpy_files(run_of("gru"))
    assert onnx_files(run_of("gru")) == onnx_files(run_of("gru"))


@pytest.mark.parametrize(
    ("motors", "num_steps", "sentence"),
    [
        (np.zeros((3, 4)), None, r"motors must be \[N, T, 2\], not \[3, 4\]"),
        (np.zeros((3, 4, 3)), None, r"motors must be \[N, T, 2\], not \[3, 4, 3\]"),
        (np.zeros((3, 4, 2)), [1, 2], "num_steps must be 3 numbers from 1 to 4"),
        (np.zeros((3, 4, 2)), [1, 2, 5], "num_steps must be 3 numbers from 1 to 4"),
        (np.zeros((3, 4, 2)), [1, 2, 0], "num_steps must be 3 numbers from 1 to 4"),
    ],
)
def test_the_numpy_model_refuses_shapes_that_do_not_fit(motors, num_steps, sentence, tmp_path):
    export_numpy(run_of("sum"), tmp_path)
    with pytest.raises(ValueError, match=sentence):
        load(tmp_path).encode(motors, None if num_steps is None else np.array(num_steps))


def test_the_numpy_model_says_which_horizon_and_sizes_it_needs(tmp_path):
    export_numpy(run_of("mlp"), tmp_path)
    model = load(tmp_path)
    with pytest.raises(ValueError, match="sequences of 4 commands, not 3"):
        model.encode(np.zeros((1, 3, 2)))
    with pytest.raises(ValueError, match=r"must be \[N, 5\] and \[N, 6\], not \[2, 5\] and \[1, 6"):
        model.predict(np.zeros((2, 5)), np.zeros((1, 6)))


def test_a_model_of_another_format_is_refused(tmp_path):
    export_numpy(run_of("none"), tmp_path)
    (tmp_path / "model.json").write_text('{"format_version": 99}')
    with pytest.raises(ValueError, match=r"model\.json is not of format 1"):
        load(tmp_path)


class OffRun(Run):
    """A run that computes something else than its weights say."""

    def encode(self, motors, num_steps=None):
        return super().encode(motors, num_steps) + 2 * TOLERANCE


@pytest.mark.parametrize("export", [export_onnx, export_numpy])
def test_an_export_that_differs_from_the_run_is_not_written(export, tmp_path):
    run = run_of("sum")
    with pytest.raises(UserError, match="differs from the run by 2e-05, more than 1e-05"):
        export(OffRun(run.config, run.model), tmp_path / "out")
    assert not (tmp_path / "out").exists()


def test_a_prediction_that_is_no_number_is_refused():
    run = run_of("none")
    with pytest.raises(UserError, match="differs from the run by nan"):
        largest_difference(
            run,
            network_of(run),
            lambda motors, num_steps: np.zeros((len(motors), 6), np.float32),
            lambda sensors, codes: np.full_like(sensors, np.nan),
        )


class OwnEncoder(AbstractMotorEncoder):
    def __call__(self, motors, num_steps):
        return motors[0]


class OwnSum(SumEncoder):
    """What a subclass computes cannot be known either."""


@pytest.mark.parametrize("export", [export_onnx, export_numpy])
@pytest.mark.parametrize("own", [OwnEncoder, OwnSum])
def test_an_encoder_of_ones_own_is_refused_in_one_sentence(export, own, tmp_path):
    run = run_of("sum")
    encoder = OwnEncoder() if own is OwnEncoder else OwnSum(2, 8, 6, key=jnp.zeros(2, jnp.uint32))
    model = eqx.tree_at(lambda m: m.encoder, run.model, encoder)
    with pytest.raises(UserError, match=rf"^{own.__name__} is not a class of motorspace"):
        export(Run(run.config, model), tmp_path)


@pytest.mark.parametrize("missing", ["onnx", "onnxruntime"])
def test_a_missing_extra_says_how_to_install_it(missing, monkeypatch, tmp_path):
    monkeypatch.setitem(sys.modules, missing, None)
    monkeypatch.delitem(sys.modules, "motorspace.export.onnx_graph", raising=False)
    with pytest.raises(UserError, match=rf"^{missing} is not .* pip install 'motorspace\[onnx\]'"):
        export_onnx(run_of("sum"), tmp_path)
