"""What makes codes more structured: one change at a time to either preset."""

from collections.abc import Mapping, Sequence
from functools import partial
from typing import TYPE_CHECKING, Any

from motorspace.running.jobs import Job, cell
from motorspace.studies.cells import system
from motorspace.studies.rows import Row, chosen
from motorspace.studies.structure import measured_at
from motorspace.studies.study import Budget, Study, Table
from motorspace.studies.tables import columns
from motorspace.training.presets import PresetName
from motorspace.training.settings import changed

if TYPE_CHECKING:
    from matplotlib.figure import Figure

AGENT, ROTATION = "holonomic", 0.8
CHANGES: Mapping[str, Mapping[str, Any]] = {
    "smaller-step": {"learning_rate": 3e-3},
    "shorter-curriculum": {"curriculum": 0.1},
    "code-noise": {"code_noise": 0.3},
    "mixed-horizons": {"min_horizon": 1},
    "smaller-code": {"code_size": 10},
    "inverse-model": {"inverse_weight": 0.04},
    "slowness": {"slowness_weight": 0.04},
    "composition": {"composition_weight": 0.1},
    "gru": {"encoder": "gru"},
    "linear-recurrence": {"encoder": "linear"},
    "attention": {"encoder": "attention"},
    "attention-smaller-step": {"encoder": "attention", "learning_rate": 1e-3},
}
"""What is changed in the preset `paper`."""
CHANGES_OF_BEST: Mapping[str, Mapping[str, Any]] = {
    "matrices-no-noise": {"code_noise": 0.0},
    "matrices-no-isometry": {"isometry_weight": 0.0},
    "matrices-6x6": {"code_size": 30},
}
"""What is changed in the preset `best`."""
CHANGED: tuple[tuple[PresetName, Mapping[str, Mapping[str, Any]]], ...] = (
    ("paper", CHANGES),
    ("best", CHANGES_OF_BEST),
)
TITLES = {
    **{name: name.replace("-", " ") for name in (*CHANGES, *CHANGES_OF_BEST)},
    "code-noise": "noise on the code",
    "gru": "GRU",
    "attention-smaller-step": "attention, step of 1e-3",
    "matrices-no-noise": "matrices, no noise",
    "matrices-no-isometry": "matrices, no isometry",
    "matrices-6x6": "matrices of 6 x 6",
}


def jobs(budget: Budget, seeds: int) -> list[Job]:
    """Every change, to the holonomic agent with large rotations."""
    return [
        Job("ablation", cell(change=name), changed(base, settings), "structure")
        for seed in range(seeds)
        for preset, changes in CHANGED
        for base in [system(AGENT, ROTATION, budget, seed, preset)]
        for name, settings in changes.items()
    ]


def rows(found: Sequence[Row]) -> list[Row]:
    """The changes, between the two presets."""
    base = {
        name: chosen(found, "structure", agent=AGENT, rotation=ROTATION, variant=name)
        for name in ("paper", "best")
    }
    own = chosen(found, "ablation")
    return [*base["paper"], *own, *base["best"]]


def figure(found: Sequence[Row]) -> "Figure":
    """The main measures, a line for each change."""
    from motorspace.reports.figures.measures import changes_figure

    keys = ("prediction.error", "linear_r2.worst", "equivalence_ratio", "normalised_topology_error")
    lines = [{"changed": _name(row)} | row.line(*keys) for row in found]
    return changes_figure(lines, "changed", keys)


def _name(row: Row) -> str:
    name = str(row.cell.get("change", row.cell.get("variant")))
    return TITLES.get(name, name)


def _table(*keys: str) -> Table:
    lines = columns(*keys, heads=HEADS)
    return Table(
        lambda found: [
            {"changed": _name(row), **line} for row, line in zip(found, lines(found), strict=True)
        ]
    )


SHORT = (
    *("prediction.error", "linear_r2.worst", "equivalence_ratio", "normalised_topology_error"),
    "length_error.translation.24",
)
FULL = (
    *("seeds", "prediction.error", "linear_r2.worst", "equivalence_ratio", "equivalence_auc"),
    *("partial_motors", "normalised_topology_error", "trustworthiness.20"),
    *(f"length_error.translation.{length}" for length in (1, 6, 24)),
)
HEADS = {"prediction.error": "error", "linear_r2.worst": "linear R²", "equivalence_auc": "AUC"}
HEADS |= {key: f"T = {key.rpartition('.')[2]}" for key in FULL if key.startswith("length_error")}

STUDY = Study(
    name="ablation",
    question="What makes codes more structured?",
    jobs=jobs,
    measures={"structure": partial(measured_at, 6)},
    beside=("structure",),
    rows=rows,
    tables={"ablation_short": _table(*SHORT), "ablation": _table(*FULL)},
    figures={"ablation": figure},
)
