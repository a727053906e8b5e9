"""Do equivalent rotations close the space of codes?

Agents that can all turn by any angle, with and without going round more than once. In the first
and the third a net turn beyond half a circle does not happen, so no two rotations are
equivalent. If equivalent rotations are what bends the space, it stays flat and open there.
"""

from collections.abc import Sequence
from typing import TYPE_CHECKING

from motorspace.running.jobs import Job, cell
from motorspace.studies.cells import evaluated, system
from motorspace.studies.rows import Numbers, Row
from motorspace.studies.study import Budget, Study, Table
from motorspace.studies.tables import columns
from motorspace.training.settings import changed

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from motorspace.training.run import Run

CELLS = ((1, 1.0), (1, 1.2), (2, 0.5), (2, 1.0))
"""Commands in a sequence, and the largest rotation of each, units of pi."""


def jobs(budget: Budget, seeds: int) -> list[Job]:
    """The forward agent with each length and rotation."""
    return [
        Job(
            "closing",
            cell(horizon=horizon, rotation=rotation),
            changed(system("forward", rotation, budget, seed), {"horizon": horizon}),
            "closing",
        )
        for seed in range(seeds)
        for horizon, rotation in CELLS
    ]


def measured(run: "Run", num: int) -> Numbers:
    """Errors of prediction, and whether orientation closes in the codes."""
    from motorspace.analysis import circle
    from motorspace.analysis.coordinates import displacement_coordinates
    from motorspace.evaluation.structure import sampled, values
    from motorspace.evaluation.subject import subject_of

    found = sampled(subject_of(run), seed=run.config.training.seed, subsets=1)
    points, turns = displacement_coordinates(found.displacements).points, found.displacements[:, 2]
    of_interest = ("winding_number", "loop_persistence", "linear_r2.", "nonlinear_r2.")
    report = {k: v for k, v in values(found.topology).items() if k.startswith(of_interest)}
    gap = {"seam_gap": circle.seam_gap(found.codes, points, turns)}
    return dict(evaluated(run, num)) | report | gap


def figure(found: Sequence[Row]) -> "Figure":
    """The seam's gap and the loop's persistence, a line for each way to turn."""
    from motorspace.reports.figures.measures import changes_figure

    keys = ("seam_gap", "loop_persistence")
    lines = [{"turns": row.name} | row.line(*keys) for row in found]
    return changes_figure(lines, "turns", keys)


SHORT = (
    "horizon",
    "rotation",
    "prediction.error",
    "winding_number",
    "seam_gap",
    "loop_persistence",
)
FULL = (*SHORT, "linear_r2.cos", "nonlinear_r2.cos", "seeds", "epochs")
HEADS = {"prediction.error": "error"}

STUDY = Study(
    name="closing",
    question="Do equivalent rotations close the space of codes?",
    jobs=jobs,
    measures={"closing": measured},
    tables={
        "closing_short": Table(columns(*SHORT, heads=HEADS)),
        "closing": Table(columns(*FULL, heads=HEADS)),
    },
    figures={"closing": figure},
)
