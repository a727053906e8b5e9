"""How low can the error of any prediction get that does not know the place?"""

from collections.abc import Sequence
from typing import TYPE_CHECKING

from motorspace.analysis.measures import Measure, define
from motorspace.running.jobs import Job, cell
from motorspace.studies.cells import CONTINUOUS, ROTATIONS, TEST_TRAJECTORIES, system
from motorspace.studies.rows import Numbers, Row
from motorspace.studies.study import Budget, Line, Study, Table
from motorspace.studies.tables import columns

if TYPE_CHECKING:
    from motorspace.training.run import Run

LEFT = ("floor.disagreement", "floor.neighbours")
SQUARED = "sensor units²"
define(
    Measure("floor.error.{poses}", "{poses} poses", goal="low", perfect=0.0, unit=SQUARED),
    Measure("floor.lowest", "lowest of five sets", goal="low", perfect=0.0, unit=SQUARED),
    Measure("floor.highest", "highest of five sets", goal="low", perfect=0.0, unit=SQUARED),
    Measure("floor.standard_error", "standard error", unit=SQUARED),
    Measure("floor.neighbours", "neighbours"),
    Measure("floor.num", "test trajectories"),
)


def jobs(budget: Budget, seeds: int) -> list[Job]:
    """Every system of the paper's table I; nothing is trained, so one seed is enough."""
    return [
        Job(
            "floor",
            cell(agent=agent, rotation=rotation),
            system(agent, rotation, budget, seed),
            "floor",
            trains=False,
        )
        for seed in range(min(seeds, 1))
        for agent in CONTINUOUS
        for rotation in ROTATIONS
    ]


def measured(run: "Run", num: int) -> Numbers:
    """The floor, from as many remembered poses as others have test trajectories."""
    from motorspace.evaluation.floor import measure_floor

    return measure_floor(run.config.data, num_poses=(num // 100, num // 10, num))


def poses(found: Sequence[Row]) -> list[Line]:
    """How the floor comes down with the number of remembered poses."""
    most = TEST_TRAJECTORIES["paper"]
    numbers = [f"floor.error.{num}" for num in (most // 100, most // 10, most)]
    heads = {key: f"{int(key.rpartition('.')[2]):,} poses" for key in numbers}
    return columns("agent", "rotation", *numbers, *LEFT, heads=heads)(found)


STUDY = Study(
    name="floor",
    question="How low can the error get of predicting from sensors and displacement alone?",
    jobs=jobs,
    measures={"floor": measured},
    budget="paper",
    tables={
        "floor": Table(poses),
        "floor_sets": Table(
            columns(
                *("agent", "rotation", "floor.error", "floor.lowest", "floor.highest"),
                *("floor.standard_error", "floor.disagreement", "floor.neighbours", "floor.num"),
            )
        ),
    },
)
