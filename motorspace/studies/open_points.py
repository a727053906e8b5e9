"""What the paper leaves open, changed one at a time: does it matter?"""

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any, NamedTuple

from motorspace.analysis.measures import Measure, define
from motorspace.running.jobs import Job, cell
from motorspace.studies.cells import evaluated, system
from motorspace.studies.rows import COMPONENTS, Row, with_worst
from motorspace.studies.study import Budget, Study, Table
from motorspace.studies.tables import columns
from motorspace.training.settings import changed

if TYPE_CHECKING:
    from matplotlib.figure import Figure

define(Measure("open_points.to_mean", "error / error of the mean", goal="low", chance=1.0))


class Change(NamedTuple):
    """What a run sets differently, and what tables call it."""

    title: str
    settings: Mapping[str, Any]


CHANGES = {
    "none": Change("every default", {}),
    "collision-block": Change("collision block", {"collision": "block"}),
    "head-rule-turn": Change("head-rule turn", {"head_rule": "turn"}),
    "head-start-random": Change("head-start random", {"head_start": "random"}),
    "head-start-sensed": Change(
        "head-start random, sensed", {"head_start": "random", "sense_head": True}
    ),
    "layout-four-rooms": Change("layout four_rooms", {"layout": "four_rooms"}),
    "layout-rooms-1": Change("layout rooms:1", {"layout": "rooms:1"}),
    "fixed-trajectories": Change(
        "2,000 trajectories for all epochs", {"resample_each_epoch": False}
    ),
    "motor-scaling-maximum": Change("motor-scaling maximum", {"motor_scaling": "maximum"}),
    "initial-weights-scaled": Change("initial-weights scaled", {"initial_weights": "scaled"}),
    "initial-weights-uniform": Change("initial-weights uniform", {"initial_weights": "uniform"}),
    "schedule-constant": Change(
        "schedule constant", {"schedule": "constant", "learning_rate": 1e-3}
    ),
    "curriculum-0": Change("curriculum 0", {"curriculum": 0.0}),
    "plain-recipe": Change(
        "plain recipe",
        {
            "initial_weights": "uniform",
            "motor_scaling": "maximum",
            "learning_rate": 1e-3,
            "schedule": "constant",
            "curriculum": 0.0,
        },
    ),
}


def jobs(budget: Budget, seeds: int) -> list[Job]:
    """Every change to the holonomic agent with large rotations, where the recipe matters."""
    return [
        Job(
            "open_points",
            cell(change=name),
            changed(system("holonomic", 0.8, budget, seed), change.settings),
            "evaluate",
        )
        for seed in range(seeds)
        for name, change in CHANGES.items()
    ]


def figure(found: Sequence[Row]) -> "Figure":
    """The error over that of the mean, a line for each change."""
    from motorspace.reports.figures.measures import changes_figure

    lines = [
        {"changed": TITLES[str(row.cell["change"])], **row.line("open_points.to_mean")}
        for row in found
    ]
    return changes_figure(lines, "changed", ["open_points.to_mean"])


def rows(found: Sequence[Row]) -> list[Row]:
    """The rows with the worst probe, and the error over that of the mean."""
    return [
        with_worst(row, "probe_r2").with_measures(
            {"open_points.to_mean": row["prediction.error"] / row["prediction.mean"].mean}
        )
        for row in found
    ]


ERRORS = ("change", "prediction.error", "prediction.mean", "prediction.persistence")
HEADS = {"change": "changed", "prediction.error": "error"}
HEADS |= {"prediction.mean": "mean", "prediction.persistence": "persistence"}
HEADS |= {"probe_r2.worst": "worst R²"}
HEADS |= {f"probe_r2.{component}": f"R² {component}" for component in COMPONENTS}
TITLES = {name: change.title for name, change in CHANGES.items()}
PROBES = tuple(f"probe_r2.{component}" for component in COMPONENTS)

STUDY = Study(
    name="open_points",
    question="Do the points that the paper leaves open matter?",
    jobs=jobs,
    measures={"evaluate": evaluated},
    budget="quick",
    rows=rows,
    tables={
        "open_points_short": Table(columns(*ERRORS, "probe_r2.worst", heads=HEADS, titles=TITLES)),
        "open_points": Table(columns(*ERRORS, *PROBES, "seeds", heads=HEADS, titles=TITLES)),
    },
    figures={"open-points": figure},
)
