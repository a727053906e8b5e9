"""What the hardware could do at most, measured beside the contenders."""

import ctypes
import subprocess
import tempfile
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

from benchmarks.harness import Contender

ROUNDS = 1_000_000
FLOPS_PER_ROUND = 12 * 8 * 2
SAMPLE_FLOPS = 2 * (303_400 + 303_400 + 296_800)
"""Forward and backward pass of the paper's network for the forward agent, T = 6: the network, its
weights' gradients, its inputs' gradients, where the first step has no state and nothing flows to
commands and sensors. A multiplication and an addition are two."""


def fma_peak(threads: int) -> Contender:
    """Samples that `threads` cores could train on which did nothing but fused multiply-adds."""
    chains = compiled("roofline.c").fma_chains
    chains.argtypes, chains.restype = [ctypes.c_long], ctypes.c_float
    pool = ThreadPoolExecutor(threads)

    def run() -> None:
        list(pool.map(chains, [ROUNDS] * threads))

    return Contender("FMA peak", run, threads * ROUNDS * FLOPS_PER_ROUND / SAMPLE_FLOPS)


def compiled(source: str) -> ctypes.CDLL:
    """A C file of this folder, compiled for this machine."""
    library = Path(tempfile.mkdtemp()) / "library.so"
    path = Path(__file__).with_name(source)
    command = ["cc", "-O3", "-march=native", "-shared", "-fPIC", str(path), "-o", str(library)]
    subprocess.run(command, check=True)
    return ctypes.CDLL(str(library))
