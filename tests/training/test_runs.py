"""A run's folder: resumable to the same bytes, one process at a time, never half-written."""

import errno
import json
import os
import shutil
import signal
import subprocess
import sys
import time
from dataclasses import replace
from pathlib import Path

import jax
import numpy as np
import pytest

from motorspace._errors import UserError
from motorspace._files import PART, locked
from motorspace.evaluation.evaluate import evaluate
from motorspace.evaluation.prediction import CHUNK_SIZE
from motorspace.training.config import RunConfig
from motorspace.training.folder import load_config
from motorspace.training.run import Run, load_run, train, train_together
from tests.tiny import TINY


def trained(folder: Path, config: RunConfig = TINY, **options: object) -> Run:
    return train(config, folder=folder, **options)


def test_a_finished_run_is_read_back_as_it_was(tmp_path):
    run = trained(tmp_path)
    again = load_run(tmp_path)
    assert again.config == TINY
    motors = np.ones((5, 2, 2), np.float32)
    np.testing.assert_array_equal(run.encode(motors), again.encode(motors))
    assert [record["epoch"] for record in again.log] == list(range(1, 121))


def test_a_stopped_run_resumes_to_the_same_bytes(tmp_path):
    def stop(record: dict[str, float]) -> None:
        if record["epoch"] == 3:
            raise KeyboardInterrupt

    trained(tmp_path / "whole")
    with pytest.raises(KeyboardInterrupt):
        trained(tmp_path / "parted", callback=stop)
    trained(tmp_path / "parted", resume=True)
    for name in ("weights.safetensors", "log.jsonl", "config.json"):
        assert (tmp_path / "whole" / name).read_bytes() == (tmp_path / "parted" / name).read_bytes()


SCRIPT = """
import sys
from pathlib import Path
from tests.training.test_runs import trained
from motorspace.training import run
run.CHECKPOINT_SECONDS = 0.0
trained(Path(sys.argv[1]), resume=True)
"""


def test_a_killed_run_resumes_to_the_same_bytes(tmp_path):
    root = Path(__file__).parents[2]
    environment = os.environ | {"PYTHONPATH": str(root)}
    parted, whole = tmp_path / "parted", tmp_path / "whole"
    command = [sys.executable, "-c", SCRIPT, str(parted)]
    for kill_at in (2, 60):
        process = subprocess.Popen(command, env=environment, cwd=root)
        deadline = time.monotonic() + 120
        while process.poll() is None and time.monotonic() < deadline:
            log = parted / "log.jsonl"
            if log.exists() and len(log.read_text().splitlines()) >= kill_at:
                process.send_signal(signal.SIGKILL)
                break
            time.sleep(0.002)
        assert process.wait() == -signal.SIGKILL
    (parted / f".weights.safetensors.1{PART}").write_bytes(b"half of it")
    (parted / "mine.part").write_bytes(b"of the user")
    subprocess.run(command, env=environment, cwd=root, check=True)
    trained(whole)
    for name in ("weights.safetensors", "log.jsonl"):
        assert (parted / name).read_bytes() == (whole / name).read_bytes()
    assert not list(parted.glob(f".*{PART}"))
    assert (parted / "mine.part").read_bytes() == b"of the user"


def test_two_processes_do_not_train_into_one_folder(tmp_path):
    with (
        locked(tmp_path),
        pytest.raises(UserError, match="another process is training in this folder"),
    ):
        trained(tmp_path)


def test_a_folder_that_holds_a_run_is_not_overwritten(tmp_path):
    trained(tmp_path)
    before = (tmp_path / "weights.safetensors").read_bytes()
    with pytest.raises(UserError, match="already holds a run; continue it with --resume"):
        trained(tmp_path)
    other = replace(TINY, training=replace(TINY.training, seed=7))
    with pytest.raises(UserError, match=r"another configuration \(different: seed\)"):
        trained(tmp_path, other, resume=True)
    assert (tmp_path / "weights.safetensors").read_bytes() == before


def test_a_run_from_before_a_setting_existed_is_continued(tmp_path):
    trained(tmp_path)
    path = tmp_path / "config.json"
    described = json.loads(path.read_text())
    assert described["config"]["training"].pop("isometry_weight") == 0.0
    path.write_text(json.dumps(described))
    assert trained(tmp_path, resume=True).config == TINY
    other = replace(TINY, training=replace(TINY.training, isometry_weight=1.0))
    with pytest.raises(UserError, match=r"another configuration \(different: isometry_weight\)"):
        trained(tmp_path, other, resume=True)


SEEDS = [replace(TINY, training=replace(TINY.training, seed=seed)) for seed in (0, 5)]


def test_seeds_in_one_program_are_trained_as_each_alone_would_be(tmp_path):
    folders = [tmp_path / "first", tmp_path / "second"]
    together = train_together(SEEDS, folders)
    motors = np.ones((5, 2, 2), np.float32)
    for config, folder, run in zip(SEEDS, folders, together, strict=True):
        alone = trained(tmp_path / "alone" / folder.name, config)
        np.testing.assert_allclose(run.encode(motors), alone.encode(motors), atol=1e-6)
        for record, expected in zip(run.log, alone.log, strict=True):
            assert record == pytest.approx(expected, rel=1e-4)
        assert load_run(folder).config == config


def test_in_one_program_a_seed_that_is_behind_catches_up(tmp_path):
    def stop(record: dict[str, float]) -> None:
        if record["epoch"] == 4:
            raise KeyboardInterrupt

    whole = [tmp_path / "whole" / name for name in "ab"]
    parted = [tmp_path / "parted" / name for name in "ab"]
    train_together(SEEDS, whole)
    with pytest.raises(KeyboardInterrupt):
        trained(parted[0], callback=stop)
    train_together(SEEDS, parted, resume=True)
    for one, other in zip(whole, parted, strict=True):
        ours, theirs = load_run(one), load_run(other)
        assert [record["epoch"] for record in theirs.log] == list(range(1, 121))
        assert theirs.log[-1] == pytest.approx(ours.log[-1], rel=1e-4)


@pytest.mark.slow
def test_a_loss_that_is_not_finite_stops_all_seeds_and_keeps_what_was_good(tmp_path):
    broken = [
        replace(config, training=replace(config.training, learning_rate=1e30)) for config in SEEDS
    ]
    folders = [tmp_path / "first", tmp_path / "second"]
    with pytest.raises(UserError, match="no longer finite"):
        train_together(broken, folders)
    assert (folders[1] / "checkpoint.safetensors").exists()
    assert not (folders[0] / "weights.safetensors").exists()


def test_a_finished_run_is_lengthened_and_keeps_what_it_has_learned(tmp_path):
    short = replace(TINY, training=replace(TINY.training, epochs=2))
    first = trained(tmp_path, short)
    longer = trained(tmp_path, resume=True)
    assert longer.log[:2] == first.log
    assert [record["epoch"] for record in longer.log] == list(range(1, 121))
    again = load_run(tmp_path)
    assert again.config == TINY and again.log == longer.log
    with pytest.raises(UserError, match=r"another configuration \(different: epochs\)"):
        trained(tmp_path, short, resume=True)


def test_a_longer_run_of_another_configuration_is_refused(tmp_path):
    trained(tmp_path)
    training = replace(TINY.training, epochs=121, learning_rate=1e-3)
    with pytest.raises(UserError, match=r"\(different: epochs, learning_rate\)"):
        trained(tmp_path, replace(TINY, training=training), resume=True)


def test_resuming_where_nothing_is_begins_a_run(tmp_path):
    assert len(trained(tmp_path / "new", resume=True).log) == 120


def test_strings_and_paths_are_folders_alike(tmp_path):
    run = train(TINY, folder=str(tmp_path / "run"))
    assert load_run(str(tmp_path / "run")).log == run.log
    assert load_config(str(tmp_path / "run")) == TINY


OWN = "bounds 0 0 10 10\nwall 4 0 4 3\n"


@pytest.fixture(scope="module")
def own_layout(tmp_path_factory):
    """A run in a layout of one's own, and the layout's file."""
    place = tmp_path_factory.mktemp("own")
    layout = place / "mine.layout"
    layout.write_text(OWN)
    config = replace(TINY, data=replace(TINY.data, layout=str(layout)))
    return layout, place / "run", trained(place / "run", config)


def test_a_run_keeps_the_content_of_its_layout(own_layout, tmp_path, monkeypatch):
    layout, folder, run = own_layout
    before = dict(evaluate(run, num=CHUNK_SIZE))
    shutil.copytree(folder, tmp_path / "moved")
    layout.write_text("bounds 0 0 3 3\n")
    monkeypatch.chdir(tmp_path)
    assert dict(evaluate(load_run("moved"), num=CHUNK_SIZE)) == before
    layout.unlink()
    assert dict(evaluate(load_run(folder), num=CHUNK_SIZE)) == before
    config = replace(TINY, data=replace(TINY.data, layout=OWN))
    assert trained(folder, config, resume=True).log == run.log


def test_a_run_is_not_resumed_in_a_layout_that_has_changed(own_layout):
    layout, folder, run = own_layout
    layout.write_text("bounds 0 0 10 10\nwall 4 0 4 4\n")
    config = replace(TINY, data=replace(TINY.data, layout=str(layout)))
    with pytest.raises(UserError, match=r"another configuration \(different: layout\)"):
        trained(folder, config, resume=True)
    assert load_run(folder).config == run.config


def failing_after(calls, code):
    """`os.fsync`, which fails once it has been called so often."""
    left = iter(range(calls))

    def fsync(handle):
        if next(left, None) is None:
            raise OSError(code, os.strerror(code))

    return fsync


@pytest.mark.parametrize("calls", [0, 1, 2, 3])
def test_a_full_disk_is_one_sentence_and_room_lets_the_run_go_on(tmp_path, monkeypatch, calls):
    with monkeypatch.context() as patch:
        patch.setattr("motorspace._files.os.fsync", failing_after(calls, errno.ENOSPC))
        with pytest.raises(UserError, match=r"cannot be written \(No space left on device\)"):
            trained(tmp_path)
    with pytest.raises(UserError, match=r"there is no run here|this run is not finished"):
        load_run(tmp_path)
    assert not list(tmp_path.glob(f".*{PART}"))
    whole = trained(tmp_path, resume=True)
    assert [record["epoch"] for record in whole.log] == list(range(1, 121))


def test_a_folder_that_cannot_be_written_is_one_sentence(tmp_path):
    (tmp_path / "file").write_text("")
    with pytest.raises(UserError, match=r"the folder cannot be written.*; choose another folder"):
        trained(tmp_path / "file")


def test_double_precision_is_refused_before_anything_is_written(tmp_path):
    trained(tmp_path / "run")
    with jax.enable_x64(True):
        for act in (lambda: trained(tmp_path / "new"), lambda: load_run(tmp_path / "run")):
            with pytest.raises(UserError, match=r"double precision .*; switch it off"):
                act()
    assert not (tmp_path / "new").exists()


def test_a_run_whose_class_is_not_there_says_so_and_imports_nothing(tmp_path):
    trained(tmp_path)
    path = tmp_path / "config.json"
    described = json.loads(path.read_text())
    for part, kind in (("agent", "crab"), ("sensor", "nose")):
        broken = json.loads(json.dumps(described))
        broken["config"]["data"][part]["kind"] = kind
        path.write_text(json.dumps(broken))
        with pytest.raises(UserError, match=rf"config\.json: there is no {part} named '{kind}'"):
            load_run(tmp_path)
    described["config"]["model"]["encoder"] = "antigravity"
    path.write_text(json.dumps(described))
    with pytest.raises(UserError, match=r"no encoder named 'antigravity'.*import the module that"):
        load_run(tmp_path)
    assert "antigravity" not in sys.modules


@pytest.mark.parametrize("keep", [0, 10, 500])
def test_truncated_weights_are_refused(tmp_path, keep):
    trained(tmp_path)
    path = tmp_path / "weights.safetensors"
    path.write_bytes(path.read_bytes()[:keep])
    with pytest.raises(UserError, match=r"weights\.safetensors: the file is cut off or damaged"):
        load_run(tmp_path)


def test_a_broken_configuration_is_refused(tmp_path):
    trained(tmp_path)
    path = tmp_path / "config.json"
    described = json.loads(path.read_text())
    described["config"]["training"]["epoch"] = 3
    path.write_text(json.dumps(described))
    with pytest.raises(UserError, match="of another version"):
        load_run(tmp_path)
    path.write_text("{")
    with pytest.raises(UserError, match="configuration cannot be read"):
        load_run(tmp_path)
    with pytest.raises(UserError, match="there is no run here"):
        load_run(tmp_path / "nowhere")


def test_an_unfinished_run_is_not_loaded(tmp_path):
    trained(tmp_path)
    (tmp_path / "weights.safetensors").unlink()
    with pytest.raises(UserError, match="this run is not finished; continue it with --resume"):
        load_run(tmp_path)


def test_codes_that_do_not_vary_are_reported_as_collapsed(tmp_path):
    run = trained(tmp_path)
    assert not run.collapsed
    assert replace(run, log=({**run.log[-1], "code_variance": 1e-9},)).collapsed
