"""The paper's whole table I as motorspace trains it, and the losses it arrives at."""

import time
from collections.abc import Iterator
from contextlib import contextmanager
from functools import partial
from pathlib import Path
from statistics import fmean
from tempfile import TemporaryDirectory
from typing import Any

import jax.monitoring

from benchmarks.gpu.sizes import Sizes
from benchmarks.gpu.timing import Case, Row, value
from motorspace.running.store import read_lines
from motorspace.studies.cells import CONTINUOUS, system
from motorspace.training.run import train_together
from motorspace.training.settings import changed

KEPT = Path("results/table1.jsonl")
COMPILED = "/jax/core/compile/backend_compile_duration"
LONG = 1.0
"""Seconds of compilation from which it is a program worth counting."""
SQUARED_SCALE = 10.0**2
"""From shares of the sensors' scale to the table's unit."""
SECONDS = {"compiling": "the whole table, compilation", "training": "the whole table, training"}


def table(sizes: Sizes) -> Iterator[Case]:
    """Both agents' cells, then what they took together."""
    taken: list[dict[str, float]] = []
    for agent in CONTINUOUS:
        yield partial(_of_agent, agent, sizes, taken)
    if len(taken) == len(CONTINUOUS):
        together = {name: sum(one[name] for one in taken) for name in taken[0]}
        yield partial(_seconds_rows, "both agents", together, sizes)


def _of_agent(agent: str, sizes: Sizes, taken: list[dict[str, float]]) -> list[Row]:
    with compilations() as seconds:
        begun = time.perf_counter()
        losses = whole_table(agent, sizes)
        compiling, all_seconds = sum(seconds), time.perf_counter() - begun
    programs = float(sum(second > LONG for second in seconds))
    taken.append(
        {"compiling": compiling, "training": all_seconds - compiling, "programs": programs}
        | {"compilations": float(len(seconds))}
    )
    return [*_seconds_rows(agent, taken[-1], sizes), *_loss_rows(agent, losses)]


def whole_table(agent: str, sizes: Sizes) -> dict[float, list[float]]:
    """The last losses of the seeds of every cell of an agent, by its rotation; one program."""
    runs = [(r, seed) for r in sizes.rotations for seed in range(sizes.seeds)]
    configs = [changed(system(agent, r, "paper", seed), _settings(sizes)) for r, seed in runs]
    with TemporaryDirectory() as folder:
        trained = train_together(configs, [Path(folder, str(n)) for n in range(len(runs))])
    losses: dict[float, list[float]] = {rotation: [] for rotation in sizes.rotations}
    for (rotation, _), run in zip(runs, trained, strict=True):
        losses[rotation].append(float(run.log[-1]["prediction_loss"]))
    return losses


def _settings(sizes: Sizes) -> dict[str, Any]:
    return {"epochs": sizes.table_epochs} | sizes.epoch | dict(sizes.network)


@contextmanager
def compilations() -> Iterator[list[float]]:
    """The seconds of every compilation within."""
    seconds: list[float] = []

    def listen(event: str, duration_secs: float, **_: Any) -> None:
        if event == COMPILED:
            seconds.append(duration_secs)

    jax.monitoring.register_event_duration_secs_listener(listen)
    try:
        yield seconds
    finally:
        jax.monitoring.unregister_event_duration_listener(listen)


def _seconds_rows(agent: str, taken: dict[str, float], sizes: Sizes) -> list[Row]:
    size = f"{agent}, {sizes.table_epochs:,} epochs"
    rows = [row for name, work in SECONDS.items() for row in value(work, size, taken[name], "s")]
    programs = taken["programs"], f"programs of over {LONG:.0f} s"
    every: dict[str, Any] = {"all compilations": taken["compilations"]}
    return [*rows, *value("the whole table, compiled", size, *programs, **every)]


def _loss_rows(agent: str, losses: dict[float, list[float]]) -> list[Row]:
    """The mean last loss of each cell, beside the error that is kept of a full training."""
    kept = {
        rotation: [line.metrics["prediction.error"] for line in _kept(agent, rotation)]
        for rotation in losses
    }
    return [
        row
        for rotation, found in losses.items()
        for row in value(
            f"{agent}, last loss",
            f"r = {rotation}π, {len(found)} seeds",
            SQUARED_SCALE * fmean(found),
            "sensor units²",
            losses=[SQUARED_SCALE * loss for loss in found],
            **_beside(kept[rotation]),
        )
    ]


def _kept(agent: str, rotation: float) -> list[Any]:
    wanted = {"agent": agent, "rotation": rotation, "variant": "paper"}
    lines = read_lines(KEPT) if KEPT.exists() else []
    return [line for line in lines if dict(line.cell) == wanted]


def _beside(errors: list[float]) -> dict[str, Any]:
    if not errors:
        return {}
    return {"beside": f"error kept of {len(errors)} runs", "bound": fmean(errors)}
