"""Launch every suite several times, each in a fresh process, and gather what they measured."""

import json
import os
import statistics
import subprocess
import sys
import tempfile
from datetime import date
from pathlib import Path
from typing import Any

from benchmarks.harness import MOST_FOREIGN_LOAD, Launch
from benchmarks.suites import Setup, setups, suites
from motorspace._files import write_json

LAUNCHES, ATTEMPTS = 3, 6
OUT = Path("results")


def main() -> None:
    """Measure the suites named, or all; the claims about the rates are made with the tables.

    Rows of suites that are not named stay as they were measured before.
    """
    named = sys.argv[1:] or suites()
    if unknown := set(named) - set(suites()):
        sys.exit(f"benchmarks: there is no suite {', '.join(sorted(unknown))}")
    out = OUT / "benchmarks.json"
    kept = json.loads(out.read_text())["rows"] if out.exists() else []
    rows = [row for row in kept if row["suite"] not in named]
    for suite, setup in ((name, setup) for name in named for setup in setups(name)):
        launches, rejected = launch(suite, setup)
        if not launches:
            sys.exit(f"benchmarks: {suite}: the machine was busy in all of {ATTEMPTS} launches")
        described = {"suite": suite, "processor": machine()["processor"]}
        rows += [described | row for row in suite_rows(launches, rejected)]
    described = {"command": "make bench", "date": date.today().isoformat(), "machine": machine()}
    write_json(out, described | {"rows": rows})


def launch(suite: str, setup: Setup) -> tuple[list[Launch], int]:
    """Launches on an otherwise idle machine, and how many were rejected."""
    counted: list[Launch] = []
    attempts, threads = 0, setup.threads
    while len(counted) < LAUNCHES and attempts < ATTEMPTS:
        attempts += 1
        with tempfile.NamedTemporaryFile(suffix=".json") as out:
            environment = os.environ | setup.settings | {
                "BENCHMARK_OUT": out.name,
                "BENCHMARK_THREADS": str(threads),
                "OMP_NUM_THREADS": str(threads),
                "XLA_FLAGS": "--xla_cpu_multi_thread_eigen=false" if threads == 1 else "",
            }  # fmt: skip
            cores = ",".join(map(str, range(threads)))
            command = ["taskset", "-c", cores, sys.executable, "-m", f"benchmarks.suites.{suite}"]
            subprocess.run(command, env=environment, check=True)
            done = Launch(**json.loads(Path(out.name).read_text()))
        if done.counts:
            counted.append(done)
        print(f"{done.suite}, {threads} threads: foreign load {done.foreign_load:.2f}", flush=True)
    return counted, attempts - len(counted)


def suite_rows(launches: list[Launch], rejected: int) -> list[dict[str, Any]]:
    """One row per peer: rates and ratios, the median and the range over launches."""
    first = launches[0]
    return [
        {
            "work": first.suite,
            "unit": first.unit,
            "threads": first.threads,
            "peer": peer,
            "ours": median_and_range(
                [statistics.median(run.rates["motorspace"]) for run in launches]
            ),
            "theirs": median_and_range([statistics.median(run.rates[peer]) for run in launches]),
            # Turn by turn, so that whatever slows the machine slows both.
            "ratio": median_and_range([statistics.median(ratios(run, peer)) for run in launches]),
            "first run, seconds": {
                name: statistics.median(run.first_seconds[name] for run in launches)
                for name in ("motorspace", peer)
            },
            "errors": {name: first.errors.get(name) for name in ("motorspace", peer)},
            "peak GiB": median_and_range([run.peak_gib for run in launches]),
            "launches": len(launches),
            "rejected": rejected,
        }
        for peer in first.rates
        if peer != "motorspace"
    ]


def ratios(run: Launch, peer: str) -> list[float]:
    return [a / b for a, b in zip(run.rates["motorspace"], run.rates[peer], strict=True)]


def median_and_range(values: list[float]) -> dict[str, float]:
    return {"median": statistics.median(values), "low": min(values), "high": max(values)}


def machine() -> dict[str, Any]:
    """What the numbers were measured on."""
    text = Path("/proc/cpuinfo").read_text()
    model = next(line.split(":")[1].strip() for line in text.splitlines() if "model name" in line)
    vectors = next((v for v in ("avx512f", "avx2", "asimd") if v in text), "vectors unknown")
    return {
        "processor": f"{model}, {vectors}",
        "cores": os.cpu_count(),
        "python": sys.version.split()[0],
        "most foreign load": MOST_FOREIGN_LOAD,
    }


if __name__ == "__main__":
    main()
