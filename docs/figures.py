"""Draw the pictures of the documentation that show results: `python -m docs.figures`."""

from pathlib import Path

from docs.tables import ROOT, RUNS
from motorspace._files import write_atomically
from motorspace.experiments import topology_summary
from motorspace.experiments.paper import finished
from motorspace.experiments.topology import REFERENCE_ROTATION
from motorspace.reports import topology_figures
from motorspace.reports.figures import png

PICTURES = ROOT / "docs" / "pictures"


def main() -> None:
    """Draw them all."""
    found = list(finished(RUNS / "fifth"))
    rows = topology_summary.topology_rows(found)
    drawn = {
        "topology": topology_figures.organisation_figure(rows),
        "topology-turns": topology_figures.turns_figure(rows),
        "topology-lengths": topology_figures.lengths_figure(rows, rotation=REFERENCE_ROTATION),
        "topology-folding": topology_figures.folding_figure(topology_summary.folding_rows(found)),
    }
    for name, figure in drawn.items():
        path: Path = PICTURES / f"{name}.png"
        write_atomically(path, png(figure, dots_per_inch=80))


if __name__ == "__main__":
    main()
