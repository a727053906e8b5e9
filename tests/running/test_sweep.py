"""A sweep is a few lines of TOML; what they say wrongly is named with file and key."""

import math
import re
import subprocess
import sys
from pathlib import Path

import pytest

from motorspace._errors import UserError
from motorspace.running import sweep_results
from motorspace.running.executors import OneProgram, run_jobs
from motorspace.running.jobs import cell
from motorspace.running.store import append_result, result_of
from motorspace.running.sweep import Trainer, jobs_of, run_sweep
from motorspace.running.sweep_spec import read_sweep, sweep_of_flags
from tests.running.toy import configured, execute, flags

TRAINER = Trainer(configured, flags, {"errors": "toy:errors", "structure": "toy:structure"})

TABLE1 = """
agent = ["forward", "holonomic"]
seeds = 3
[grid]
max-rotation = [0.2, 0.4, 0.6, 0.8, 1.0, 1.2]
"""


@pytest.fixture
def sweep_of(tmp_path):
    def read(content, name="table1"):
        path = tmp_path / f"{name}.toml"
        path.write_text(content)
        return read_sweep(path)

    return read


def settings(sweep):
    return [dict(job.cell) for job in jobs_of(sweep, TRAINER)]


def test_the_papers_table_is_a_sweep_of_a_few_lines(sweep_of):
    jobs = jobs_of(sweep_of(TABLE1), TRAINER)
    assert len(jobs) == len({job.key for job in jobs}) == 36
    assert {job.seed for job in jobs[:12]} == {0}, "one seed of every cell before the next seed"
    assert jobs[0].cell == cell({"agent": "forward", "max-rotation": 0.2})
    assert jobs[0].config.max_rotation == 0.2 and jobs[0].config.agent == "forward"
    assert {(job.study, job.measure) for job in jobs} == {("table1", "toy:errors")}


def test_grid_and_random_values_are_combined_and_fixed_flags_stand_in_no_cell(sweep_of):
    sweep = sweep_of(
        'preset = "best"\nseeds = [4, 7]\nsamples = 3\nmeasure = "structure"\n'
        "[fixed]\nepochs = 9\n[grid]\nsense-head = [true, false]\nencoder = ['lstm', 'gru']\n"
        "[random]\nhidden-size = {uniform = [1, 100]}\nmax-rotation = {log-uniform = [1, 2]}\n"
    )
    jobs = jobs_of(sweep, TRAINER)
    assert len(jobs) == 2 * 3 * 4
    assert {job.seed for job in jobs} == {4, 7} and jobs[0].measure == "toy:structure"
    for job in jobs:
        assert job.config.training.epochs == 9 and job.config.preset == "best"
        assert job.cell == cell(
            {
                "agent": "forward",
                "encoder": job.config.encoder,
                "hidden-size": job.config.hidden_size,
                "max-rotation": job.config.max_rotation,
                "sense-head": job.config.sense_head,
            }
        )
    assert {type(job.config.hidden_size) for job in jobs} == {int}
    assert {type(job.config.max_rotation) for job in jobs} == {float}, "as its default is"
    assert all(1 <= job.config.max_rotation <= 2 for job in jobs)


def test_more_samples_or_other_random_flags_keep_the_values_of_before(sweep_of):
    content = "samples = {}\n[random]\nmax-rotation = {{uniform = [0.1, 2.0]}}\n{}"
    few = settings(sweep_of(content.format(2, "")))[:2]
    many = settings(sweep_of(content.format(4, "encoder = {choice = ['lstm', 'gru']}")))[:2]
    assert [c["max-rotation"] for c in few] == [c["max-rotation"] for c in many]
    assert few[0] != few[1]
    other = settings(sweep_of("random-seed = 1\n" + content.format(2, "")))[:2]
    assert other != few


def test_random_values_fill_their_range(sweep_of):
    content = (
        "samples = 300\nseeds = 1\n[random]\nmax-rotation = {log-uniform = [0.01, 1.0]}\n"
        "hidden-size = {uniform = [1, 4]}\nencoder = {choice = ['lstm', 'gru']}"
    )
    found = settings(sweep_of(content))
    assert sum(c["max-rotation"] < 0.1 for c in found) == pytest.approx(150, abs=30)
    for name, values in (("hidden-size", {1, 2, 3, 4}), ("encoder", {"lstm", "gru"})):
        assert {c[name] for c in found} == values


def test_flags_say_what_a_file_says(sweep_of):
    ours = sweep_of_flags(
        "table1",
        agent=["forward"],
        seeds=2,
        samples=2,
        grid=["max-rotation=0.2,0.4", "encoder=lstm,gru", "sense-head=true"],
        random=["hidden-size=uniform:1,9"],
        fixed=["epochs=5"],
        preset=None,
    )
    theirs = sweep_of(
        "agent = 'forward'\nseeds = 2\nsamples = 2\n[fixed]\nepochs = 5\n[grid]\n"
        "max-rotation = [0.2, 0.4]\nencoder = ['lstm', 'gru']\nsense-head = [true]\n"
        "[random]\nhidden-size = {uniform = [1, 9]}"
    )
    assert jobs_of(ours, TRAINER) == jobs_of(theirs, TRAINER)
    with pytest.raises(UserError, match="--grid: 'epochs' is not FLAG=VALUES; see --grid max"):
        sweep_of_flags("x", grid=["epochs"])


@pytest.mark.parametrize(
    ("content", "message"),
    [
        (
            "[grid]\nmax-rotatoin = [1]",
            r"grid.max-rotatoin: .*no flag --max-rotatoin \(perhaps max-",
        ),
        ("[random]\nx = {choice = [1]}", "samples: nobody says how many random values; write sam"),
        (
            "samples = 1\n[random]\nx = {choice = [1]}",
            "random.x: the agent 'forward' has no flag --x",
        ),
        (
            "[fixed]\nepoch = 1",
            r"fixed.epoch: .*\(perhaps epochs\); see motorspace train forward --h",
        ),
        (
            "agents = 'forward'",
            r"agents: a sweep has no key 'agents' \(perhaps agent\); the keys are",
        ),
        ("agent = 'backward'", "agent: there is no agent named 'backward'"),
        ("agent = []", r"agent: this must be a list of values, not \[\]"),
        (
            "measure = 'error'",
            r"measure: there is no measure 'error' \(perhaps errors\); choose one o",
        ),
        ("[grid]\nmax-rotation = 1.0", "grid.max-rotation: this must be a list of values, not 1.0"),
        ("[grid]\nmax-rotation = []", "grid.max-rotation: this must be a list of values"),
        ("[grid]\nmax-rotation = [[1]]", r"grid.max-rotation: \[1\] cannot stand here"),
        ("[grid]\nmax-rotation = [-1]", "max-rotation=-1: max_rotation must be above 0, got -1"),
        ("grid = 3", "grid: this is no table"),
        ("[grid]\nseed = [1]", "grid.seed: 'seed' belongs to seeds, and to it alone"),
        (
            "[fixed]\nencoder = 'x'\n[grid]\nencoder = ['y']",
            "grid.encoder: 'encoder' belongs to fixed",
        ),
        ("preset = 'best'\n[grid]\npreset = ['best']", "'preset' belongs to preset"),
        ("[fixed]\nepochs = [1, 2]", "fixed.epochs: this must be one value"),
        ("seeds = 0", "seeds: this must be a whole number from 1, not 0"),
        ("seeds = [0.5]", r"seeds: \[0.5\] is neither a number nor a list of seeds"),
        ("seeds = 'two'", "seeds: 'two' is neither"),
        ("samples = 5", r"samples: nothing is random here; say what is in a table \[random\]"),
        (
            "samples=2\n[random]\nx = {normal = [0, 1]}",
            "random.x: .* is no distribution; write x = ",
        ),
        (
            "samples=2\n[random]\nx = {uniform = [2, 1]}",
            r"random.x: \[2, 1\] are not a lower and a hi",
        ),
        (
            "samples=2\n[random]\nx = {log-uniform = [0, 1]}",
            "0 has no logarithm; give bounds above 0",
        ),
        ("import = ['os']", "import: a file cannot say which code to run; name the module on the"),
        ("[fixed]\nimport = 'os'", "fixed.import: 'import' belongs to --import, and to it alone"),
        ("name = '../x'", "name: '../x' is no name of a file"),
        ("name = 'configs'", "name: 'configs' is the file of all configurations"),
        ("metrics = 3", "metrics: this must be a list of values, not 3"),
        ("seeds = ", "this is no sweep"),
    ],
)
def test_what_a_sweep_cannot_be_is_named_with_file_and_key(sweep_of, content, message):
    with pytest.raises(UserError, match=r"table1\.toml.*" + message):
        jobs_of(sweep_of(content), TRAINER)


DOCS = Path(__file__).parents[2] / "docs" / "how-to" / "sweep.md"


def test_the_sweeps_in_the_docs_can_be_run(sweep_of):
    examples = re.findall("```toml\n(.*?)```", DOCS.read_text(), re.DOTALL)
    assert [len(jobs_of(sweep_of(content), TRAINER)) for content in examples] == [36, 60]


def test_reading_a_sweep_loads_nothing_heavy():
    code = (
        "import sys, motorspace; before = {*sys.modules}\n"
        "import motorspace.running.sweep_spec, motorspace.running.sweep_results\n"
        "import motorspace.running.processes, motorspace.running.ray_cluster\n"
        "heavy = {'jax', 'equinox', 'optax', 'numpy', 'scipy', 'ray'}\n"
        "sys.exit(', '.join({*sys.modules} - before & heavy) or 0)"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr


def test_a_sweep_that_is_not_there_is_named(tmp_path):
    with pytest.raises(UserError, match=r"none.toml: the sweep cannot be read \(No such file"):
        read_sweep(tmp_path / "none.toml")


def test_a_sweep_runs_and_its_folder_says_what_it_is(tmp_path, sweep_of):
    sweep = sweep_of("seeds = 2\n[grid]\nmax-rotation = [0.5, 0.2]\n[fixed]\nepochs = 2", "mine")
    jobs = jobs_of(sweep, TRAINER)
    assert sweep_results.status(jobs, tmp_path) == (
        "agent=forward max-rotation=0.5: 2 waiting\n"
        "agent=forward max-rotation=0.2: 2 waiting\nall: 4 waiting"
    )
    with pytest.raises(UserError, match="no run of this sweep is finished"):
        sweep_results.table(sweep_results.rows(jobs, tmp_path))
    run_sweep(sweep, TRAINER, tmp_path, execute, executor=OneProgram())
    assert jobs_of(read_sweep(tmp_path / "mine"), TRAINER) == jobs
    assert sweep_results.status(jobs, tmp_path).endswith("all: 4 finished")
    found = sweep_results.rows(jobs, tmp_path)
    # Two seeds, one third apart: the interval is 12.7 standard errors of 1/6.
    assert sweep_results.table(found).splitlines() == [
        "| agent   | max-rotation | seeds | value       | epochs |",
        "| ------- | ------------ | ----- | ----------- | ------ |",
        "| forward | 0.5          | 2     | 5.167 ± 2.1 | 2 ± 0  |",
        "| forward | 0.2          | 2     | 2.167 ± 2.1 | 2 ± 0  |",
    ]
    assert sweep_results.table(found, ["value"]).endswith(
        "1 more measures: name them with --metrics"
    )
    assert dict(sweep_results.best(found, "value").cell)["max-rotation"] == 0.2
    for perfect in (5.2, math.inf):
        assert dict(sweep_results.best(found, "value", perfect=perfect).cell)["max-rotation"] == 0.5
    with pytest.raises(UserError, match=r"no run has measured 'valu' \(perhaps value\)"):
        sweep_results.best(found, "valu")


def test_status_tells_what_has_failed_begun_or_become_stale(tmp_path, sweep_of):
    sweep = sweep_of("seeds = 3\n[fixed]\nfails = 'bug'")
    failed, begun, waiting = jobs_of(sweep, TRAINER)
    with pytest.raises(UserError, match="1 of 1 runs have failed"):
        run_jobs([failed], tmp_path, execute, executor=OneProgram())
    (tmp_path / "table1" / begun.folder).mkdir()
    (old,) = jobs_of(sweep_of("seeds = [2]\n[fixed]\nepochs = 5"), TRAINER)
    stale = old.config.hash()
    append_result(tmp_path, "table1", result_of(old, {"value": math.nan}), old.config)
    assert sweep_results.status([failed, begun, waiting], tmp_path).splitlines() == [
        "agent=forward: 1 begun, 1 failed, 1 waiting",
        "failed: agent=forward seed=0: ZeroDivisionError: it is broken",
        f"stale, of another configuration: agent=forward seed=2 (configuration {stale})",
        "all: 1 begun, 1 failed, 1 waiting",
    ]
    assert sweep_results.rows([waiting], tmp_path) == []
    (row,) = sweep_results.rows([old], tmp_path)
    assert sweep_results.table([row]).endswith("| undefined |")
