"""From a fresh clone to the first figure: `make demo`, with empty caches and with full ones."""

import os
import subprocess
import tempfile
import time
from pathlib import Path

from benchmarks.harness import Launch, report, watch_foreign_load


def main() -> None:
    """Clone and run twice, the second time with what the first has downloaded and compiled."""
    foreign_load = watch_foreign_load()
    with tempfile.TemporaryDirectory() as folder:
        # pip and the compiler both keep their caches below this folder.
        environment = os.environ | {"XDG_CACHE_HOME": f"{folder}/caches"}
        cold, warm = (demo_seconds(Path(folder) / name, environment) for name in ("cold", "warm"))
    rates = {"motorspace": [1 / cold], "caches warm": [1 / warm]}
    first = {"motorspace": cold, "caches warm": warm}
    threads = int(os.environ["BENCHMARK_THREADS"])
    report(Launch("make demo", "demos", threads, rates, first, {}, foreign_load()))


def demo_seconds(clone: Path, environment: dict[str, str]) -> float:
    begun = time.perf_counter()
    subprocess.run(["git", "clone", "--quiet", ".", clone], check=True)
    subprocess.run(["make", "--silent", "demo"], cwd=clone, env=environment, check=True)
    assert (clone / "demo" / "report.html").exists(), "the demo wrote no page"
    return time.perf_counter() - begun


if __name__ == "__main__":
    main()
