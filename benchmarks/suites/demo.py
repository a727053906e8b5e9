"""From a fresh clone to the first figure: `make demo`, with empty caches and with full ones."""

import os
import subprocess
import tempfile
import time
from pathlib import Path

from benchmarks.harness import report_once


def main() -> None:
    report_once("make demo", "demos", twice)


def twice() -> dict[str, float]:
    """Seconds of a clone's demo, then of another's that finds what the first downloaded and
    compiled."""
    with tempfile.TemporaryDirectory() as folder:
        # pip and the compiler both keep their caches below this folder.
        environment = os.environ | {"XDG_CACHE_HOME": f"{folder}/caches"}
        cold, warm = (demo_seconds(Path(folder) / name, environment) for name in ("cold", "warm"))
    return {"motorspace": cold, "caches warm": warm}


def demo_seconds(clone: Path, environment: dict[str, str]) -> float:
    begun = time.perf_counter()
    subprocess.run(["git", "clone", "--quiet", ".", clone], check=True)
    subprocess.run(["make", "--silent", "demo"], cwd=clone, env=environment, check=True)
    assert (clone / "demo" / "report.html").exists(), "the demo wrote no page"
    return time.perf_counter() - begun


if __name__ == "__main__":
    main()
