"""The cells that several studies share: the paper's systems under a budget of epochs."""

import math
from collections.abc import Mapping
from dataclasses import replace
from typing import TYPE_CHECKING, Any

from motorspace.studies.rows import Numbers
from motorspace.studies.study import Budget
from motorspace.training.config import RunConfig
from motorspace.training.data import Derived, DerivedKind, Simulated
from motorspace.training.presets import PresetName
from motorspace.training.settings import changed
from motorspace.worlds.catalog import AGENTS

if TYPE_CHECKING:
    from motorspace.training.run import Run

ROTATIONS = (0.2, 0.4, 0.6, 0.8, 1.0, 1.2)
"""Largest rotations of the paper's table I, in units of pi."""
CONTINUOUS = ("forward", "holonomic")
"""Its agents."""

EPOCHS_SHARE: Mapping[Budget, float] = {"quick": 0.05, "fifth": 0.2, "half": 0.5, "paper": 1.0}
"""The share of the paper's epochs that each budget trains for."""
TEST_TRAJECTORIES: Mapping[Budget, int] = {
    "quick": 100_000,
    "fifth": 200_000,
    "half": 1_000_000,
    "paper": 1_000_000,
}
"""Trajectories that predictions are tested on."""

LATTICES: Mapping[str, Mapping[str, Any]] = {
    "without-inverse": {},
    "with-inverse": {"inverse_weight": 0.04},
    "with-slowness": {"inverse_weight": 0.04, "slowness_weight": 0.04},
}
"""The paper's two lattice systems, and one whose codes also have to be slow: what each sets."""


def budgeted(config: RunConfig, budget: Budget, seed: int) -> RunConfig:
    """The run with its share of the epochs, and a seed."""
    epochs = max(1, round(config.training.epochs * EPOCHS_SHARE[budget]))
    return changed(config, {"epochs": epochs, "seed": seed})


def system(
    agent: str, rotation: float, budget: Budget, seed: int, preset: PresetName = "paper"
) -> RunConfig:
    """One system of the paper's table I, by its agent and largest rotation in units of pi."""
    part = AGENTS.part(agent, {"max_rotation": rotation * math.pi})
    return budgeted(RunConfig(Simulated(part), preset=preset), budget, seed)


def lattice(kind: str, budget: Budget, seed: int) -> RunConfig:
    """One of the `LATTICES`."""
    base = budgeted(RunConfig(Simulated("lattice")), budget, seed)
    return changed(base, LATTICES[kind])


def derived(config: RunConfig, change: DerivedKind, **options: float) -> RunConfig:
    """The run of a baseline that learns from changed data; see `Derived`."""
    assert isinstance(config.data, Simulated)
    return replace(config, data=Derived(config.data, change, **options))


def oracle(config: RunConfig) -> RunConfig:
    """The run of a predictor whose command is the true displacement."""
    return changed(derived(config, "oracle"), {"encoder": "identity", "curriculum": 0.0})


def untrained(config: RunConfig) -> RunConfig:
    """The run of a predictor that learns from the codes of an untrained encoder."""
    return changed(config, {"train_encoder": False, "curriculum": 0.0})


def evaluated(run: "Run", num: int) -> Numbers:
    """What `evaluate` measures: errors of prediction beside baselines, probes of the codes."""
    from motorspace.evaluation.evaluate import evaluate

    return evaluate(run, num=num)
