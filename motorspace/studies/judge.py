"""How near to the floor does a judge come that knows the place?"""

from collections.abc import Sequence
from typing import TYPE_CHECKING

from motorspace.analysis.measures import Measure, define
from motorspace.running.jobs import Job, cell
from motorspace.studies.cells import CONTINUOUS, ROTATIONS, system
from motorspace.studies.rows import Numbers, Row, Spread
from motorspace.studies.study import Budget, Study, Table, Target
from motorspace.studies.tables import columns

if TYPE_CHECKING:
    from motorspace.training.run import Run

SQUARED = "sensor units²"
SEVERAL = (("forward", 0.4), ("holonomic", 0.4))
"""Cells that are measured with every seed; the others with one."""
TESTED_SHARE = 1 / 200
"""Test transitions, of those that networks are tested on: each is located on its own."""
define(
    Measure("judge.error", "judge", goal="low", perfect=0.0, unit=SQUARED),
    Measure("judge.error.{steps}", "{steps} steps", goal="low", perfect=0.0, unit=SQUARED),
    Measure("judge.motors", "judge, from commands", goal="low", perfect=0.0, unit=SQUARED),
    Measure("judge.network", "network", goal="low", perfect=0.0, unit=SQUARED),
    Measure("judge.persistence", "no change", goal="low", perfect=0.0, unit=SQUARED),
    Measure("judge.floor", "floor", goal="low", perfect=0.0, unit=SQUARED),
    Measure("judge.unseen", "judge, unseen layout", goal="low", perfect=0.0, unit=SQUARED),
    Measure("judge.unseen_network", "network, unseen layout", goal="low", unit=SQUARED),
    Measure("judge.standard_error", "standard error", unit=SQUARED),
    Measure("judge.calibration_seconds", "calibration", goal="low", unit="s"),
    Measure("judge.seconds.{steps}", "{steps} steps", goal="low", unit="s"),
    Measure("judge.num", "test transitions"),
    Measure("judge.to_floor", "judge / floor", goal="low", perfect=1.0),
    Measure("judge.motors_to_floor", "from commands / floor", goal="low", perfect=1.0),
)


def jobs(budget: Budget, seeds: int) -> list[Job]:
    """Every system of the paper's table I with one seed, two of them with all."""
    return [
        Job(
            "judge",
            cell(agent=agent, rotation=rotation),
            system(agent, rotation, budget, seed, "best"),
            "judge",
        )
        for seed in range(seeds)
        for agent in CONTINUOUS
        for rotation in ROTATIONS
        if seed == 0 or (agent, rotation) in SEVERAL
    ]


def measured(run: "Run", num: int) -> Numbers:
    """The judge's errors after longer and longer walks, and elsewhere."""
    from motorspace.judge.scores import measure_judge

    return measure_judge(run, num=max(1, round(TESTED_SHARE * num)))


def over_floor(found: Sequence[Row]) -> list[Row]:
    """The rows with their errors over the floor, of the same transitions."""
    return [_over_floor(row) for row in found]


def _over_floor(row: Row) -> Row:
    def ratio(key: str) -> Spread | None:
        if key not in row or "judge.floor" not in row:
            return None
        pairs = zip(row[key].values, row["judge.floor"].values, strict=True)
        return Spread(tuple(error / floor for error, floor in pairs))

    names = {"to_floor": "judge.error", "motors_to_floor": "judge.motors"}
    return row.with_measures({f"judge.{name}": ratio(key) for name, key in names.items()})


STEPS = ("judge.error.2000", "judge.error.5000", "judge.error.15000")
STUDY = Study(
    name="judge",
    question="How near to the floor does a prediction come that remembers the place?",
    jobs=jobs,
    measures={"judge": measured},
    rows=over_floor,
    tables={
        "judge": Table(
            columns(
                *("agent", "rotation", "judge.network", *STEPS, "judge.motors", "judge.floor"),
                *("judge.to_floor", "judge.motors_to_floor"),
            )
        ),
        "judge_unseen": Table(columns("agent", "rotation", "judge.unseen", "judge.unseen_network")),
    },
    targets=(Target("error over the floor", "judge.to_floor", at_most=2.0),),
)
