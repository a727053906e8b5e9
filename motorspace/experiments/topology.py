"""Presets, and what organises codes better: runs as data, and their rows beside references."""

from functools import partial
from typing import Any

from motorspace.analysis.coordinates import displacement_coordinates
from motorspace.analysis.projections import pca
from motorspace.experiments import paper
from motorspace.experiments.measurement import measure
from motorspace.experiments.organisation import (
    Codes,
    Encode,
    Motors,
    encoder_of,
    nominal,
    organisation,
)
from motorspace.training import Run

Changes = dict[str, dict[str, Any]]

BEST: Changes = {"model": {"encoder": "group", "hidden_size": 64, "code_size": 30}}
"""What the preset `best` changes in the paper's system."""

ABLATION: dict[str, Changes] = {
    "paper": {},
    "mixed horizons": {"simulation": {"min_horizon": 1}},
    "smaller code": {"model": {"code_size": 10}},
    "inverse model": {"model": {"inverse_weight": 0.04}},
    "slowness": {"model": {"slowness_weight": 0.04}},
    "gru": {"model": {"encoder": "gru"}},
    "group": BEST,
}
"""What may organise codes better, one change at a time."""

ABLATION_CELL = ("holonomic", 0.8)

FIXED = ("untrained", "raw motors", "motor components", "dead reckoned")
"""The reference rows that nothing is trained for."""

SHUFFLED_AND_SUPERVISED: tuple[paper.Part, ...] = ("shuffled", "supervised")


def topology_jobs(budget: paper.Budget, *, seeds: int) -> list[paper.Job]:
    """The runs behind the table of organisation, one seed of every cell before the next seed."""
    return [job for seed in range(seeds) for job in _of_seed(budget, seed)]


def _of_seed(budget: paper.Budget, seed: int) -> list[paper.Job]:
    cells = {
        f"{agent}-{rotation}": paper.cell(agent, rotation, budget, seed)
        for rotation in paper.ROTATIONS
        for agent in ("forward", "holonomic")
    }
    jobs = []
    for changes, name in ((BEST, "best"), ({}, "paper")):
        for cell, config in cells.items():
            changed = paper.changed(config, changes)
            jobs.append(paper.Job(f"topology/{cell} {name}", changed, measure=organised))
    for cell, config in cells.items():
        for row in FIXED:
            told = partial(organised_fixed, row=row)
            jobs.append(paper.Job(f"topology/{cell} {row}", config, "initial", told))
    for cell, config in cells.items():
        for part in SHUFFLED_AND_SUPERVISED:
            jobs.append(paper.Job(f"topology/{cell} {part}", config, part, organised_encoder))
    return jobs


def ablation_jobs(budget: paper.Budget, *, seeds: int) -> list[paper.Job]:
    """The runs behind the table of what organises codes better."""
    return [
        paper.Job(
            f"ablation/{name}",
            paper.changed(paper.cell(*ABLATION_CELL, budget, seed), changes),
            measure=organised,
        )
        for seed in range(seeds)
        for name, changes in ABLATION.items()
    ]


def organised(run: Run, num: int) -> dict[str, Any]:
    """Prediction errors over `num` trajectories, and how the codes are organised."""
    return _organisation(run, encoder_of(run.encode)) | measure(run, num)


def organised_encoder(run: Run, num: int) -> dict[str, Any]:
    """How the codes are organised of a run that has learned to predict something else."""
    del num
    return _organisation(run, encoder_of(run.encode))


def organised_fixed(run: Run, num: int, *, row: str) -> dict[str, Any]:
    """The same of codes that are not learned; `row` is one of `FIXED`."""
    del num
    _, agent, _ = run.config.simulation.build()

    def components(motors: Motors) -> Codes:
        return pca(motors.reshape(len(motors), -1), 8).coordinates

    encoders: dict[str, Encode] = {
        "untrained": encoder_of(run.encode),
        "raw motors": lambda motors: motors.reshape(len(motors), -1),
        "motor components": components,
        "dead reckoned": lambda motors: displacement_coordinates(nominal(agent, motors)).points,
    }
    return _organisation(run, encoders[row])


def _organisation(run: Run, encode: Encode) -> dict[str, Any]:
    simulation, training = run.config.simulation, run.config.training
    _, agent, _ = simulation.build()
    found = organisation(encode, agent, horizon=simulation.horizon, seed=training.seed)
    empty = {"recipe": "", "errors": {}, "probe_r2": {}}
    return empty | {"seed": training.seed, "epochs": training.epochs, "organisation": found}
