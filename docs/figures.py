"""Draw the pictures of the documentation that show results: `python -m docs.figures`."""

from pathlib import Path

from docs.tables import ROOT, RUNS
from motorspace._files import write_atomically
from motorspace.experiments import topology_summary
from motorspace.experiments.paper import finished
from motorspace.experiments.topology import REFERENCE_ROTATION
from motorspace.reports import topology_figures
from motorspace.reports.figures import png

CLOSING = {"seam gap": "seam gap (1: closed)", "loop": "loop persistence (1: a circle)"}
ABLATION = {
    "error": "prediction error",
    "linear R2": "R2 of the worst component",
    "collapse ratio": "collapse ratio",
    "D_topo": "normalised D_topo",
}

PICTURES = ROOT / "docs" / "pictures"


def main() -> None:
    """Draw them all."""
    found = list(finished(RUNS / "fifth"))
    rows = topology_summary.topology_rows(found)
    closing, ablation = topology_summary.closing_rows(found), topology_summary.ablation_rows(found)
    angles = topology_summary.angle_rows(found)
    drawn = {
        "topology": topology_figures.organisation_figure(rows),
        "topology-copies": topology_figures.copies_figure(rows),
        "topology-standard": topology_figures.standard_figure(rows),
        "topology-turns": topology_figures.turns_figure(rows),
        "topology-drawn": topology_figures.drawn_figure(topology_summary.drawn_rows(rows)),
        "topology-lengths": topology_figures.lengths_figure(rows, rotation=REFERENCE_ROTATION),
        "topology-folding": topology_figures.folding_figure(topology_summary.folding_rows(found)),
        "topology-angle": topology_figures.angle_figure(angles),
        "topology-closing": topology_figures.changes_figure(closing, "turns", CLOSING),
        "topology-ablation": topology_figures.changes_figure(ablation, "change", ABLATION),
    }
    for name, figure in drawn.items():
        path: Path = PICTURES / f"{name}.png"
        write_atomically(path, png(figure, dots_per_inch=80))


if __name__ == "__main__":
    main()
