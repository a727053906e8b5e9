"""What all tests share."""

import ctypes
import gc
import os
import sys
from collections.abc import Callable, Iterator
from pathlib import Path

import jax
import pytest

# One thread, as on the command line; less optimisation and the older code generator, since tests
# compile more than they run. XLA refuses flags it does not know: after an update, look here.
os.environ.setdefault(
    "XLA_FLAGS",
    "--xla_cpu_multi_thread_eigen=false"
    " --xla_backend_optimization_level=1"
    " --xla_cpu_use_fusion_emitters=false",
)

# Many tests compile the same programs: the second one need not, in this process or another.
CACHE = str(Path(__file__).parents[1] / ".pytest_cache" / "jax")
os.environ["JAX_COMPILATION_CACHE_DIR"] = CACHE
jax.config.update("jax_compilation_cache_dir", CACHE)

# Types and shapes meet only as they are written: nothing is widened in silence.
jax.config.update("jax_numpy_dtype_promotion", "strict")
jax.config.update("jax_numpy_rank_promotion", "raise")


@pytest.fixture
def getkey() -> Callable[[], jax.Array]:
    """A function that gives a new key at every call; the same ones in every session."""
    keys = iter(jax.random.split(jax.random.key(20180513), 64))
    return lambda: next(keys)


@pytest.fixture(scope="module", autouse=True)
def forget_compiled_programs() -> Iterator[None]:
    """Programs of one module are of no use to the next, and fill gigabytes."""
    yield
    _forget()


@pytest.fixture(autouse=True)
def bounded_memory() -> Iterator[None]:
    """Those of one test, where a module compiles many."""
    yield
    if LINUX and int(Path("/proc/self/statm").read_text().split()[1]) * PAGE > MOST_BYTES:
        _forget()


LINUX = sys.platform == "linux"
PAGE = 4096
MOST_BYTES = 1_500_000_000


def _forget() -> None:
    jax.clear_caches()
    gc.collect()
    if LINUX:  # glibc keeps what is freed unless it is asked to return it
        getattr(ctypes.CDLL(None), "malloc_trim", int)(0)
