"""How the command line sets up JAX."""

import os
import subprocess
import sys

import jax
import pytest

from motorspace.cli.runtime import MOST_CACHED

PRECISION = """
from motorspace.cli.runtime import prepare_jax
prepare_jax()
import jax.numpy as jnp
print(jnp.zeros(()).dtype)
"""


def python(code, **environment):
    return subprocess.run(
        [sys.executable, "-c", code],
        env=os.environ | environment,
        capture_output=True,
        text=True,
        check=False,
    )


@pytest.mark.parametrize("device", ["quantum", "cuda"])
def test_a_device_that_is_missing_is_named_with_those_there_are(device):
    if device == "cuda" and jax.default_backend() == "gpu":
        pytest.skip("this machine has one")
    call = "from motorspace.cli.main import main; main(['train', 'lattice'])"
    done = python(call, JAX_PLATFORMS=device)
    assert done.returncode == 2
    assert done.stderr.splitlines()[-1].startswith(
        f"motorspace: JAX_PLATFORMS: there is no device '{device}' here; choose from: cpu"
    )
    assert "Traceback" not in done.stderr


@pytest.mark.parametrize("asked", ["0", "1"])
def test_everything_is_in_single_precision_whatever_the_environment_says(asked):
    assert python(PRECISION, JAX_ENABLE_X64=asked).stdout == "float32\n"


@pytest.mark.parametrize("named", [False, True])
def test_workers_share_the_bounded_cache_and_leave_a_named_one_alone(tmp_path, named):
    worker = """
import jax
print(jax.config.jax_compilation_cache_dir, jax.config.jax_compilation_cache_max_size)
"""
    parent = f"""
import subprocess, sys
from motorspace.cli.runtime import keep_compiled_programs
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
