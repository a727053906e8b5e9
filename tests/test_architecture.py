"""The data flows one way, and the core loads nothing heavy."""

import shutil
import subprocess
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).parent.parent
LINT = Path(sys.executable).with_name("lint-imports")


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
    shutil.copytree(ROOT / "motorspace", tmp_path / "motorspace", ignore=ignore)
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
        ("_types.py", "motorspace.worlds"),
    ],
)
def test_an_import_against_the_flow_is_found(copy, module, forbidden):
    path = copy / "motorspace" / module
    path.write_text(path.read_text() + f"\nimport {forbidden}\n")
    done = lint(copy)
    assert done.returncode == 1
    assert forbidden in done.stdout, done.stdout + done.stderr


@pytest.mark.parametrize("module", ["motorspace", "motorspace._errors", "motorspace.cli"])
def test_importing_loads_nothing_heavy(module):
    code = (
        f"import sys, {module}; heavy = ['matplotlib', 'sklearn', 'gymnasium', 'pyarrow'];"
        "sys.exit(', '.join(name for name in heavy if name in sys.modules) or 0)"
    )
    done = subprocess.run(
        [sys.executable, "-c", code], cwd=ROOT, capture_output=True, text=True, check=False
    )
    assert done.returncode == 0, done.stderr


def test_no_module_is_longer_than_a_newcomer_can_read():
    lengths = {p.name: len(p.read_text().splitlines()) for p in ROOT.glob("motorspace/**/*.py")}
    assert {name: n for name, n in lengths.items() if n > 400} == {}
