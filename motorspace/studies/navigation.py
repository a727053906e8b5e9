"""What do learned codes add to reinforcement learning of navigation?"""

from collections.abc import Mapping, Sequence
from dataclasses import replace
from functools import partial
from typing import TYPE_CHECKING, Any

import numpy as np

from motorspace.analysis.measures import Measure, define
from motorspace.navigation.config import NavigationConfig, PolicyConfig
from motorspace.running.jobs import Job, cell
from motorspace.studies.cells import system
from motorspace.studies.rows import Numbers, Row
from motorspace.studies.study import Budget, Line, Study, Table, Target

if TYPE_CHECKING:
    from motorspace.training.run import Run

define(
    Measure("navigation.{kind}.success", "goals reached, {kind}", goal="high", perfect=1.0),
    Measure("navigation.{kind}.success.around", "behind walls, {kind}", goal="high", perfect=1.0),
    Measure("navigation.{kind}.spl", "SPL, {kind}", goal="high", perfect=1.0),
    Measure("navigation.{kind}.steps", "commands to the goal, {kind}", goal="low"),
    Measure("navigation.{kind}.cells", "cells entered, {kind}", goal="high"),
    Measure("navigation.{kind}.num", "problems, {kind}"),
)

STEPS = {"home": 300_000, "displacement_goal": 1_000_000}
"""Environment steps from which the policies of a task learn."""

SENSED = ("ranges", "bump", "command")
MEMORY = PolicyConfig(memory_size=64)

OBSERVATIONS: Mapping[str, Mapping[str, Any]] = {
    "ranges": {"observe": SENSED},
    "ranges + four frames": {"observe": (*SENSED, "stack")},
    "ranges + GRU": {"observe": SENSED, "policy": MEMORY},
    "chained code": {"observe": (*SENSED, "code")},
    "chained code + GRU": {"observe": (*SENSED, "code"), "policy": MEMORY},
    "chained code, bumps not sensed": {
        "observe": ("ranges", "command", "code"),
        "sense_blocked": False,
    },
    "untrained code": {"observe": (*SENSED, "untrained_code")},
    "true displacement": {"observe": (*SENSED, "displacement")},
    "true displacement + GRU": {"observe": (*SENSED, "displacement"), "policy": MEMORY},
}
"""What each row observes, and whether it remembers."""

BESIDE = ("chance", "planner")
"""Rows that learn nothing."""

NUM_RESAMPLES = 9999


def jobs(budget: Budget, seeds: int) -> list[Job]:
    """A network of the preset `best` for each seed, with which every row is learned."""
    return [
        Job(
            "navigation",
            cell(agent="forward", rotation=0.4),
            system("forward", 0.4, budget, seed, "best"),
            "quick" if budget == "quick" else "full",
        )
        for seed in range(seeds)
    ]


def measured(run: "Run", num: int, *, share: float) -> Numbers:
    """Every row of every task: {TASK/ROW/MEASURE: value}, after a share of the steps."""
    from motorspace.navigation.learning import learn_policy
    from motorspace.navigation.measuring import evaluate_policy

    del num
    found = dict[str, float]()
    for task, steps in STEPS.items():
        for row, observed in OBSERVATIONS.items():
            config = configuration(run, task, observed, round(share * steps))
            trained = learn_policy(config, run)
            for key, value in evaluate_policy(trained, seed=config.seed).items():
                kind, _, measure = key.partition(".")
                place = f"{task}/{kind if kind in BESIDE else row}"
                found[f"{place}/navigation.{_split(kind)}.{measure}"] = value
    return found


def configuration(
    run: "Run", task: str, observed: Mapping[str, Any], steps: int
) -> NavigationConfig:
    """A policy for the body of a run, with its seed."""
    data: Any = run.config.data
    config = NavigationConfig(task=task, agent=data.agent, sensor=data.sensor, steps=steps)
    return replace(config, seed=run.config.training.seed, **observed)


def _split(kind: str) -> str:
    """Chance and the planner are measured in unseen layouts."""
    return "unseen" if kind in BESIDE else kind


def rows(found: Sequence[Row]) -> list[Row]:
    """A row for each task and observation."""
    return [
        replace(
            row,
            cell={"task": task, "observed": name},
            runs={seed: _of(numbers, f"{task}/{name}/") for seed, numbers in row.runs.items()},
        )
        for row in found
        for task in STEPS
        for name in (*OBSERVATIONS, *BESIDE)
    ]


def _of(numbers: Numbers, place: str) -> dict[str, Any]:
    return {
        key.removeprefix(place): value for key, value in numbers.items() if key.startswith(place)
    }


def lines(found: Sequence[Row], *, task: str) -> list[Line]:
    """Interquartile means over seeds with bootstrapped 95 % intervals (Agarwal et al., 2021)."""
    return [
        {"observed": row.cell["observed"], "seeds": len(row.runs)}
        | {head: interquartile(row[key].values) for head, key in HEADS.items() if key in row}
        for row in found
        if row.cell["task"] == task
    ]


def interquartile(values: Sequence[float]) -> dict[str, float]:
    """The mean of the middle half, and its percentile interval.

    >>> interquartile([0.0, 1.0, 1.0, 1.0, 1.0, 1.0, 1.0, 9.0])["mean"]
    1.0
    """
    random = np.random.default_rng(0)
    resampled = random.choice(np.asarray(values), (NUM_RESAMPLES, len(values)))
    low, high = np.percentile(_middle(resampled), [2.5, 97.5])
    return {"mean": float(_middle(np.asarray(values))), "low": float(low), "high": float(high)}


def _middle(values: np.ndarray) -> Any:
    """The mean of the values between the quartiles, along the last axis."""
    ordered, cut = np.sort(values, axis=-1), values.shape[-1] // 4
    return ordered[..., cut : values.shape[-1] - cut].mean(axis=-1)


HEADS = {
    "goals reached, seen": "navigation.seen.success",
    "goals reached, unseen": "navigation.unseen.success",
    "behind walls": "navigation.unseen.success.around",
    "SPL": "navigation.unseen.spl",
    "commands": "navigation.unseen.steps",
}

HOME = {"task": "home", "observed": "chained code"}

STUDY = Study(
    name="navigation",
    question="What do learned codes add to reinforcement learning of navigation?",
    jobs=jobs,
    measures={"full": partial(measured, share=1.0), "quick": partial(measured, share=0.1)},
    rows=rows,
    tables={f"navigation_{task}": Table(partial(lines, task=task)) for task in STEPS},
    targets=(
        Target("home, seen layouts", "navigation.seen.success", at_least=0.97, cells=HOME),
        Target("home, unseen layouts", "navigation.unseen.success", at_least=0.97, cells=HOME),
        Target(
            "displacement goals behind walls, unseen layouts",
            "navigation.unseen.success.around",
            at_least=0.85,
            cells={"task": "displacement_goal", "observed": "chained code + GRU"},
        ),
    ),
)
