"""Fair timing: contenders take turns in one process, and a busy neighbour spoils the run."""

import json
import os
import resource
import time
from collections.abc import Callable, Sequence
from dataclasses import asdict, dataclass
from pathlib import Path

MOST_FOREIGN_LOAD = 0.1
"""Cores' worth of other processes' work above which a launch does not count."""

CLOCK_TICKS = os.sysconf("SC_CLK_TCK")


@dataclass(frozen=True)
class Contender:
    """One implementation of a piece of work."""

    name: str
    run: Callable[[], object]
    """Does the work once and waits for its end."""
    amount: float
    """Units of work done by one run."""


@dataclass(frozen=True)
class Launch:
    """What one process measured."""

    suite: str
    unit: str
    threads: int
    rates: dict[str, list[float]]
    """Units per second of each contender, one for every turn."""
    first_seconds: dict[str, float]
    """The first run, compilation included."""
    errors: dict[str, dict[str, float]]
    foreign_load: float
    peak_gib: float = 0.0
    """The most memory that the process held."""

    @property
    def counts(self) -> bool:
        return self.foreign_load <= MOST_FOREIGN_LOAD


def take_turns(
    contenders: Sequence[Contender], *, turns: int = 5, seconds: float = 0.5
) -> tuple[dict[str, list[float]], dict[str, float], float]:
    """Rates of every contender by turn, the seconds of its first run, and the foreign load.

    In its turn a contender runs again and again for `seconds`; its best run counts, since
    whatever else the machine does can only slow it down.
    """
    first = {c.name: _seconds_of(c.run) for c in contenders}
    rates: dict[str, list[float]] = {c.name: [] for c in contenders}
    foreign_load = watch_foreign_load()
    for _ in range(turns):
        for contender in contenders:
            rates[contender.name].append(contender.amount / best_seconds(contender.run, seconds))
    return rates, first, foreign_load()


def watch_foreign_load() -> Callable[[], float]:
    """A function that tells the cores' worth of other processes' work since now."""
    busy, own, begun = _busy_seconds(), _own_seconds(), time.perf_counter()

    def load() -> float:
        foreign = (_busy_seconds() - busy) - (_own_seconds() - own)
        return max(0.0, foreign) / (time.perf_counter() - begun)

    return load


def report(launch: Launch) -> None:
    """Hand a launch, with the memory it took, to the process that started this one."""
    peak_gib = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 2**20
    told = asdict(launch) | {"peak_gib": peak_gib}
    Path(os.environ["BENCHMARK_OUT"]).write_text(json.dumps(told))


def report_once(suite: str, unit: str, run: Callable[[], dict[str, float]]) -> None:
    """Report work that is too long for turns: `run` does it and tells each contender's seconds."""
    foreign_load = watch_foreign_load()
    seconds = run()
    rates = {name: [1 / taken] for name, taken in seconds.items()}
    threads = int(os.environ["BENCHMARK_THREADS"])
    report(Launch(suite, unit, threads, rates, seconds, {}, foreign_load()))


def best_seconds(run: Callable[[], object], seconds: float = 0.5) -> float:
    """Of all the runs that fit into `seconds`, what the fastest took."""
    best, until = float("inf"), time.perf_counter() + seconds
    while time.perf_counter() < until:
        best = min(best, _seconds_of(run))
    return best


def _seconds_of(run: Callable[[], object]) -> float:
    begun = time.perf_counter()
    run()
    return time.perf_counter() - begun


def _busy_seconds() -> float:
    """Seconds that all cores together have worked since the machine started."""
    user, nice, system, _, _, irq, softirq, *_ = map(
        int, Path("/proc/stat").read_text().split("\n")[0].split()[1:]
    )
    return (user + nice + system + irq + softirq) / CLOCK_TICKS


def _own_seconds() -> float:
    """Seconds that this process and its finished children have worked."""
    return sum(os.times()[:4])
