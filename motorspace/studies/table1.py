"""The paper's table I: the error of prediction for each agent and largest rotation."""

from collections.abc import Sequence

from motorspace.analysis.measures import Measure, define
from motorspace.running.jobs import Job, cell
from motorspace.studies.cells import (
    CONTINUOUS,
    ROTATIONS,
    evaluated,
    oracle,
    system,
    untrained,
)
from motorspace.studies.rows import COMPONENTS, Row, Spread, chosen
from motorspace.studies.study import Budget, Study, Table, Target
from motorspace.studies.tables import columns

PUBLISHED = {
    "forward": (2.32, 2.41, 2.34, 2.33, 2.35, 2.32),
    "holonomic": (1.54, 2.21, 2.30, 2.32, 2.63, 2.67),
}
"""The mean squared errors of the paper's table I, one for each of `ROTATIONS`."""

VARIANTS = {"paper": lambda config: config, "oracle": oracle, "untrained": untrained}
"""The paper's network, and the baselines that are trained beside it."""

define(
    Measure("table1.oracle", "oracle", goal="low", unit="sensor units²"),
    Measure("table1.untrained", "untrained encoder", goal="low", unit="sensor units²"),
    Measure("table1.to_oracle", "error / oracle", goal="near", perfect=1.0),
    Measure("table1.to_mean", "error / error of the mean", goal="low", chance=1.0),
    Measure("table1.published", "paper", goal="low"),
)


def jobs(budget: Budget, seeds: int) -> list[Job]:
    """Every cell and variant, one seed of all before the next seed."""
    return [
        Job(
            "table1",
            cell(agent=agent, rotation=rotation, variant=variant),
            change(system(agent, rotation, budget, seed)),
            "evaluate",
        )
        for seed in range(seeds)
        for rotation in ROTATIONS
        for agent in CONTINUOUS
        for variant, change in VARIANTS.items()
    ]


def rows(found: Sequence[Row]) -> list[Row]:
    """A row for each system with the paper's network, beside its baselines and its floor."""
    return [
        _beside(row, found)
        for agent in CONTINUOUS
        for row in chosen(found, "table1", agent=agent, variant="paper")
    ]


def _beside(row: Row, found: Sequence[Row]) -> Row:
    place = {"agent": row.cell["agent"], "rotation": row.cell["rotation"]}
    error, mean = row["prediction.error"], row["prediction.mean"].mean

    def other(study: str, key: str, **settings: str) -> Spread | None:
        return next((row.get(key) for row in chosen(found, study, **place, **settings)), None)

    oracle = other("table1", "prediction.error", variant="oracle")
    published = PUBLISHED[str(place["agent"])][ROTATIONS.index(float(place["rotation"]))]
    return row.with_measures(
        {
            "table1.oracle": oracle,
            "table1.untrained": other("table1", "prediction.error", variant="untrained"),
            "floor.error": other("floor", "floor.error"),
            "table1.to_oracle": error / oracle.mean if oracle else None,
            "table1.to_mean": error / mean,
            "table1.published": Spread((published,)),
        }
    )


FULL = (
    "agent",
    "rotation",
    "epochs",
    "prediction.error",
    "table1.oracle",
    "table1.to_oracle",
    "floor.error",
    "table1.untrained",
    "prediction.mean",
    "prediction.persistence",
    "prediction.skill",
    "table1.published",
)
SHORT = ("agent", "rotation", "prediction.error", "table1.oracle", "floor.error")
PROBES = ("agent", "rotation", *(f"probe_r2.{component}" for component in COMPONENTS))
HEADS = {"prediction.error": "error", "floor.error": "floor"}
HEADS |= {"prediction.mean": "mean", "prediction.persistence": "persistence"}
HEADS |= {f"probe_r2.{c}": f"R² {c}" for c in COMPONENTS}


STUDY = Study(
    name="table1",
    question="How well are the sensors predicted, for every agent and range of rotation?",
    jobs=jobs,
    measures={"evaluate": evaluated},
    budget="paper",
    beside=("floor",),
    rows=rows,
    tables={
        "table1_short": Table(columns(*SHORT, "prediction.persistence", heads=HEADS)),
        "table1": Table(columns(*FULL, heads=HEADS)),
        "table1_probes": Table(columns(*PROBES, heads=HEADS)),
    },
    targets=(
        Target("error over that of its oracle", "table1.to_oracle", at_most=1.1, every_seed=True),
        Target(
            "every seed has left the plateau (error over that of the mean)",
            "table1.to_mean",
            at_most=0.85,
            every_seed=True,
        ),
    ),
)
