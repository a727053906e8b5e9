"""The paper's whole table, as `reproduce` trains it: a run on each core."""

import os
import subprocess
import sys
from collections.abc import Sequence

from benchmarks.harness import Launch, report, take_turns, watch_foreign_load
from benchmarks.roofline import fma_peak

EPOCHS, TURNS = 60, 3

ONE_RUN = """
import os, sys, time
os.sched_setaffinity(0, {int(sys.argv[3])})
from motorspace.training.config import RunConfig
from motorspace.training.data import Simulated
from motorspace.training.run import train
from motorspace.training.settings import changed
agent, epochs = sys.argv[1], int(sys.argv[2])
seen = []
train(changed(RunConfig(Simulated(agent)), {"epochs": epochs}),
      callback=lambda record: seen.append(time.perf_counter()))
print((epochs - epochs // 3) * 2000 / (seen[-1] - seen[epochs // 3 - 1]))
"""
"""Trajectories a second; the first third, with the compilation, does not count."""


def main() -> None:
    """How many trajectories a second all runs together learn from, and what the cores could."""
    threads = int(os.environ["BENCHMARK_THREADS"])
    agents = [("forward", "holonomic")[core % 2] for core in range(threads)]
    foreign_load = watch_foreign_load()
    ours, foreign = [sum(side_by_side(agents)) for _ in range(TURNS)], foreign_load()
    peak, first, _ = take_turns([fma_peak(threads)], turns=TURNS)
    rates, first = {"motorspace": ours} | peak, {"motorspace": 0.0} | first
    report(Launch("the whole table", "samples", threads, rates, first, {}, foreign))


def side_by_side(agents: Sequence[str]) -> list[float]:
    """The rates of these agents' runs that train at the same time, each on a core of its own."""
    environment = os.environ | {"XLA_FLAGS": "--xla_cpu_multi_thread_eigen=false"}
    started = [
        subprocess.Popen(
            [sys.executable, "-c", ONE_RUN, agent, str(EPOCHS), str(core)],
            env=environment,
            stdout=subprocess.PIPE,
            text=True,
        )
        for core, agent in enumerate(agents)
    ]
    return [float(run.communicate()[0]) for run in started]


if __name__ == "__main__":
    main()
