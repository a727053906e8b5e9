"""Right words do the work, from training to the page, and say what comes next."""

import errno
import json
import os
import shutil

import numpy as np
import pytest

from motorspace._errors import UserError
from motorspace.cli.main import main
from motorspace.evaluation.prediction import CHUNK_SIZE
from motorspace.training.folder import load_config
from motorspace.training.presets import BEST
from motorspace.training.run import load_run
from tests.tables import write_table
from tests.tiny import TINY, flags

FEW = ["--num", str(CHUNK_SIZE)]
BRIEF = [*flags()[4:], "--epochs", "2"]
"""The network of that run, trained for two epochs on something else."""


@pytest.fixture(scope="module")
def run(tmp_path_factory):
    """The folder of a run, which has a space in its name."""
    folder = tmp_path_factory.mktemp("cli") / "my run"
    main(["train", "forward", *flags(), "--out", str(folder)])
    return folder


@pytest.fixture
def copied(run, tmp_path):
    """A copy of it that a test may spoil."""
    return shutil.copytree(run, tmp_path / "copy")


def printed(capsys, *words):
    """What words print on standard output, and beside it."""
    main([str(word) for word in words])
    return capsys.readouterr()


def refused(capsys, *words):
    with pytest.raises(SystemExit) as stop:
        main([str(word) for word in words])
    assert stop.value.code == 2
    return capsys.readouterr().err


def test_training_says_how_to_measure_the_run(tmp_path, capsys):
    folder = tmp_path / "my run"
    out = printed(capsys, "train", "forward", *flags(), "--out", folder).out
    assert out == f"finished: {folder}; measure it with: motorspace evaluate '{folder}'\n"
    assert load_config(folder) == TINY


def test_a_folder_is_named_after_agent_and_seed(tmp_path, capsys, monkeypatch):
    monkeypatch.chdir(tmp_path)
    printed(capsys, "train", *flags(), "--seed", "7")
    assert load_config("runs/forward-7").training.seed == 7


def test_underscores_are_hyphens(tmp_path, capsys):
    words = [word.replace("-", "_") if word.startswith("--") else word for word in flags()]
    words = [word.replace("__", "--", 1) for word in words]
    assert "--code_size" in words
    printed(capsys, "train", *words, "--out", tmp_path / "run")
    assert load_config(tmp_path / "run") == TINY


@pytest.mark.slow
def test_results_are_printed_and_kept(copied, capsys):
    shown = json.loads(printed(capsys, "evaluate", copied, *FEW, "--json").out)
    assert shown["prediction.num"] == CHUNK_SIZE and shown["prediction.error"] > 0
    assert json.loads((copied / "evaluation.json").read_text()) == shown
    table = printed(capsys, "evaluate", copied, *FEW).out
    assert f"prediction.error                 {shown['prediction.error']:.6g}" in table


def test_in_a_folder_that_cannot_be_written_results_are_printed_with_one_note(
    copied, capsys, monkeypatch
):
    def fail(_):
        raise OSError(errno.EROFS, os.strerror(errno.EROFS))

    monkeypatch.setattr("motorspace._files.os.fsync", fail)
    done = printed(capsys, "evaluate", copied, *FEW, "--json")
    assert json.loads(done.out)["prediction.error"] > 0
    (note,) = done.err.splitlines()
    assert note.startswith("motorspace: the results are not kept: ")
    assert "evaluation.json: the file cannot be written (Read-only file system)" in note
    assert not (copied / "evaluation.json").exists()


def test_a_finished_run_is_resumed_lengthened_and_not_overwritten(copied, capsys):
    words = ["train", "forward", *flags(), "--out", copied]
    assert "already holds a run; continue it with --resume" in refused(capsys, *words)
    before = (copied / "weights.safetensors").read_bytes()
    printed(capsys, *words, "--resume")
    assert (copied / "weights.safetensors").read_bytes() == before
    err = refused(capsys, *words, "--resume", "--code-size", "5", "--layout", "paper")
    assert "another configuration (different: layout, code_size)" in err
    printed(capsys, *words, "--resume", "--epochs", "121")
    assert [record["epoch"] for record in load_run(copied).log] == list(range(1, 122))


def test_resuming_where_nothing_is_says_so_and_begins(tmp_path, capsys):
    folder = tmp_path / "new"
    done = printed(capsys, "train", *flags(), "--out", folder, "--resume")
    assert done.err.startswith(f"motorspace: {folder}: there is no run to resume; a new one begins")
    assert load_config(folder) == TINY


@pytest.mark.parametrize(
    "written",
    ["--restarts 1", "--encoder lstm --code-size 4", "--code-noise 0", "--learning-rate 0.006"],
)
def test_what_is_written_wins_over_a_preset_and_the_folder_says_so(tmp_path, monkeypatch, written):
    monkeypatch.setattr("motorspace.cli.train._train", lambda config, *_: made.append(config))
    made = []
    main(["train", "forward", "--preset", "best", *written.split(), "--out", str(tmp_path / "r")])
    main(["train", "forward", *written.split(), "--preset", "best", "--out", str(tmp_path / "r")])
    first, second = (vars(config.model) | vars(config.training) for config in made)
    assert first == second
    asked = dict(zip(*[iter(written.split())] * 2, strict=True))
    asked = {name[2:].replace("-", "_"): value for name, value in asked.items()}
    for name, value in asked.items():
        assert str(first[name]) == str(type(first[name])(value))
    assert all(first[name] == value for name, value in BEST.items() if name not in asked)


def test_an_angle_is_written_in_units_of_pi_and_kept_in_radians(tmp_path, monkeypatch):
    made = []
    monkeypatch.setattr("motorspace.cli.train._train", lambda config, *_: made.append(config))
    words = ["train", "forward", "--max-rotation", "0.5", "--field-of-view", "2"]
    main([*words, "--out", str(tmp_path / "run")])
    data = made[0].as_json()["data"]
    assert data["agent"] == {"kind": "forward", "max_rotation": 0.5 * np.pi}
    assert data["sensor"]["field_of_view"] == 2 * np.pi


def test_the_structure_of_a_run_is_measured(copied, capsys, tmp_path):
    page = tmp_path / "page.html"
    shown = json.loads(printed(capsys, "topology", copied, "--out", page, "--json").out)
    assert shown["equivalence_ratio"] > 0 and all(np.isfinite(v) for v in shown.values())
    assert page.read_text().startswith("<!doctype html>")
    err = refused(capsys, "topology", copied, "--out", page, "--standard-form")
    assert "codes of the encoder 'lstm' have no standard form" in err
    assert "not from a log; leave out --data" in refused(capsys, "topology", copied, "--data", page)


@pytest.mark.slow
def test_matrices_have_a_standard_form(tmp_path, capsys):
    folder, page = tmp_path / "run", tmp_path / "page.html"
    words = ["--preset", "best", "--restarts", "1", *BRIEF, "--code-size", "6", *flags()[:4]]
    printed(capsys, "train", "forward", *words, "--out", folder)
    assert load_config(folder).model.encoder == "matrix_product"
    printed(capsys, "topology", folder, "--standard-form", "--out", page)
    assert "codes in standard form" in page.read_text()


@pytest.fixture
def files(tmp_path):
    """Codes that are a linear map of displacements, those, and the motors."""
    random = np.random.default_rng(0)
    displacements = random.normal(size=(300, 3))
    np.save(tmp_path / "codes.npy", displacements @ random.normal(size=(3, 5)))
    np.save(tmp_path / "d.npy", displacements)
    return [tmp_path / "codes.npy", tmp_path / "d.npy", "--motors", tmp_path / "d.npy"]


def test_anybodys_codes_are_measured_and_shown_as_a_page(files, tmp_path, capsys):
    page = tmp_path / "page.html"
    out = printed(capsys, "topology", *files, "--out", page, "--json").out
    assert json.loads(out)["linear_r2.longitudinal"] == pytest.approx(1.0, abs=1e-6)
    out = printed(capsys, "topology", *files, "--out", page).out
    assert out.endswith(f"open {page}\n") and "rank correlation" in out
    assert page.read_text().startswith("<!doctype html>")


def test_a_page_that_cannot_be_written_leaves_the_numbers(files, tmp_path, capsys):
    with pytest.raises(SystemExit) as stop:
        main(["topology", *map(str, files), "--out", str(tmp_path / "nowhere" / "page.html")])
    assert stop.value.code == 2
    done = capsys.readouterr()
    assert "rank correlation" in done.out
    assert "page.html: the file cannot be written" in done.err


@pytest.mark.slow
def test_several_seeds_are_trained_side_by_side(tmp_path, capsys):
    out = printed(capsys, "train", *flags(), "--seeds", "2", "--out", tmp_path / "runs").out
    first, second = (load_run(tmp_path / "runs" / f"seed{seed}") for seed in (0, 1))
    assert out.count("finished") == 2
    assert second.config.training.seed == 1
    assert first.log[-1] != second.log[-1]


def test_several_seeds_are_one_program_where_the_device_is_no_cpu(tmp_path, capsys, monkeypatch):
    monkeypatch.setattr("jax.default_backend", lambda: "gpu")
    refuse = lambda *_: pytest.fail("a process was started")  # noqa: E731
    monkeypatch.setattr("motorspace.running.processes.Processes.run", refuse)
    out = printed(capsys, "train", *flags(), "--seeds", "2", "--out", tmp_path).out
    assert out.count("finished") == 2
    assert load_run(tmp_path / "seed1").config.training.seed == 1


@pytest.fixture(scope="module")
def table(tmp_path_factory):
    return write_table(tmp_path_factory.mktemp("table") / "my robot.csv")


@pytest.fixture(scope="module")
def logged(table):
    """The folder of a run on a log."""
    folder = table.with_name("run")
    main(["train", "--data", str(table), "--horizon", "3", *BRIEF, "--out", str(folder)])
    return folder


def test_a_log_is_trained_on_and_recorded_with_its_reader(logged, table):
    data = load_config(logged).as_json()["data"]
    assert (data["kind"], data["path"], data["horizon"]) == ("logged", str(table), 3)
    assert data["reader"]["kind"] == "table" and len(data["sha256"]) == 64
    assert "layout" not in json.dumps(data)


def test_a_run_on_a_log_is_measured_on_it_and_found_again_after_a_move(logged, table, capsys):
    here = json.loads(printed(capsys, "evaluate", logged, "--json").out)
    assert here["prediction.error"] > 0 and "probe_r2.lateral" in here
    moved = table.rename(table.with_name("elsewhere.csv"))
    for command in ("evaluate", "topology"):
        err = refused(capsys, command, logged)
        assert f"{table}: the log cannot be read" in err
        assert f"give it with: motorspace {command} {logged} --data LOG" in err
    page = table.with_name("page.html")
    assert json.loads(printed(capsys, "evaluate", logged, "--data", moved, "--json").out) == here
    found = printed(capsys, "topology", logged, "--data", moved, "--out", page, "--json").out
    assert abs(json.loads(found)["rank_correlation"]) < 1
    other = write_table(table.with_name("other.csv"), rows=500)
    err = refused(capsys, "evaluate", logged, "--data", other)
    assert "other.csv: this is not the log that the run has learned from" in err
    moved.rename(table)


def test_a_log_is_described(table, capsys):
    shown = json.loads(printed(capsys, "inspect", table, "--json").out)
    assert shown["scans"] == 800


@pytest.mark.slow
def test_runs_are_compared_and_exported(copied, run, capsys, tmp_path):
    shown = json.loads(printed(capsys, "compare", copied, run, *FEW, "--json").out)
    assert shown
    printed(capsys, "export", copied, "--num", "20", "--out", tmp_path / "export")
    assert np.load(tmp_path / "export" / "codes.npy").shape == (20, 4)


@pytest.mark.filterwarnings("default")
def test_a_run_of_version_1_in_a_layout_file_is_measured_with_a_note(copied, capsys, monkeypatch):
    def warned(*_, **__):
        import warnings

        warnings.warn("config.json: the run names the layout file mine.layout", stacklevel=2)
        raise UserError("enough")

    monkeypatch.setattr("motorspace.training.folder.config_of_version_1", warned)
    path = copied / "config.json"
    path.write_text(json.dumps(json.loads(path.read_text()) | {"format_version": 1}))
    err = refused(capsys, "evaluate", copied)
    assert err.splitlines() == [
        "motorspace: config.json: the run names the layout file mine.layout",
        "motorspace: enough.",
    ]
