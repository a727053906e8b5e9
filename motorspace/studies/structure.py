"""Are codes structured like displacements? Both presets in every system, beside baselines."""

from collections.abc import Callable, Sequence
from functools import partial
from typing import TYPE_CHECKING

from motorspace.analysis.measures import Measure, define
from motorspace.running.jobs import Job, Value, cell
from motorspace.studies.cells import CONTINUOUS, LATTICES, ROTATIONS, derived, lattice, system
from motorspace.studies.rows import Numbers, Row, Settings, chosen
from motorspace.studies.structure_figures import FIGURES
from motorspace.studies.study import Budget, Line, Study, Table, Target
from motorspace.studies.tables import columns
from motorspace.training.data import DerivedKind
from motorspace.training.presets import PresetName

if TYPE_CHECKING:
    from motorspace.evaluation.subject import Encode, Subject
    from motorspace.training.run import Run

PRESETS: tuple[PresetName, ...] = ("best", "paper")
FIXED = ("untrained", "raw-motors", "motor-components", "dead-reckoned")
"""Baselines that nothing is trained for."""
TRAINED: tuple[DerivedKind, ...] = ("supervised", "shuffled")
"""Baselines that learn from changed data."""
BASELINE_ROTATION = 0.8
"""The rotation, in units of pi, for which the baselines are measured: they hardly depend on it."""
CLOSED = tuple(r for r in ROTATIONS if r >= BASELINE_ROTATION)
"""Rotations with which orientation is to close into a circle."""

define(
    Measure("collapsed", "collapsed", goal="low", perfect=0.0),
    Measure("structure.to_paper", "error / that of the paper's network", goal="low", chance=1.0),
    # Results of 2026 hold these of the lattice, whose random sequences are often equivalent.
    Measure("random.equivalence_ratio", "equivalence ratio of random sequences", goal="low"),
    Measure("random.equivalence_auc", "AUC of random equivalent pairs", goal="high"),
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
        Job(
            "structure",
            cell(agent="lattice", variant=kind),
            lattice(kind, budget, seed),
            "structure",
        )
        for kind in LATTICES
    ]
    for agent in CONTINUOUS:
        config = system(agent, BASELINE_ROTATION, budget, seed)
        place: dict[str, Value] = {"agent": agent, "rotation": BASELINE_ROTATION}
        found += [
            Job("structure", cell(place, variant=name), config, name, trains=False)
            for name in FIXED
        ]
        found += [
            Job("structure", cell(place, variant=name), derived(config, name), "codes")
            for name in TRAINED
        ]
    return found


def measured(run: "Run", num: int) -> Numbers:
    """The structure of codes, as they are and in standard form, and errors of prediction."""
    from motorspace.evaluation.evaluate import evaluate
    from motorspace.evaluation.structure import measures
    from motorspace.evaluation.subject import subject_of

    found = structure_or_collapse(subject_of(run), run.config.training.seed)
    if not found["collapsed"] and run.config.model.encoder == "matrix_product":
        standard = measures(subject_of(run, standard=True), seed=run.config.training.seed)
        found |= {f"standard.{key}": value for key, value in standard.items()}
    return found | dict(evaluate(run, num=num))


def measured_at(horizon: int, run: "Run", num: int) -> Numbers:
    """The same at one length, whatever lengths the run has learned from."""
    return measured(at_horizon(run, horizon), num)


def at_horizon(run: "Run", horizon: int) -> "Run":
    """The run to be measured at one length, whatever lengths it has learned from."""
    from dataclasses import replace

    from motorspace.training.settings import changed

    return replace(run, config=changed(run.config, {"horizon": horizon, "min_horizon": None}))


def measured_codes(run: "Run", num: int) -> Numbers:
    """The structure of the codes of a run that has learned to predict something else."""
    from motorspace.evaluation.subject import subject_of

    del num
    return structure_or_collapse(subject_of(run), run.config.training.seed)


def measured_baseline(name: str, run: "Run", num: int) -> Numbers:
    """The structure of codes that are not learned: one of `FIXED`."""
    from motorspace.evaluation.subject import subject_of

    del num
    subject = subject_of(run)
    encode = subject.encode if name == "untrained" else _baseline(name, subject)
    return structure_or_collapse(subject._replace(encode=encode), run.config.training.seed)


def _baseline(name: str, subject: "Subject") -> "Encode":
    from motorspace.analysis.coordinates import displacement_coordinates
    from motorspace.analysis.projections import pca
    from motorspace.trajectories.commands import nominal

    match name:
        case "raw-motors":
            return lambda motors: motors.reshape(len(motors), -1)
        case "motor-components":
            return lambda motors: pca(motors.reshape(len(motors), -1), 8).coordinates
    return lambda motors: displacement_coordinates(nominal(subject.agent, motors)).points


def structure_or_collapse(subject: "Subject", seed: int) -> dict[str, float]:
    """The structure of codes; of such as have collapsed only that they have."""
    from motorspace.analysis.inputs import CollapsedCodesError
    from motorspace.evaluation.structure import structure

    try:
        return {"collapsed": 0.0} | structure(subject, seed=seed)
    except CollapsedCodesError:
        # That a network has collapsed is what its run has shown; the runs beside it go on.
        return {"collapsed": 1.0}


def rows(found: Sequence[Row]) -> list[Row]:
    """The rows of every system, both presets first, with the error over the paper's network's."""
    order = (*PRESETS, *TRAINED, *FIXED)
    placed = [
        row
        for agent in CONTINUOUS
        for rotation in ROTATIONS
        for variant in order
        for row in chosen(found, agent=agent, rotation=rotation, variant=variant)
    ]
    placed += [row for row in found if row.cell["agent"] == "lattice"]
    return [_to_paper(row, found) for row in placed]


def _to_paper(row: Row, found: Sequence[Row]) -> Row:
    if row.cell["variant"] not in PRESETS or "rotation" not in row.cell:
        return row
    plain = chosen(found, **{**row.cell, "variant": "paper"})
    ratio = row["prediction.error"] / plain[0]["prediction.error"].mean if plain else None
    return row.with_measures({"structure.to_paper": ratio})


def _of_systems(found: Sequence[Row]) -> list[Row]:
    return [row for row in found if row.cell["agent"] != "lattice"]


def _of_lattices(found: Sequence[Row]) -> list[Row]:
    return chosen(found, agent="lattice")


def _of_best(found: Sequence[Row]) -> list[Row]:
    return chosen(_of_systems(found), variant="best")


def headline(found: Sequence[Row]) -> list[Line]:
    """What the first page shows: means of a few measures for the holonomic agent."""
    shown = chosen(found, agent="holonomic", rotation=BASELINE_ROTATION)
    order = ("raw-motors", "untrained", "supervised", "paper", "best")
    placed = [row for name in order for row in chosen(shown, variant=name)]
    heads = HEADS | {"trustworthiness.20": "trustworthiness"}
    heads |= {"length_error.translation.24": "error at T = 24"}
    heads |= {"prediction.error": "prediction error"}
    return columns("variant", *HEADLINE, heads=heads, titles=TITLES | BOLD, means=True)(placed)


def table(
    choose: Callable[[Sequence[Row]], Sequence[Row]], *keys: str, budget: Budget | None = None
) -> Table:
    """A table of some of the rows."""
    lines = columns(*keys, heads=HEADS, titles=TITLES)
    return Table(lambda found: lines(choose(found)), budget)


CELL = ("agent", "rotation", "variant")
HEADLINE = (
    *("linear_r2.worst", "rank_correlation", "trustworthiness.20"),
    *("length_error.translation.24", "prediction.error"),
)
FULL = (
    *("seeds", "linear_r2.worst", "equivalence_ratio", "equivalence_auc", "rank_correlation"),
    *("partial_motors", "partial_motors_affine", "semipartial_motors"),
    *("normalised_topology_error", "trustworthiness.20", "continuity.20"),
    *("winding_number", "length_ratio", "prediction.error"),
)
SHAPE = (
    *("intrinsic_dimension", "components_95", "nonlinear_r2.worst", "loop_persistence"),
    *("neighbours_to_floor", "composition.linear", "composition.bilinear", "composition.network"),
    *("congruence.left", "congruence.right"),
)
TURNS = (
    *(f"equivalence.{kind}" for kind in ("split_rotation", "split_translation", "undone", "head")),
    *(f"equivalence.full_turns.{count}" for count in range(4)),
)
IN_STANDARD_FORM = (
    "rank_correlation",
    "normalised_topology_error",
    "trustworthiness.20",
    "partial_motors",
    "semipartial_motors",
)
STANDARD = [name for key in IN_STANDARD_FORM for name in (key, f"standard.{key}")]
LENGTHS = tuple(f"length_error.translation.{length}" for length in (1, 2, 3, 6, 12, 24))
HEADS = {"variant": "codes", "prediction.error": "error", "equivalence_auc": "AUC"}
HEADS |= {"equivalence.undone": "there and back"}
HEADS |= {"linear_r2.worst": "linear R²", "nonlinear_r2.worst": "nonlinear R²"}
HEADS |= {key: f"T = {key.rpartition('.')[2]}" for key in LENGTHS}
HEADS |= {key: key.rpartition(".")[2].replace("_", " ") for key in TURNS[:2]}
HEADS |= {"equivalence.head": "head"}
HEADS |= {f"equivalence.full_turns.{n}": f"{n} full turn{'s' * (n != 1)}" for n in range(4)}
BOLD = {"best": "**best**"}
TITLES = {name: name.replace("-", " ") for name in (*FIXED, *LATTICES)}

BEST: Settings = {"agent": CONTINUOUS, "variant": "best"}
TARGETS = (
    Target("linear R² of the worst component", "linear_r2.worst", at_least=0.99, cells=BEST),
    Target("equivalence ratio", "equivalence_ratio", at_most=0.01, cells=BEST),
    Target("AUC of equivalent pairs", "equivalence_auc", at_least=0.99, cells=BEST),
    Target(
        "magnitude of the partial correlation with motors",
        "partial_motors",
        at_most=0.05,
        cells=BEST,
        magnitude=True,
    ),
    Target("normalised D_topo", "normalised_topology_error", at_most=0.1, cells=BEST),
    Target("trustworthiness, k = 20", "trustworthiness.20", at_least=0.98, cells=BEST),
    Target("continuity, k = 20", "continuity.20", at_least=0.98, cells=BEST),
    Target("translation error at T = 24 over T = 6", "length_ratio", at_most=3.0, cells=BEST),
    Target("error over the paper's network's", "structure.to_paper", at_most=1.0, cells=BEST),
    Target("winding number", "winding_number", at_least=1.0, cells={**BEST, "rotation": CLOSED}),
    Target("share of runs whose codes have collapsed", "collapsed", at_most=0.0, cells=BEST),
)

STUDY = Study(
    name="structure",
    question="Are codes structured like displacements?",
    jobs=jobs,
    measures={"structure": measured, "codes": measured_codes}
    | {name: partial(measured_baseline, name) for name in FIXED},
    rows=rows,
    tables={
        "headline": Table(headline),
        "structure": table(_of_systems, *CELL, *FULL),
        "structure_paper_budget": table(_of_systems, *CELL, *FULL, budget="paper"),
        "structure_lattice": table(_of_lattices, "variant", *FULL, budget="paper"),
        "structure_lattice_fifth": table(_of_lattices, "variant", *FULL),
        "structure_shape": table(_of_systems, *CELL, *SHAPE),
        "structure_turns": table(_of_systems, *CELL, *TURNS),
        "structure_lengths": table(_of_systems, *CELL, *LENGTHS),
        "standard_form_short": table(_of_best, *CELL[:2], *STANDARD[:4]),
        "standard_form": table(_of_best, *CELL[:2], *STANDARD),
    },
    targets=TARGETS,
    figures=FIGURES,
)
