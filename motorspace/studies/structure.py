"""Are codes structured like displacements? Both presets in every system, beside baselines."""

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING

from motorspace.analysis.measures import Measure, define
from motorspace.running.jobs import Job, cell
from motorspace.studies.cells import CONTINUOUS, LATTICES, ROTATIONS, derived, lattice, system
from motorspace.studies.rows import Row, Spread, chosen, with_worst
from motorspace.studies.structure_figures import FIGURES
from motorspace.studies.study import Budget, Line, Study, Table, Target
from motorspace.studies.tables import columns
from motorspace.training.presets import PRESETS

if TYPE_CHECKING:
    from motorspace.evaluation.structure import Encode, Subject
    from motorspace.training.run import Run

FIXED = ("untrained", "raw-motors", "motor-components", "dead-reckoned")
"""Baselines that nothing is trained for."""
TRAINED = ("supervised", "shuffled")
"""Baselines that learn from changed data."""
BASELINE_ROTATION = 0.8
"""The rotation, in units of pi, for which the baselines are measured: they hardly depend on it."""
CLOSED = tuple(r for r in ROTATIONS if r >= BASELINE_ROTATION)
"""Rotations with which orientation is to close into a circle."""

define(
    Measure("collapsed", "collapsed", goal="low", perfect=0),
    Measure("structure.to_paper", "error / that of the paper's network", goal="low", chance=1),
    Measure("orientation_weight", "weight of orientation", unit="world units"),
)


def jobs(budget: Budget, seeds: int) -> list[Job]:
    """Every system, lattice and baseline, one seed of all before the next seed."""
    return [job for seed in range(seeds) for job in _of_seed(budget, seed)]


def _of_seed(budget: Budget, seed: int) -> list[Job]:
    places = [(agent, rotation) for rotation in ROTATIONS for agent in CONTINUOUS]
    found = [
        Job(
            "structure",
            cell(agent=agent, rotation=rotation, variant=preset),
            system(agent, rotation, budget, seed, preset),
            "structure",
        )
        for preset in PRESETS
        for agent, rotation in places
    ]
    found += [
        Job("structure", cell(agent="lattice", variant=kind), lattice(kind, budget, seed), "structure")
        for kind in LATTICES
    ]
    for agent in CONTINUOUS:
        config = system(agent, BASELINE_ROTATION, budget, seed)
        place = {"agent": agent, "rotation": BASELINE_ROTATION}
        found += [
            Job("structure", cell(place, variant=name), config, name, trains=False)
            for name in FIXED
        ]
        found += [
            Job("structure", cell(place, variant=name), derived(config, name), "codes")
            for name in TRAINED
        ]
    return found


def measured(run: "Run", num: int) -> Mapping[str, float]:
    """The structure of codes, as they are and in standard form, and errors of prediction."""
    from motorspace.evaluation.evaluate import evaluate
    from motorspace.evaluation.structure import measures, subject_of

    found = structure_or_collapse(subject_of(run), run.config.training.seed)
    if not found["collapsed"] and run.config.model.encoder == "matrix_product":
        standard = measures(subject_of(run, standard=True), seed=run.config.training.seed)
        found |= {f"standard.{key}": value for key, value in standard.items()}
    return found | dict(evaluate(run, num=num))


def measured_at(horizon: int, run: "Run", num: int) -> Mapping[str, float]:
    """The same at one length, whatever lengths the run has learned from."""
    from dataclasses import replace

    from motorspace.training.settings import changed

    config = changed(run.config, {"horizon": horizon, "min_horizon": None})
    return measured(replace(run, config=config), num)


def measured_codes(run: "Run", num: int) -> Mapping[str, float]:
    """The structure of the codes of a run that has learned to predict something else."""
    from motorspace.evaluation.structure import subject_of

    del num
    return structure_or_collapse(subject_of(run), run.config.training.seed)


def measured_baseline(name: str, run: "Run", num: int) -> Mapping[str, float]:
    """The structure of codes that are not learned: one of `FIXED`."""
    from motorspace.evaluation.structure import subject_of

    del num
    subject = subject_of(run)
    encode = subject.encode if name == "untrained" else _baseline(name, subject)
    return structure_or_collapse(subject._replace(encode=encode), run.config.training.seed)


def _baseline(name: str, subject: "Subject") -> "Encode":
    from motorspace.analysis.coordinates import displacement_coordinates
    from motorspace.analysis.projections import pca
    from motorspace.trajectories.commands import nominal_displacements

    match name:
        case "raw-motors":
            return lambda motors: motors.reshape(len(motors), -1)
        case "motor-components":
            return lambda motors: pca(motors.reshape(len(motors), -1), 8).coordinates
    return lambda motors: displacement_coordinates(
        nominal_displacements(subject.agent, motors)
    ).points


def structure_or_collapse(subject: "Subject", seed: int) -> dict[str, float]:
    """The structure of codes; of such as have collapsed only that they have."""
    from motorspace.analysis.coordinates import CollapsedCodesError
    from motorspace.evaluation.structure import structure

    try:
        return {"collapsed": 0.0} | structure(subject, seed=seed)
    except CollapsedCodesError:
        # That a network has collapsed is what its run has shown; the runs beside it go on.
        return {"collapsed": 1.0}


def rows(found: Sequence[Row]) -> list[Row]:
    """The rows of every system, both presets first, with the error over the paper's network's."""
    order = (*reversed(PRESETS), *TRAINED, *FIXED)
    placed = [
        row
        for agent in CONTINUOUS
        for rotation in ROTATIONS
        for variant in order
        for row in chosen(found, agent=agent, rotation=rotation, variant=variant)
    ]
    placed += [row for row in found if row.cell["agent"] == "lattice"]
    return [with_worst(_to_paper(row, found), "linear_r2", "nonlinear_r2") for row in placed]


def _to_paper(row: Row, found: Sequence[Row]) -> Row:
    if row.cell["variant"] not in PRESETS or "rotation" not in row.cell:
        return row
    plain = chosen(found, **{**row.cell, "variant": "paper"})
    ratio = row["prediction.error"] / plain[0]["prediction.error"].mean if plain else None
    return row.with_measures({"structure.to_paper": ratio})
...
