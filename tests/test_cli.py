"""The command line: wrong input is one sentence and exit code 2; right input does the work."""

import json
import os
import runpy
import subprocess
import sys
from pathlib import Path

import jax
import numpy as np
import pytest
from motorspace.analysis.errors import CHUNK_SIZE
from motorspace.experiments import reproduction

from motorspace import load_run
from motorspace.cli import MOST_CACHED, main
from tests.tiny import flags

ROOT = Path(__file__).parents[1]
TINY = flags()


def test_train_evaluate_and_resume(tmp_path, capsys):
    folder = str(tmp_path / "run")
    main(["train", "forward", *TINY, "--out", folder])
    assert "finished" in capsys.readouterr().out
    main(["evaluate", folder, "--num", str(CHUNK_SIZE), "--json"])
    measured = json.loads(capsys.readouterr().out)
    assert measured["errors"]["num_trajectories"] == CHUNK_SIZE
    assert measured["errors"]["model"] > 0
    main(["train", "forward", *TINY, "--out", folder, "--resume"])
    described = json.loads((tmp_path / "run" / "config.json").read_text())
    assert described["config"]["simulation"]["horizon"] == 2


def test_the_topology_of_a_run_and_of_anybodys_codes(tmp_path, capsys):
    folder, page = tmp_path / "run", tmp_path / "page.html"
    best = ["--preset", "best", "--code-size", "12"]
    main(["train", "forward", *TINY, *best, "--horizon", "4", "--out", str(folder)])
    config = load_run(folder).config.model
    assert (config.encoder, config.code_size) == ("group", 12)
    main(["topology", str(folder), "--standard-form", "--out", str(page)])
    told = capsys.readouterr().out
    assert "normalised D_topo" in told and f"open {page}" in told
    assert page.read_text().startswith("<!doctype html>")
    assert "How the structure of codes in standard form follows" in page.read_text()
    random = np.random.default_rng(0)
    displacements = random.normal(size=(300, 3))
    np.save(tmp_path / "codes.npy", displacements @ random.normal(size=(3, 5)))
    np.save(tmp_path / "d.npy", displacements)
    files = [str(tmp_path / "codes.npy"), str(tmp_path / "d.npy"), "--motors"]
    main(["topology", *files, files[1], "--out", str(page), "--json"])
    measured = json.loads(capsys.readouterr().out)
    assert measured["linear_r2.longitudinal"][0] == pytest.approx(1.0, abs=1e-6)


def test_several_seeds_are_trained_side_by_side(tmp_path, capsys):
    out = tmp_path / "runs"
    main(["train", "forward", *TINY, "--seeds", "2", "--out", str(out)])
    first, second = (load_run(out / f"seed{seed}") for seed in (0, 1))
    assert capsys.readouterr().out.count("finished") == 2
    assert second.config.training.seed == 1
    assert first.log[-1] != second.log[-1]


def test_several_seeds_are_one_program_where_the_device_is_no_cpu(tmp_path, capsys, monkeypatch):
    monkeypatch.setattr("jax.default_backend", lambda: "gpu")
    command = ["train", "forward", *TINY, "--seeds", "2", "--out", str(tmp_path)]
    monkeypatch.setattr(reproduction, "_pool", lambda _: pytest.fail("a process was started"))
    main(command)
    assert capsys.readouterr().out.count("finished") == 2
    assert load_run(tmp_path / "seed1").config.training.seed == 1


def test_train_on_a_table(tmp_path, capsys):
    table = tmp_path / "robot.csv"
    rows = [f"{t},{0.1 * (t % 3)},{t % 7}" for t in range(300)]
    table.write_text("\n".join(["time,motor_a,sensor_a", *rows]))
    main(["train", "forward", "--data", str(table), *TINY, "--out", str(tmp_path / "run")])
    main(["evaluate", str(tmp_path / "run"), "--data", str(table), "--json"])
    measured = json.loads(capsys.readouterr().out.splitlines()[-1])
    assert 0 < measured["error"] < 100 * measured["persistence"]
    main(["inspect", str(table), "--json"])
    out = capsys.readouterr().out.splitlines()[-1]
    assert json.loads(out)["scans"] == 300


WRONG = {
    "layout": (["train", "forward", "--layout", "nowhere"], "there is no layout 'nowhere'"),
    "horizon": (["train", "forward", "--horizon", "0"], "horizon must be at least 1, not 0"),
    "range": (["train", "forward", "--max-range", "-1"], "max_range must be above 0, not -1.0"),
    "rotation": (["train", "forward", "--max-rotation", "0"], "max_rotation must be above 0"),
    "epochs": (["train", "forward", "--epochs", "0"], "0 epochs of 2000 trajectories"),
    "run": (["evaluate", "nowhere"], "there is no run here; give a folder"),
    "log": (["inspect", "nowhere.log"], "the log cannot be read"),
    "seeds": (["train", "forward", "--seeds", "0"], "cannot train 0 seeds"),
    "num": (["evaluate", "nowhere", "--num", "0"], "cannot measure on 0 trajectories"),
    "array": (["topology", "codes.npy", "d.npy"], "codes.npy: there is no such file"),
    "form": (["topology", "codes.npy", "d.npy", "--standard-form"], "measured as they are"),
    "preset": (["topology", "nowhere"], "there is no run here; give a folder"),
}


@pytest.mark.parametrize("case", WRONG)
def test_wrong_input_is_one_sentence_and_exit_code_2(tmp_path, monkeypatch, capsys, case):
    monkeypatch.chdir(tmp_path)
    arguments, message = WRONG[case]
    with pytest.raises(SystemExit) as stop:
        main(arguments)
    assert stop.value.code == 2
    told = capsys.readouterr().err
    assert message in told and "Traceback" not in told
    assert len(told.strip().splitlines()) == 1


@pytest.mark.parametrize(
    "arguments",
    [
        ["train", "forward", "--rotation", "3"],
        ["train", "forward", "--max-rotation", "much"],
        ["fly"],
    ],
)
def test_wrong_flags_end_with_exit_code_2(arguments, capsys):
    with pytest.raises(SystemExit) as stop:
        main(arguments)
    assert stop.value.code == 2
    assert "Traceback" not in capsys.readouterr().err


@pytest.mark.parametrize("script", sorted((ROOT / "examples").glob("*.py")), ids=lambda p: p.stem)
def test_examples_run(script, capsys):
    runpy.run_path(str(script), run_name="__main__")
    assert capsys.readouterr().out


@pytest.mark.parametrize("device", ["quantum", "cuda"])
def test_a_device_that_is_missing_is_told_with_those_there_are(device):
    if device == "cuda" and jax.default_backend() == "gpu":
        pytest.skip("this machine has one")
    done = subprocess.run(
        [sys.executable, "-m", "motorspace", "train", "lattice"],
        env=os.environ | {"JAX_PLATFORMS": device},
        capture_output=True,
        text=True,
        check=False,
    )
    assert done.returncode == 2
    assert done.stderr.splitlines()[-1].startswith(
        f"motorspace: JAX_PLATFORMS: there is no device '{device}' here; choose from: cpu"
    )
    assert "Traceback" not in done.stderr


@pytest.mark.parametrize("named", [False, True])
def test_workers_share_the_bounded_cache_and_leave_a_named_one_alone(tmp_path, named):
    worker = """
import jax
print(jax.config.jax_compilation_cache_dir, jax.config.jax_compilation_cache_max_size)
"""
    parent = f"""
import subprocess, sys
from motorspace.cli import keep_compiled_programs
keep_compiled_programs()
{worker}
subprocess.run([sys.executable, "-c", {worker!r}], check=True)
"""
    environment = {k: v for k, v in os.environ.items() if not k.startswith("JAX_COMPILATION")}
    environment |= {"XDG_CACHE_HOME": str(tmp_path), "PYTHONUNBUFFERED": "1"}
    if named:
        environment["JAX_COMPILATION_CACHE_DIR"] = "mine"
    done = subprocess.run(
        [sys.executable, "-c", parent], env=environment, capture_output=True, text=True, check=True
    )
    expected = "mine -1" if named else f"{tmp_path}/motorspace/compiled {MOST_CACHED}"
    assert done.stdout.splitlines() == [expected, expected]
