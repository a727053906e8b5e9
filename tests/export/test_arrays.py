"""Exported arrays: row i of every file is trajectory i, and a schema says what is in them."""

import json
import sys

import numpy as np
import pytest

from motorspace._arrays import read_array
from motorspace._errors import UserError
from motorspace.export.arrays import CHUNK_SIZE, export_arrays, tables_of, trajectory_files
from tests.export.networks import run_of, trajectories


def drawn(data, num, *, key):
    return trajectories(num)


def test_arrays_are_those_of_the_run_and_its_trajectories(tmp_path):
    run, given = run_of("sum"), trajectories(5)
    export_arrays(run, tmp_path, num=5, draw=drawn)
    experience, displacements = given.experience, given.displacements
    expected = {
        "codes": run.encode(experience.motors, experience.num_steps),
        "displacements": displacements.achieved,
        "nominal_displacements": displacements.nominal,
        "motors": experience.motors,
        "num_steps": experience.num_steps,
        "sensors": experience.sensors,
        "later_sensors": experience.later_sensors,
    }
    schema = json.loads((tmp_path / "schema.json").read_text())
    assert (schema["num"], schema["seed"]) == (5, 0)
    assert schema["config"]["model"]["encoder"] == "sum"
    assert {p.stem for p in tmp_path.iterdir()} == {*expected, "schema"}
    for name, values in expected.items():
        found = np.load(tmp_path / f"{name}.npy")
        np.testing.assert_array_equal(found, values)
        described = schema["files"][f"{name}.npy"]
        assert (tuple(described["shape"]), described["dtype"]) == (found.shape, str(found.dtype))
        assert len(described["columns"]) == found[0].size


def test_parquet_tables_have_named_columns(tmp_path):
    parquet = pytest.importorskip("pyarrow.parquet")
    run, given = run_of("sum"), trajectories(5)
    export_arrays(run, tmp_path, num=5, format="parquet", draw=drawn)
    table = parquet.read_table(tmp_path / "motors.parquet")
    assert table.column_names[:3] == ["motor_0.t0", "motor_1.t0", "motor_0.t1"]
    np.testing.assert_array_equal(table["motor_1.t2"], given.experience.motors[:, 2, 1])
    names = parquet.read_table(tmp_path / "displacements.parquet").column_names
    assert names == ["longitudinal", "lateral", "orientation_change"]
    # The topology report reads what is written here.
    codes = run.encode(given.experience.motors, given.experience.num_steps)
    np.testing.assert_array_equal(read_array(tmp_path / "codes.parquet"), codes)


def test_fresh_trajectories_are_simulated_and_the_seed_says_which(tmp_path):
    run = run_of("sum")
    for name, seed in (("a", 0), ("b", 0), ("c", 1)):
        # Nine sensors here, five in the network: only what the encoder sees matters.
        export_arrays(run, tmp_path / name, num=3, seed=seed)
    motors = [np.load(tmp_path / name / "motors.npy") for name in "abc"]
    assert motors[0].shape == (3, 4, 2)
    np.testing.assert_array_equal(motors[0], motors[1])
    assert not np.array_equal(motors[0], motors[2])


def test_codes_of_many_sequences_are_computed_in_parts():
    run, given = run_of("sum"), trajectories(CHUNK_SIZE + 3)
    codes = tables_of(run, given)["codes"].values
    last = given.experience[CHUNK_SIZE:]
    assert len(codes) == CHUNK_SIZE + 3
    expected = run.encode(last.motors, last.num_steps)
    np.testing.assert_allclose(codes[CHUNK_SIZE:], expected, rtol=1e-6)


def test_no_trajectories_are_refused(tmp_path):
    with pytest.raises(UserError, match="num must be at least 1, got 0"):
        export_arrays(run_of("sum"), tmp_path, num=0)


def test_parquet_without_pyarrow_says_how_to_install_it(monkeypatch):
    monkeypatch.setitem(sys.modules, "pyarrow", None)
    with pytest.raises(UserError, match=r"^pyarrow is not .* pip install 'motorspace\[table\]'"):
        trajectory_files(run_of("sum"), trajectories(2), format="parquet", origin={})
