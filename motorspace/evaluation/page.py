"""The report on codes as one self-contained page."""

from motorspace.analysis.measures import measure
from motorspace.analysis.projections import pca
from motorspace.evaluation.structure import Sampled
from motorspace.reports import figures
from motorspace.reports.page import Section, report_page

SHOWN = 5000
MEASURES_TEXT = (
    "Displacement is (longitudinal, lateral, w cos, w sin); the weight w gives orientation the "
    "variance of translation unless another was asked for. The error is the standard error of "
    "drawing random subsets of pairs."
)


def topology_page(found: Sampled, *, what: str = "codes") -> str:
    """The report as HTML; `what` it is about."""
    rows = [
        {
            "measure": measure(key).label,
            "value": float(value),
            "error": value.standard_error,
            "perfect": measure(key).perfect,
        }
        for key, value in found.topology.items()
    ]
    shown = slice(None, None, -(-len(found.codes) // SHOWN))
    coordinates, displacements = pca(found.codes).coordinates[shown], found.displacements[shown]
    picture = figures.png(figures.codes_figure([("", coordinates, displacements)]))
    return report_page(
        f"How {what} are structured by displacement",
        [
            Section("Measures", MEASURES_TEXT, rows),
            Section(
                "The codes",
                "Each point is one motor sequence, on the first three principal components.",
                pictures=[("codes coloured by displacement", picture)],
            ),
        ],
    )
