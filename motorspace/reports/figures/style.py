"""What all pictures share: themes, colours, and how they become files."""

import io
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from contextvars import ContextVar
from functools import wraps
from typing import Any, Literal, ParamSpec, TypeVar

import matplotlib
import numpy as np
from cycler import cycler
from jaxtyping import Float
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.colors import Colormap, ListedColormap
from matplotlib.figure import Figure

P = ParamSpec("P")
R = TypeVar("R")
Theme = Literal["light", "dark"]

INKS = {
    "light": {
        "page": "#ffffff",
        "text": "#1d2433",
        "muted": "#5d6677",
        "grid": "#e3e6ec",
        "pane": "#eef0f4",
    },
    "dark": {
        "page": "#171b23",
        "text": "#e6e9f0",
        "muted": "#9aa3b5",
        "grid": "#2c3340",
        "pane": "#1e232d",
    },
}
"""The page behind a picture, and what is written and drawn on it."""

SERIES = ("#3f74d8", "#e0763a", "#2b9e77", "#8d62d3", "#d14d63", "#1d9bb0", "#b58a1b", "#7a8496")
"""Colours of curves, in order; apart for readers who confuse red and green as well."""

_theme: ContextVar[Theme] = ContextVar("theme", default="light")


@contextmanager
def theme(name: Theme) -> Iterator[None]:
    """Draws all pictures made inside for light or for dark pages; light is the default.

    Example:
        >>> with theme("dark"):
        ...     figure = new_figure(4, 3)
        >>> figure.get_facecolor()[0] < 0.2
        True
    """
    token = _theme.set(name)
    try:
        yield
    finally:
        _theme.reset(token)


def ink(name: Literal["page", "text", "muted", "grid", "pane"]) -> str:
    """Returns a colour of the theme in use."""
    return INKS[_theme.get()][name]


def styled(draw: Callable[P, R]) -> Callable[P, R]:
    """Decorates a function that makes a figure, which gets the style of the theme in use."""

    @wraps(draw)
    def in_style(*args: P.args, **kwargs: P.kwargs) -> R:
        with matplotlib.rc_context(_parameters()):
            return draw(*args, **kwargs)

    return in_style


@styled
def new_figure(width: int | float, height: int | float) -> Figure:
    """Returns an empty figure of this size, in inches."""
    return Figure(figsize=(width, height), layout="constrained")


def png(figure: Figure, *, dots_per_inch: int = 100) -> bytes:
    """Returns the figure as the content of a PNG file."""
    FigureCanvasAgg(figure)
    buffer = io.BytesIO()
    figure.savefig(buffer, format="png", dpi=dots_per_inch)
    return buffer.getvalue()


def _parameters() -> Any:
    """The parameters of matplotlib for the theme in use."""
    page, text, muted, grid = (ink(n) for n in ("page", "text", "muted", "grid"))
    return {
        "figure.facecolor": page,
        "axes.facecolor": page,
        "savefig.facecolor": page,
        "text.color": text,
        "axes.labelcolor": muted,
        "axes.titlecolor": text,
        "axes.edgecolor": grid,
        "axes.grid": True,
        "axes.axisbelow": True,
        "axes.spines.top": False,
        "axes.spines.right": False,
        "axes.prop_cycle": cycler(color=SERIES),
        "axes.titlesize": 11,
        "axes.titlelocation": "left",
        "axes.labelsize": 10,
        "grid.color": grid,
        "grid.linewidth": 0.8,
        "xtick.color": muted,
        "ytick.color": muted,
        "xtick.labelsize": 9,
        "ytick.labelsize": 9,
        "legend.frameon": False,
        "legend.fontsize": 9,
        "lines.linewidth": 1.6,
        "lines.markersize": 4.5,
    }


def hues(num: int, *, lightness: float = 0.72, chroma: float = 0.115) -> Float[np.ndarray, "N 3"]:
    """Returns `num` colours around the circle of hues, equally light, as RGB in [0, 1].

    They are evenly spaced in the colour space OKLab (Ottosson, 2020), so that equal differences of
    angle look equal and none stands out.
    """
    angles = np.linspace(0, 2 * np.pi, num, endpoint=False)
    a, b = chroma * np.cos(angles), chroma * np.sin(angles)
    to_cones = np.array(
        [
            [0.3963377774, 0.2158037573],
            [-0.1055613458, -0.0638541728],
            [-0.0894841775, -1.291485548],
        ]
    )
    cones = (lightness + np.stack([a, b], axis=1) @ to_cones.T) ** 3
    to_rgb = np.array(
        [
            [4.0767416621, -3.3077115913, 0.2309699292],
            [-1.2684380046, 2.6097574011, -0.3413193965],
            [-0.0041960863, -0.7034186147, 1.707614701],
        ]
    )
    linear = np.clip(cones @ to_rgb.T, 0, 1)
    return np.where(linear < 0.0031308, 12.92 * linear, 1.055 * linear ** (1 / 2.4) - 0.055)


CYCLIC: Colormap = ListedColormap(hues(256), name="hues")
"""For angles: it ends with the colour that it begins with."""

UNIFORM: tuple[str | Colormap, ...] = ("viridis", "viridis", CYCLIC)
"""Perceptually uniform colour maps for longitudinal and lateral displacement and orientation."""

JET: tuple[str | Colormap, ...] = ("jet", "jet", "jet")
"""Those of the paper, to compare with its figures."""
