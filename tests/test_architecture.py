"""The data flows one way, light modules load nothing heavy, and rooms keep their secrets."""

import ast
import shutil
import subprocess
import sys
import tomllib
from pathlib import Path

import pytest

ROOT = Path(__file__).parent.parent
PACKAGE = ROOT / "motorspace"
LINT = Path(sys.executable).with_name("lint-imports")

HEAVY = (
    "jax",
    "equinox",
    "optax",
    "matplotlib",
    "sklearn",
    "scipy",
    "gymnasium",
    "pyarrow",
    "safetensors",
    "rich",
    "plotly",
    "ray",
)


def lint(folder):
    return subprocess.run(
        [LINT, "--no-cache"],
        cwd=folder,
        env={"PYTHONPATH": str(folder)},
        capture_output=True,
        text=True,
        check=False,
    )


@pytest.fixture
def copy(tmp_path):
    """A copy of the package that a test may spoil."""
    ignore = shutil.ignore_patterns("__pycache__")
    shutil.copytree(PACKAGE, tmp_path / "motorspace", ignore=ignore)
    shutil.copy(ROOT / "pyproject.toml", tmp_path)
    return tmp_path


def test_the_contract_holds(copy):
    done = lint(copy)
    assert done.returncode == 0, done.stdout + done.stderr


@pytest.mark.parametrize(
    ("module", "forbidden"),
    [
        ("worlds/walls.py", "motorspace.trajectories"),
        ("trajectories/sampling.py", "motorspace.training"),
        ("analysis/probes.py", "motorspace.training.run"),
        ("recordings/windows.py", "motorspace.models"),
        ("models/losses.py", "motorspace.training"),
        ("training/fit.py", "motorspace.evaluation"),
        ("evaluation/evaluate.py", "motorspace.studies"),
        ("environments/core.py", "motorspace.running"),
        ("_types.py", "motorspace.worlds"),
    ],
)
def test_an_import_against_the_flow_is_found(copy, module, forbidden):
    path = copy / "motorspace" / module
    path.write_text(path.read_text() + f"\nimport {forbidden}\n")
    done = lint(copy)
    assert done.returncode == 1
    assert forbidden in done.stdout, done.stdout + done.stderr


def test_every_room_has_its_place_in_the_contract():
    settings = tomllib.loads((ROOT / "pyproject.toml").read_text())
    (contract,) = settings["tool"]["importlinter"]["contracts"]
    layers = " ".join(contract["layers"]).replace("(", "").replace(")", "")
    named = {word.removeprefix("motorspace.") for word in layers.split() if len(word) > 1}
    rooms = {p.parent.name for p in PACKAGE.glob("*/__init__.py")}
    modules = {p.stem for p in PACKAGE.glob("*.py")} - {"__init__", "_forks"}
    assert rooms | modules == named


def modules():
    return sorted(PACKAGE.rglob("*.py"))


def test_what_is_private_to_a_module_is_used_there_alone():
    taken = [
        f"{path.relative_to(ROOT)}: {node.module}.{name.name}"
        for path in modules()
        for node in ast.walk(ast.parse(path.read_text()))
        if isinstance(node, ast.ImportFrom) and (node.module or "").startswith("motorspace")
        for name in node.names
        if name.name.startswith("_") and not (PACKAGE / f"{name.name}.py").exists()
    ]
    assert not taken


def test_nobody_asks_for_the_class_of_an_agent_or_sensor():
    """They say themselves what they can do; see `AbstractAgent` and `AbstractSensor`."""
    names = {"ForwardAgent", "HolonomicAgent", "LatticeAgent", "RangeFan", "NodeIndex"}
    asked = [
        f"{path.relative_to(ROOT)}:{node.lineno}"
        for path in modules()
        for node in ast.walk(ast.parse(path.read_text()))
        if isinstance(node, ast.Call)
        and isinstance(node.func, ast.Name)
        and node.func.id in ("isinstance", "issubclass")
        and names & {n.id for n in ast.walk(node) if isinstance(n, ast.Name)}
    ]
    assert not asked


def test_no_module_is_longer_than_a_newcomer_can_read():
    lengths = {str(p.relative_to(ROOT)): len(p.read_text().splitlines()) for p in modules()}
    assert {name: n for name, n in lengths.items() if n > 300} == {}


def heavy_after(code, cwd, *arguments):
    """Which heavy packages a Python process has loaded once it has run some code."""
    report = f"import sys\ntry:\n    {code}\nexcept SystemExit:\n    pass\n" + (
        f"print('LOADED', *(name for name in {HEAVY} if name in sys.modules))"
    )
    done = subprocess.run(
        [sys.executable, "-c", report, *arguments],
        cwd=cwd,
        env={"PYTHONPATH": str(ROOT), "PATH": ""},
        capture_output=True,
        text=True,
        check=False,
    )
    assert "Traceback" not in done.stderr, done.stderr
    last = done.stdout.splitlines()[-1]
    assert last.startswith("LOADED"), done.stdout + done.stderr
    return last.removeprefix("LOADED").split()


LIGHT = (
    "motorspace",
    "motorspace._errors",
    "motorspace._files",
    "motorspace._kinds",
    "motorspace.worlds.catalog",
    "motorspace.worlds.layouts",
    "motorspace.models.config",
    "motorspace.navigation.config",
    "motorspace.training.config",
    "motorspace.training.data",
    "motorspace.training.folder",
    "motorspace.training.settings",
    "motorspace.recordings.catalog",
    "motorspace.running.executors",
    "motorspace.running.store",
    "motorspace.running.sweep",
    "motorspace.studies.study",
    "motorspace.cli.main",
)


def test_light_modules_load_nothing_heavy(tmp_path):
    assert heavy_after(f"import {', '.join(LIGHT)}", tmp_path) == []


WORDS = {
    "help": "--help",
    "version": "--version",
    "an unknown command": "swep --help",
    "help of train": "train --help",
    "help of evaluate": "evaluate --help",
    "help of topology": "topology --help",
    "help of inspect": "inspect --help",
    "help of compare": "compare --help",
    "help of export": "export --help",
    "help of demo": "demo --help",
    "help of reproduce": "reproduce --help",
    "help of sweep": "sweep --help",
    "help of navigate": "navigate --help",
    "help of an action of navigate": "navigate train --help",
    "completion": "completion bash",
    "a wrong flag": "train forward --rotation 3",
    "a flag of another agent": "train lattice --max-rotation 1",
    "a wrong value": "train forward --epochs much",
    "a value out of range": "train forward --epochs 0",
    "a wrong layout": "train forward --layout nowhere",
    "a wrong agent": "train crab",
    "a missing log": "train --data nowhere",
    "a file that is no log": "train --data plain.txt",
    "a missing run": "evaluate nowhere",
    "an unfinished run": "evaluate unfinished",
    "codes that are not there": "topology nowhere.npy nowhere.npy",
    "codes alone": "topology codes.npy",
    "no run for topology": "topology nowhere",
    "no runs to compare": "compare nowhere elsewhere",
    "nothing to export": "export nowhere --onnx",
    "nothing to inspect": "inspect nowhere",
    "a log that is inspected": "inspect log.csv",
    "an unknown study": "reproduce nothing",
    "a sweep that is not there": "sweep nowhere.toml",
    "an unknown task": "navigate train sleep",
    "a level that is not there": "navigate train home --level 9",
    "no run to navigate with": "navigate train home --run nowhere --observe code",
    "a code without a run": "navigate train home --observe code",
    "no policy": "navigate evaluate nowhere",
    "no policy to watch": "navigate watch nowhere",
}


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    """A folder with the files that the words name."""
    place = tmp_path_factory.mktemp("words")
    (place / "plain.txt").write_text("hello\nworld\n")
    (place / "codes.npy").write_bytes(b"none")
    (place / "log.csv").write_text("time,motor_a,sensor_a\n0,1,2\n1,1,3\n2,2,1\n")
    code = (
        "from pathlib import Path; from motorspace.training.config import RunConfig;"
        "from motorspace.training.folder import Description, claim;"
        "Path('unfinished').mkdir();"
        "claim(Path('unfinished'), Description(RunConfig(), (1.0,), (1.0,), 6), resume=False)"
    )
    subprocess.run(
        [sys.executable, "-c", code], cwd=place, env={"PYTHONPATH": str(ROOT)}, check=True
    )
    return place


@pytest.mark.parametrize("words", WORDS.values(), ids=WORDS)
def test_the_command_line_answers_without_loading_anything_heavy(folder, words):
    call = f"from motorspace.cli.main import main; main({words.split()!r})"
    assert heavy_after(call, folder) == []
