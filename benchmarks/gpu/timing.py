"""Medians of repeated runs, and the rows that say them."""

import math
import statistics
import time
from collections.abc import Callable, Iterator, Mapping
from typing import Any, NamedTuple

import jax

from benchmarks.gpu.sizes import Sizes

Row = Mapping[str, Any]
"""One line of the results: work, size, rate, unit, and beside what it stands."""

Case = Callable[[], list[Row]]
"""One measurement. Raises `Skipped` where something it needs is not there."""

Part = Callable[[Sizes], Iterator[Case]]


class Skipped(Exception):
    """Says in one sentence why something is not measured here."""


class Timing(NamedTuple):
    """Seconds of one run."""

    median: float
    low: float
    high: float
    first: float
    """The first run, compilation included."""


def timed(run: Callable[[], object], sizes: Sizes) -> Timing:
    """The median and the range of the seconds of a run over the repeats, after two to warm up.

    `run` may return arrays that are still being computed; they are waited for.
    """
    first, second = _seconds(run, 1), _seconds(run, 1)
    calls = max(1, math.ceil(sizes.seconds / sizes.repeats / second))
    taken = [_seconds(run, calls) for _ in range(sizes.repeats)]
    return Timing(statistics.median(taken), min(taken), max(taken), first)


def _seconds(run: Callable[[], object], calls: int) -> float:
    begun = time.perf_counter()
    for _ in range(calls):
        jax.block_until_ready(run())
    return (time.perf_counter() - begun) / calls


def rate(work: str, size: str, amount: float, unit: str, timing: Timing, **more: Any) -> list[Row]:
    """The row of some work at its rate: `amount` units in a run; `beside` names another row."""
    measured = {
        "rate": amount / timing.median,
        "low": amount / timing.high,
        "high": amount / timing.low,
        "unit": unit,
        "first run, seconds": timing.first,
    }
    return [{"work": work, "size": size} | measured | more]


def value(work: str, size: str, measured: float, unit: str, **more: Any) -> list[Row]:
    """The row of a number that is no rate, such as a loss."""
    return [{"work": work, "size": size, "rate": measured, "unit": unit} | more]
