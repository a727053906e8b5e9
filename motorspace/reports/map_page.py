"""A page about a map that was put together from codes and readings."""

from collections.abc import Mapping, Sequence

import numpy as np
from jaxtyping import Float

from motorspace.analysis.measures import measure
from motorspace.reports.figures.maps import MapPanel, map_figure, paths_figure
from motorspace.reports.page import Section, picture, report_page

KEY_MEASURES = ("path.ate", "map.iou", "loops.precision", "loops.recall")
"""Those that stand at the top, where truth is known."""
PATH_MEASURES = ("path.ate", "path.drift", "path.rpe_shift.6", "path.rpe_turn.6")
COVERAGE = ("covariance.68", "covariance.95")


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
    final, corrected = scores.get("with loops", {}), scores.get("corrected", {})
    rows = [
        {"path": kind}
        | {measure(key).title: f"{found[key]:.3g}" for key in PATH_MEASURES if key in found}
        for kind, found in scores.items()
    ]
    loops = panels[0].loops
    known = "" if scores else " The walk's true poses are not known, so nothing here is scored."
    sections = [
        Section(
            "The map",
            "Dark cells hold something, pale ones are empty. The line is the walk; thin lines join"
            f" places that were recognised as one another.{known}",
            facts=[
                (measure("loops.num").label, 0 if loops is None else len(loops)),
                *((measure(key).label, final[key]) for key in KEY_MEASURES if key in final),
            ],
            pictures=[picture("The map", lambda: map_figure(panels))],
        ),
        Section(
            "The way",
            "Chained codes are products of the encoder's matrices, one for each command. The"
            " corrected path is without what the motors get wrong, by matches of neighbouring"
            " scans; its displacements have covariances, within which 68 and 95 of 100 should lie.",
            facts=[(measure(key).label, corrected[key]) for key in COVERAGE if key in corrected],
            rows=rows,
            pictures=[picture("The walk by each kind of odometry", lambda: paths_figure(paths))],
        ),
    ]
    return report_page(f"A map without odometry: {name}", sections)
