"""Can an agent act in the space of codes?"""

from collections.abc import Sequence
from typing import TYPE_CHECKING

from motorspace.running.jobs import Job, cell
from motorspace.studies.cells import CONTINUOUS, system
from motorspace.studies.rows import Numbers, Row
from motorspace.studies.study import Budget, Study, Table, Target
from motorspace.studies.tables import columns
from motorspace.training.presets import PresetName

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from motorspace.training.run import Run

ROTATIONS = (0.2, 0.4, 0.8)
"""Largest rotations, in units of pi."""
PAPER = ("forward", 0.4)
"""The system whose published network is measured beside `best`."""


def jobs(budget: Budget, seeds: int) -> list[Job]:
    """Both agents with `best`, and one with the paper's network; seed after seed."""
    cells: list[tuple[str, float, PresetName]] = [
        (agent, rotation, "best") for rotation in ROTATIONS for agent in CONTINUOUS
    ]
    cells.append((*PAPER, "paper"))
    return [
        Job(
            "control",
            cell(agent=agent, rotation=rotation, preset=preset),
            system(agent, rotation, budget, seed, preset),
            "control",
        )
        for seed in range(seeds)
        for agent, rotation, preset in cells
    ]


def measured(run: "Run", num: int) -> Numbers:
    """What a controller reaches that learns from the run; a thousand goals of each kind."""
    from motorspace.control.controller import learn_controller
    from motorspace.control.scores import measure_controller

    del num
    return measure_controller(run, learn_controller(run))


def figure(found: Sequence[Row]) -> "Figure":
    """The share of displacement goals that each way to plan reaches."""
    from motorspace.reports.figures.measures import changes_figure

    keys = ("control.success.amortised", "control.success.hybrid", "control.success.cross_entropy")
    lines = [{"system": row.name} | row.line(*keys) for row in found]
    return changes_figure(lines, "system", keys)


CELL = ("agent", "rotation", "preset")
SUCCESS = "control.success"
FREE_SPACE = tuple(f"{SUCCESS}.{kind}" for kind in ("amortised", "best_of_8", "hybrid"))
SEARCH = tuple(
    f"{SUCCESS}.{kind}"
    for kind in ("cross_entropy", "simulated_cross_entropy", "shooting", "simulated_shooting")
)
SENSORS = tuple(f"control.sensors.{kind}" for kind in ("hybrid", "simulated", "stay"))

STUDY = Study(
    name="control",
    question="Can an agent act in the space of codes?",
    jobs=jobs,
    measures={"control": measured},
    tables={
        "control_short": Table(columns(*CELL, *FREE_SPACE)),
        "control": Table(
            columns(
                *CELL,
                *FREE_SPACE,
                *SEARCH,
                f"{SUCCESS}.random",
                f"{SUCCESS}.few_labels",
                f"{SUCCESS}.replanned",
                f"{SUCCESS}.far",
                "control.cost.best_of_8",
                "control.cost.hybrid",
                "control.diversity",
                "seeds",
            )
        ),
        "control_sensors": Table(columns(*CELL, *SENSORS)),
    },
    targets=(
        Target(
            "displacement goals, decoded at once",
            f"{SUCCESS}.amortised",
            at_least=0.96,
            cells={"preset": "best"},
        ),
        Target(
            "displacement goals, decoded and refined",
            f"{SUCCESS}.hybrid",
            at_least=0.985,
            cells={"preset": "best"},
        ),
        Target(
            "cost of it over that of search in the true simulator",
            "control.cost.hybrid",
            at_most=0.2,
            cells={"preset": "best"},
        ),
        Target(
            "diversity of 16 answers", "control.diversity", at_least=0.3, cells={"preset": "best"}
        ),
    ),
    figures={"control": figure},
)
