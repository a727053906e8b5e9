"""Codes in three dimensions that are turned by hand, as a piece of a web page."""

import json
from html import escape
from importlib.resources import files
from itertools import count
from typing import NamedTuple

import numpy as np
from jaxtyping import Float
from matplotlib import colormaps
from matplotlib.colors import Colormap, to_hex

from motorspace.reports.figures.codes import angle_ticks, colour_scale, three_columns
from motorspace.reports.figures.style import UNIFORM

MOST_POINTS = 3000
COMPONENTS = ("longitudinal", "lateral", "orientation")
STOPS = 17
"""Colours that a colour map is sent with."""

_numbers = count()


class View(NamedTuple):
    """A piece of HTML that shows itself with the help of scripts, which a page holds once."""

    html: str


def codes_view(
    coordinates: Float[np.ndarray, "N _"],
    displacements: Float[np.ndarray, "N 3"],
    title: str = "",
    *,
    axis_name: str = "PC",
) -> View:
    """Returns codes to turn by hand, coloured by one component of the displacement at a time.

    Args:
        coordinates: [N, P]; the first three are shown. Of more than `MOST_POINTS` codes a part,
            evenly spread over the rows.
        displacements: [N, 3]: longitudinal, lateral (world units), orientation change (radians).
        title: What stands above.
        axis_name: What the coordinates are called: PC for principal components.
    """
    step = -(-len(coordinates) // MOST_POINTS)
    points, moved = three_columns(coordinates)[::step], np.asarray(displacements, float)[::step]
    moved = np.column_stack([moved[:, :2], (moved[:, 2] + np.pi) % (2 * np.pi) - np.pi])
    data = {
        "points": _rounded(points / max(float(np.abs(points).max()), 1e-30)),
        "moved": _rounded(moved),
        "scales": [_colours(moved[:, i], map) for i, map in enumerate(UNIFORM)],
        "axes": [f"{axis_name} {i}" for i in (1, 2, 3)],
    }
    name = f"codes-{next(_numbers)}"
    buttons = "".join(
        f'<button type="button" data-component="{i}" aria-pressed="{str(not i).lower()}">'
        f"{component}</button>"
        for i, component in enumerate(COMPONENTS)
    )
    return View(
        f'<figure class="codes-view" id="{name}"><figcaption>{escape(title)}</figcaption>'
        f'<div class="switch" role="group" aria-label="coloured by">{buttons}</div>'
        f'<div class="scene" role="img" aria-label="{escape(title)}: codes in three dimensions">'
        f'</div><script type="application/json">{json.dumps(data, separators=(",", ":"))}</script>'
        "</figure>"
    )


def view_scripts() -> str:
    """Returns the scripts that views need, for the end of a page that holds any."""
    from plotly.offline import get_plotlyjs

    own = files(__package__).joinpath("codes_view.js").read_text("utf-8")
    return f"<script>{get_plotlyjs()}</script>\n<script>{own}</script>"


def _rounded(values: Float[np.ndarray, "N 3"]) -> list[list[float]]:
    """Three columns, with as many digits as can be seen."""
    return [[float(f"{v:.4g}") for v in column] for column in values.T]


def _colours(value: Float[np.ndarray, " N"], colours: str | Colormap) -> dict[str, object]:
    """A colour map as stops between the ends of its scale."""
    scale = colour_scale(value, colours)
    chosen = colormaps[scale["cmap"]] if isinstance(scale["cmap"], str) else scale["cmap"]
    stops = np.linspace(0, 1, STOPS)
    ticks = angle_ticks((scale["vmin"], scale["vmax"]))
    return {
        "low": scale["vmin"],
        "high": scale["vmax"],
        "ticks": [*ticks] or None,
        "names": [*ticks.values()] or None,
        "stops": [[float(stop), to_hex(chosen(stop))] for stop in stops],
    }
