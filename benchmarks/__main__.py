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
from motorspace._files import write_json

LAUNCHES, ATTEMPTS = 3, 6
OUT = Path("results/performance")
SUITES = [
    ("sensing", 1, {}),
    ("sensing", 2, {}),
    ("training", 2, {"BENCHMARK_BATCH": "100"}),
    ("training", 2, {"BENCHMARK_BATCH": "1000"}),
]
TARGETS = {
    ("scans", 2, "Open3D"): 20.0,
    ("scans", 2, "VMAS"): 150.0,
    ("training, batch 1000", 2, "nn.LSTM, fused Adam"): 1.7,
    ("training, batch 1000", 2, "torch.compile, fused Adam"): 1.2,
    ("training, batch 100", 2, "nn.LSTM, fused Adam"): 1.3,
    ("training, batch 100", 2, "torch.compile, fused Adam"): 1.15,
    ("training, batch 1000", 2, "FMA peak"): 0.38,
}
"""How many times as fast as a peer we want to be, at least; of the peak, which share."""


def main() -> None:
    """Measure, then write every rate and the targets."""
    rows = []
    for module, threads, settings in SUITES:
        launches, rejected = launch(module, threads, settings)
        if not launches:
            sys.exit(f"benchmarks: {module}: the machine was busy in all of {ATTEMPTS} launches")
        rows += suite_rows(launches, rejected)
    described = {"command": "make bench", "date": date.today().isoformat(), "machine": machine()}
    write_json(OUT / "benchmarks.json", described | {"rows": rows})
    reasons = json.loads((OUT / "reasons.json").read_text())
    claims = [
        claim(row, target, reasons)
        for row in rows
        if (target := TARGETS.get((row["work"], row["threads"], row["peer"])))
    ]
    write_json(OUT / "summary.json", claims)


def launch(module: str, threads: int, settings: dict[str, str]) -> tuple[list[Launch], int]:
    """Launches on an otherwise idle machine, and how many were rejected."""
    counted: list[Launch] = []
    attempts = 0
    while len(counted) < LAUNCHES and attempts < ATTEMPTS:
        attempts += 1
        with tempfile.NamedTemporaryFile(suffix=".json") as out:
            environment = os.environ | settings | {
                "BENCHMARK_OUT": out.name,
                "BENCHMARK_THREADS": str(threads),
                "OMP_NUM_THREADS": str(threads),
                "XLA_FLAGS": "--xla_cpu_multi_thread_eigen=false" if threads == 1 else "",
            }  # fmt: skip
            cores = ",".join(map(str, range(threads)))
            command = ["taskset", "-c", cores, sys.executable, "-m", f"benchmarks.{module}"]
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
            "ours": spread([statistics.median(run.rates["motorspace"]) for run in launches]),
            "theirs": spread([statistics.median(run.rates[peer]) for run in launches]),
            # Turn by turn, so that whatever slows the machine slows both.
            "ratio": spread([statistics.median(ratios(run, peer)) for run in launches]),
            "first run, seconds": {
                name: statistics.median(run.first_seconds[name] for run in launches)
                for name in ("motorspace", peer)
            },
            "errors": {name: first.errors.get(name) for name in ("motorspace", peer)},
            "launches": len(launches),
            "rejected": rejected,
        }
        for peer in first.rates
        if peer != "motorspace"
    ]


def ratios(run: Launch, peer: str) -> list[float]:
    return [a / b for a, b in zip(run.rates["motorspace"], run.rates[peer], strict=True)]


def spread(values: list[float]) -> dict[str, float]:
    return {"median": statistics.median(values), "low": min(values), "high": max(values)}


def claim(row: dict[str, Any], target: float, reasons: dict[str, str]) -> dict[str, Any]:
    """A target and whether it holds; `reasons` says why one does not."""
    ratio = row["ratio"]
    made = {
        "claim": f"{row['work']}, {row['threads']} threads: rate over that of {row['peer']}",
        "measured": ratio["median"],
        "interval": [ratio["low"], ratio["high"]],
        "target": f"at least {target}",
        "holds": ratio["low"] >= target,
        "command": "make bench",
        "date": date.today().isoformat(),
    }
    return made if made["holds"] else made | {"reason": reasons.get(made["claim"], "not known")}


def machine() -> dict[str, Any]:
    """What the numbers were measured on."""
    text = Path("/proc/cpuinfo").read_text()
    model = next(line.split(":")[1].strip() for line in text.splitlines() if "model name" in line)
    return {
        "processor": model,
        "cores": os.cpu_count(),
        "python": sys.version.split()[0],
        "most foreign load": MOST_FOREIGN_LOAD,
    }


if __name__ == "__main__":
    main()
