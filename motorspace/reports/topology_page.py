"""A page about a topology report: its measures, and the codes to turn by hand."""

import numpy as np
from jaxtyping import Float

from motorspace.analysis.measures import measure
from motorspace.analysis.report import Topology
from motorspace.reports.codes_view import codes_view
from motorspace.reports.figures.codes import codes_figure
from motorspace.reports.page import Section, picture, report_page
from motorspace.reports.tables import report_rows

KEY_MEASURES = (
    "linear_r2.worst",
    "rank_correlation",
    "equivalence_ratio",
    "trustworthiness.20",
    "intrinsic_dimension",
)
"""Those that stand at the top, where they were measured."""
MOST_POINTS = 5000


def topology_page(
    report: Topology,
    coordinates: Float[np.ndarray, "N _"],
    displacements: Float[np.ndarray, "N 3"],
    *,
    what: str = "codes",
) -> str:
    """Returns a report on codes as one self-contained page.

    Args:
        report: What `topology` returns.
        coordinates: [N, P], the codes on their principal components.
        displacements: [N, 3]: longitudinal, lateral (world units), orientation change (radians).
        what: What the codes are called.
    """
    step = -(-len(coordinates) // MOST_POINTS)
    rows = report_rows(report)
    facts = [(measure(key).label, report[key].mean) for key in KEY_MEASURES if key in report]
    shown, moved = coordinates[::step], displacements[::step]
    sections = [
        Section(
            "At a glance",
            f"{report.num_points:,} {what} were compared with the displacements of their motor"
            " sequences. Each point is one sequence, on the first three principal components;"
            " drag to turn.",
            facts=facts,
            views=[codes_view(coordinates, displacements)],
        ),
        Section(
            "By component",
            "Opaque points lie in five narrow ranges of the component shown.",
            pictures=[picture("Codes by displacement", lambda: codes_figure([("", shown, moved)]))],
        ),
        Section(
            "All measures",
            "Displacement is (longitudinal, lateral, w cos, w sin) with"
            f" w = {report.weight:.3g}. Values are ± the standard error of drawing random subsets"
            " of pairs.",
            rows=rows,
        ),
    ]
    return report_page(
        f"How the structure of {what} follows displacement",
        sections,
        lead="Perfect codes are an isometric copy of displacements; chance is what codes have that"
        " know nothing of them.",
    )
