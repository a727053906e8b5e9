"""A page about a map that was put together from codes and readings."""

from collections.abc import Mapping, Sequence

import numpy as np
from jaxtyping import Float

from motorspace.analysis.measures import measure
from motorspace.reports.figures.maps import MapPanel, map_figure, paths_figure
from motorspace.reports.page import Section, picture, report_page

KEY_MEASURES = ("path.ate", "map.iou", "loops.precision", "loops.recall")
"""Those that stand at the top, where truth is known."""


def map_page(
    name: str,
    panels: Sequence[MapPanel],
    paths: dict[str, Float[np.ndarray, "2 N"]],
    scores: Mapping[str, Mapping[str, float]],
) -> str:
    """Returns a map, how it came about, and how good it is as one self-contained page.

    Args:
        name: Of the walk.
        panels: The map and, where poses are known, the readings drawn at the true ones.
        paths: The walk by each kind of odometry, and in truth.
        scores: {path: {measure: value}}, where truth is known.
    """
    final = scores.get("with loops", {})
    rows = [
        {"path": kind} | {measure(key).title: f"{value:.3g}" for key, value in found.items()}
        for kind, found in scores.items()
    ]
    known = "" if scores else " The walk's true poses are not known, so nothing here is scored."
    sections = [
        Section(
            "The map",
            "Dark cells hold something, pale ones are empty. The line is the walk; thin lines join"
            f" places that were recognised as one another.{known}",
            facts=[(measure(key).label, final[key]) for key in KEY_MEASURES if key in final],
            pictures=[picture("The map, from first to last", lambda: map_figure(panels))],
        ),
        Section(
            "The way",
            "*Chained codes* are the products of the encoder's matrices, *corrected* is what is"
            " left when matches of neighbouring scans have said what the motors get wrong.",
            rows=rows,
            pictures=[picture("The walk by each kind of odometry", lambda: paths_figure(paths))],
        ),
    ]
    return report_page(f"A map without odometry: {name}", sections)
