"""Draw the pictures of the documentation that show results: `python -m docs.figures`."""

from pathlib import Path
from typing import Any

from docs.tables import ROOT, RUNS
from motorspace._files import write_atomically
from motorspace.analysis.measures import Measure, define
from motorspace.experiments import topology_summary
from motorspace.experiments.paper import finished
from motorspace.experiments.topology import REFERENCE_ROTATION
from motorspace.reports.figures.measures import (
    Axis,
    along,
    changes_figure,
    comparison_figure,
    curves_figure,
)
from motorspace.reports.figures.style import png

KEYS = {
    "error": "prediction.error",
    "linear R2": "linear_r2.worst",
    "collapse ratio": "equivalence_ratio",
    "AUC": "equivalence_auc",
    "partial, motors": "partial_motors",
    "partial, affine": "partial_motors_affine",
    "semipartial, motors": "semipartial_motors",
    "rank correlation": "rank_correlation",
    "D_topo": "normalised_topology_error",
    "trustworthiness": "trustworthiness.20",
    "winding": "winding_number",
    "loop": "loop_persistence",
    "seam gap": "seam_gap",
    "ratio": "equivalence.full_turns",
} | {f"T = {n}": f"length_error.translation.{n}" for n in (1, 2, 3, 6, 12, 24)}
KEYS |= {f"{n} full turns": f"equivalence.full_turns.{n}" for n in range(5)}
KEYS |= {f"{name}, standard": f"standard.{key}" for name, key in KEYS.items()}
"""The keys of the columns that the rows of results have."""

TARGETS = {
    "linear_r2.worst": 0.99,
    "equivalence_ratio": 0.01,
    "equivalence_auc": 0.99,
    "partial_motors": 0.05,
    "normalised_topology_error": 0.1,
    "trustworthiness.20": 0.98,
    "winding_number": 1.0,
}
ABLATION = ("prediction.error", "linear_r2.worst", "equivalence_ratio", "normalised_topology_error")
PICTURES = ROOT / "docs" / "pictures"
ROTATION = Axis("rotation", "largest rotation, units of pi")
CELLS = ("agent", "row")

Row = dict[str, Any]


def main() -> None:
    """Draw them all."""
    found = list(finished(RUNS / "fifth"))
    all_rows = topology_summary.topology_rows(found)
    rows = keyed([r for r in all_rows if r["row"] in ("best", "paper") and r["rotation"]])
    for row in rows:
        row["r"], row["codes"] = f"r = {row['rotation']} pi", f"{row['agent']}, {row['row']}"
    turns = along(rows, "equivalence.full_turns", "turns")
    drawn = keyed([r for r in topology_summary.drawn_rows(all_rows) if r["row"] in STROKES])
    folding = keyed(topology_summary.folding_rows(found))
    angles = topology_summary.angle_rows(found)
    at_reference = [row for row in rows if row["rotation"] == REFERENCE_ROTATION]
    lengths = along(at_reference, "length_error.translation", "commands")
    drawn_figures = {
        "topology": curves_figure(
            rows, ROTATION, [*TARGETS, "loop_persistence"], series=CELLS, targets=TARGETS
        ),
        "topology-copies": comparison_figure(
            rows, "partial_motors_affine", "partial_motors", series=CELLS
        ),
        "topology-standard": curves_figure(
            in_both_forms(rows),
            ROTATION,
            ["rank_correlation", "semipartial_motors"],
            series=("agent", "form"),
        ),
        "topology-turns": curves_figure(
            turns,
            Axis("turns", "full turns apart"),
            ["equivalence.full_turns"],
            series=("r",),
            panels="codes",
        ),
        "topology-drawn": curves_figure(
            [row | {"apart": f"{row['turns']} full turns"} for row in drawn],
            Axis("drawn", "share of the sequences drawn", "symlog"),
            ["equivalence.full_turns"],
            series=("apart", "row"),
            panels="agent",
        ),
        "topology-lengths": curves_figure(
            lengths,
            Axis("commands", "commands in a sequence (trained on 6)", "log", mark=6.0),
            ["length_error.translation"],
            series=CELLS,
        ),
        "topology-folding": curves_figure(
            [row | {"apart": f"{row['turns']} full turns apart"} for row in folding],
            "epoch",
            ["equivalence.full_turns"],
            series=("apart",),
            panels="row",
        ),
        "topology-angle": curves_figure(
            [
                {"r": f"r = {row['rotation']} pi", "angle": row["angle"]}
                | {"prediction.error_to_true_angle": row.get("ratio")}
                for row in angles
            ],
            Axis("angle", "factor of all rotations"),
            ["prediction.error_to_true_angle"],
            series=("r",),
        ),
        "topology-closing": changes_figure(
            keyed(topology_summary.closing_rows(found)), "turns", ["seam_gap", "loop_persistence"]
        ),
        "topology-ablation": changes_figure(
            keyed(topology_summary.ablation_rows(found)), "change", ABLATION
        ),
    }
    for name, figure in drawn_figures.items():
        path: Path = PICTURES / f"{name}.png"
        write_atomically(path, png(figure, dots_per_inch=80))


STROKES = ("best", "paper")


def keyed(rows: list[Row]) -> list[Row]:
    """Rows with the keys of measures in place of their columns' titles."""
    return [{KEYS.get(name, name): value for name, value in row.items()} for row in rows]


def in_both_forms(rows: list[Row]) -> list[Row]:
    """Rows as they are, and those of codes in standard form beside them."""
    both = [row | {"form": row["row"]} for row in rows]
    for row in rows:
        standard = {k.removeprefix("standard."): v for k, v in row.items() if "standard." in k}
        if standard:
            labels = {name: row[name] for name in ("agent", "rotation")}
            both.append({**labels, "form": f"{row['row']}, standard form", **standard})
    return both


if __name__ == "__main__":
    define(
        Measure(
            "prediction.error_to_true_angle",
            "prediction error / that with true angles",
            "Of a predictor that is given displacements with scaled rotations.",
            "low",
            1.0,
        )
    )
    main()
