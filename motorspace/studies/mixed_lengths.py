"""What `best` gains from trajectories of many lengths, in place of six commands."""

from collections.abc import Sequence
from functools import partial

from motorspace.running.jobs import Job, cell
from motorspace.studies.cells import system
from motorspace.studies.rows import Row, chosen
from motorspace.studies.structure import measured_at
from motorspace.studies.study import Budget, Line, Study, Table
from motorspace.studies.tables import columns
from motorspace.training.settings import changed

ROTATIONS = (0.2, 0.4)
"""Where `best`, trained on six commands, errs most about twenty-four."""


def jobs(budget: Budget, seeds: int) -> list[Job]:
    """`best` on sequences of one to twelve commands, measured at six as elsewhere."""
    return [
        Job(
            "mixed_lengths",
            cell(rotation=rotation),
            changed(
                system("forward", rotation, budget, seed, "best"),
                {"min_horizon": 1, "horizon": 12},
            ),
            "structure",
        )
        for seed in range(seeds)
        for rotation in ROTATIONS
    ]


def rows(found: Sequence[Row]) -> list[Row]:
    """Each rotation, trained on six commands and on many lengths."""
    return [
        row
        for rotation in ROTATIONS
        for row in (
            *chosen(found, "structure", agent="forward", rotation=rotation, variant="best"),
            *chosen(found, "mixed_lengths", rotation=rotation),
        )
    ]


def _lines(*keys: str) -> Table:
    def lines(found: Sequence[Row]) -> list[Line]:
        trained = {"structure": "T = 6", "mixed_lengths": "T = 1 to 12"}
        made = columns("rotation", *keys, heads=HEADS)(found)
        return [
            {"r": line.pop("r"), "trained at": trained[row.study]} | line
            for row, line in zip(found, map(dict, made), strict=True)
        ]

    return Table(lines)


LENGTHS = tuple(f"length_error.translation.{length}" for length in (1, 6, 12, 24))
HEADS = {key: f"T = {key.rpartition('.')[2]}" for key in LENGTHS}
HEADS |= {"prediction.error": "error", "linear_r2.worst": "linear R²"}
HEADS |= {"length_ratio": "T = 24 / T = 6"}

STUDY = Study(
    name="mixed_lengths",
    question="What does `best` gain from sequences of many lengths?",
    jobs=jobs,
    measures={"structure": partial(measured_at, 6)},
    beside=("structure",),
    rows=rows,
    tables={
        "mixed_lengths_short": _lines("prediction.error", "linear_r2.worst", *LENGTHS[1::2]),
        "mixed_lengths": _lines(
            "seeds", "prediction.error", "linear_r2.worst", *LENGTHS, "length_ratio"
        ),
    },
)
