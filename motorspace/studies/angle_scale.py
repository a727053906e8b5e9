"""Is the scale of rotation identifiable from prediction?

The predictor's command is the displacement that a forward agent would compute which takes all
its rotations for some factor times what they are.
"""

from collections.abc import Sequence
from typing import TYPE_CHECKING

from motorspace.analysis.measures import Measure, define
from motorspace.running.jobs import Job, cell
from motorspace.studies.cells import derived, system
from motorspace.studies.rows import Numbers, Row, Spread, chosen, paired
from motorspace.studies.study import Budget, Line, Study, Table
from motorspace.studies.tables import columns
from motorspace.training.settings import changed

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from motorspace._types import Key
    from motorspace.training.run import Run
    from motorspace.trajectories.transitions import Experience

ANGLES = (0.8, 0.9, 1.0, 1.1, 1.25)
ROTATIONS = (0.2, 0.8)

define(Measure("angle_scale.ratio", "error / that of the right scale", goal="low", perfect=1.0))


def jobs(budget: Budget, seeds: int) -> list[Job]:
    """A predictor for every factor, at a small and at a large rotation."""
    return [
        Job(
            "angle_scale",
            cell(rotation=rotation, angle=angle),
            changed(
                derived(system("forward", rotation, budget, seed), "scaled_rotations", angle=angle),
                {"encoder": "identity", "curriculum": 0.0},
            ),
            "errors",
        )
        for seed in range(seeds)
        for rotation in ROTATIONS
        for angle in ANGLES
    ]


def measured(run: "Run", num: int) -> Numbers:
    """Errors of prediction from such displacements."""
    from motorspace.evaluation.prediction import prediction_errors
    from motorspace.evaluation.sampling import draw_test, test_key
    from motorspace.training.data import Derived
    from motorspace.training.sources import derive

    data = run.config.data
    assert isinstance(data, Derived)

    def draw(key: "Key", count: int) -> "Experience":
        return derive(data, draw_test(data, count, key=key), key=key)

    return prediction_errors(run.predict, draw, num=num, key=test_key(run.config.training.seed))


def rows(found: Sequence[Row]) -> list[Row]:
    """The rows with their error over that of the right scale.

    Seeds share their data and initial weights: what differs is the angle alone.
    """
    return [
        row.with_measures({"angle_scale.ratio": ratio_to(right, row)})
        for rotation in ROTATIONS
        for right in chosen(found, rotation=rotation, angle=1.0)
        for row in chosen(found, rotation=rotation)
    ]


def ratio_to(right: Row, row: Row) -> Spread:
    """The errors of a row over those of the right scale, seed by seed."""
    key = "prediction.error"
    return Spread(tuple(own[key] / exact[key] for own, exact in paired(row, right)))


def percent(found: Sequence[Row]) -> list[Line]:
    """The errors, and by how many percent they are above that of the right scale."""
    lines = columns("rotation", "angle", "prediction.error", heads=HEADS)(found)
    return [
        {
            **line,
            "increase, %": above(row["angle_scale.ratio"]).ends,
        }
        for row, line in zip(found, lines, strict=True)
    ]


def above(ratio: Spread) -> Spread:
    """By how many percent a ratio is above one."""
    return Spread(tuple(100 * (value - 1) for value in ratio.values))


def figure(found: Sequence[Row]) -> "Figure":
    """How much worse the sensors are predicted where angles are wrong by a factor."""
    from motorspace.reports.figures.measures import Axis, curves_figure

    key = "angle_scale.ratio"
    lines = [row.line(key) | {"r": f"r = {row.cell['rotation']} π"} for row in found]
    return curves_figure(lines, Axis("angle", "factor on all rotations"), [key], series=("r",))


HEADS = {"angle": "rotations scaled by", "prediction.error": "error"}

STUDY = Study(
    name="angle_scale",
    question="Is the scale of rotation identifiable from prediction?",
    jobs=jobs,
    measures={"errors": measured},
    rows=rows,
    tables={"angle_scale": Table(percent)},
    figures={"angle-scale": figure},
)
