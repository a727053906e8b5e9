"""Training of many runs at once, and what the precision of matrix products changes in it."""

from collections.abc import Iterator
from functools import partial
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

import numpy as np

from benchmarks.gpu.ours import ours
from benchmarks.gpu.sizes import Sizes
from benchmarks.gpu.timing import Case, Row, rate, timed, value
from motorspace.analysis.coordinates import COMPONENTS
from motorspace.evaluation.evaluate import evaluate
from motorspace.training.config import RunConfig
from motorspace.training.run import train_together
from motorspace.training.settings import changed

PRECISIONS = ("float32", "tf32", "bf16")


def counted(num: int, what: str = "run") -> str:
    """So many of something.

    >>> counted(1), counted(16)
    ('1 run', '16 runs')
    """
    return f"{num:,} {what}{'s' * (num > 1)}"


def training(sizes: Sizes) -> Iterator[Case]:
    """Samples a second by the number of runs, on the same transitions and on fresh ones."""
    for fresh in (False, True):
        work = f"training, {'fresh' if fresh else 'fixed'} data"
        one = f"{work}, {counted(sizes.runs[0])}"
        for num in sizes.runs:
            more = {"beside": one} if num > sizes.runs[0] else {}
            yield partial(trained, work, sizes.config(), num, sizes, fresh=fresh, **more)


def trained(
    work: str, config: RunConfig, num: int, sizes: Sizes, *, fresh: bool = False, **more: Any
) -> list[Row]:
    """The row of so many runs: transitions that all together learn from in a second."""
    timing = timed(ours(config, num, sizes.epochs, fresh=fresh), sizes)
    samples = num * sizes.epochs * config.training.num_updates * config.training.batch_size
    return rate(work, counted(num), samples, "samples/s", timing, **more)


def precision(sizes: Sizes) -> Iterator[Case]:
    """Milliseconds of an update of several runs, and what they have learned after many."""
    for name in PRECISIONS:
        yield partial(_time_at, name, sizes)
        yield partial(_learned_at, name, sizes)


def _time_at(name: str, sizes: Sizes) -> list[Row]:
    config, num = changed(sizes.config(), {"precision": name}), sizes.networks[-1]
    timing = timed(ours(config, num, sizes.epochs, fresh=False), sizes)
    taken = 1e3 * timing.median / (sizes.epochs * config.training.num_updates)
    return value(f"an update, {name}", counted(num), taken, "ms", **_beside("an update", name))


def _learned_at(name: str, sizes: Sizes) -> list[Row]:
    """Error and structure of runs of several seeds, beside those of float32."""
    settings = {"epochs": sizes.precision_epochs, "precision": name, "curriculum": 0.3}
    config, num = changed(sizes.config(), settings), sizes.precision_runs
    seeded = [changed(config, {"seed": seed}) for seed in range(num)]
    with TemporaryDirectory() as folder:
        runs = train_together(seeded, [Path(folder, str(n)) for n in range(num)])
    found = [evaluate(run, num=sizes.precision_tests) for run in runs]
    measured = {
        "error": [one["prediction.error"] for one in found],
        "lowest linear R2": [min(one[f"probe_r2.{c}"] for c in COMPONENTS) for one in found],
    }
    after = f"{counted(num)}, {counted(config.training.epochs, 'epoch')}"
    units = {"error": "sensor units²", "lowest linear R2": ""}
    return [
        row
        for what, numbers in measured.items()
        for row in value(
            f"{what}, {name}",
            after,
            float(np.mean(numbers)),
            units[what],
            deviation=float(np.std(numbers)),
            each=numbers,
            **_beside(what, name),
        )
    ]


def _beside(what: str, name: str) -> dict[str, str]:
    return {} if name == PRECISIONS[0] else {"beside": f"{what}, {PRECISIONS[0]}"}
