"""Training of many runs at once, and what the precision of matrix products changes in it."""

from collections.abc import Iterator
from functools import partial
from typing import Any

import jax
import numpy as np

from benchmarks.gpu.ours import ours
from benchmarks.gpu.sizes import Sizes
from benchmarks.gpu.timing import Case, Row, rate, timed, value
from motorspace.training.config import RunConfig
from motorspace.training.settings import changed

PRECISIONS = ("float32", "tensorfloat32", "bfloat16")


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
        yield partial(_loss_at, name, sizes)


def _time_at(name: str, sizes: Sizes) -> list[Row]:
    config, num = _of_precision(sizes), sizes.precision_runs
    timing = timed(ours(config, num, sizes.epochs, fresh=True, precision=in_jax(name)), sizes)
    taken = 1e3 * timing.median / (sizes.epochs * config.training.num_updates)
    beside = {} if name == PRECISIONS[0] else {"beside": f"an update, {PRECISIONS[0]}"}
    return value(f"an update, {name}", counted(num), taken, "ms", **beside)


def _loss_at(name: str, sizes: Sizes) -> list[Row]:
    config, num = _of_precision(sizes), sizes.precision_runs
    run = ours(config, num, config.training.epochs, fresh=True, precision=in_jax(name))
    losses = np.asarray(run(), float)
    after = f"{counted(num)}, {counted(config.training.epochs, 'epoch')}"
    beside = {} if name == PRECISIONS[0] else {"beside": f"final loss, {PRECISIONS[0]}"}
    found = {"deviation": losses.std(), "losses": losses.tolist()}
    return value(f"final loss, {name}", after, losses.mean(), "of the scale²", **beside, **found)


def _of_precision(sizes: Sizes) -> RunConfig:
    return changed(sizes.config(), {"epochs": sizes.precision_epochs})


def in_jax(name: str) -> str:
    """What JAX calls a precision of products: with inputs in float32, `bfloat16` leaves it free
    to use more on a GPU; this algorithm does not, but is not there for a CPU."""
    exact = name == "bfloat16" and jax.default_backend() == "gpu"
    return "BF16_BF16_F32" if exact else name
