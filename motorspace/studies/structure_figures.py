"""How the structure of codes changes with the largest rotation and the length of sequences."""

from collections.abc import Callable, Mapping, Sequence
from typing import TYPE_CHECKING, Any

from motorspace.analysis.measures import measure
from motorspace.studies.rows import Row, chosen

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from motorspace.reports.curves import Curve

STYLES = {"best": "-", "paper": "--"}
COLOURS = {"forward": "tab:blue", "holonomic": "tab:orange"}
LEVELS = {
    "linear_r2.worst": 0.99,
    "equivalence_ratio": 0.01,
    "equivalence_auc": 0.99,
    "partial_motors": 0.05,
    "normalised_topology_error": 0.1,
    "trustworthiness.20": 0.98,
    "winding_number": 1.0,
    "loop_persistence": None,
}
"""The measures of the first figure, and their targets."""
MOST_TURNS = 3
APART = "squared distance / that of all pairs"

X = Callable[[Row], float]


def by_rotation(row: Row) -> float:
    """The largest rotation of a row, in units of pi."""
    return float(row.cell["rotation"])


def curve(rows: Sequence[Row], key: str, x: X = by_rotation, **style: Any) -> "Curve":
    """A measure over some place, for the rows that have it."""
    from motorspace.reports.curves import Curve

    return Curve([row[key].at(x(row)) for row in rows if key in row], style)


def _systems(rows: Sequence[Row]) -> dict[tuple[str, str], list[Row]]:
    places = [(agent, preset) for agent in COLOURS for preset in STYLES]
    return {(agent, preset): chosen(rows, agent=agent, variant=preset) for agent, preset in places}


def _curves(rows: Sequence[Row], key: str, x: X = by_rotation) -> "dict[str, Curve]":
    return {
        f"{agent}, {preset}": curve(found, key, x, color=COLOURS[agent], ls=STYLES[preset])
        for (agent, preset), found in _systems(rows).items()
    }


def _axes(key: str) -> Mapping[str, Any]:
    scale = {"yscale": "log"} if measure(key).log_scale else {}
    return {"xlabel": "largest rotation, units of π"} | scale


def structure_figure(rows: Sequence[Row]) -> "Figure":
    """Every measure that has a target over the largest rotation."""
    from motorspace.reports.curves import Panel, panels_figure

    panels = [
        Panel(measure(key).label, _curves(rows, key), _axes(key), level)
        for key, level in LEVELS.items()
    ]
    return panels_figure(panels, size=(14, 6.4), rows=2, legend="below")


def standard_figure(rows: Sequence[Row]) -> "Figure":
    """Codes as they are and in standard form."""
    from motorspace.reports.curves import Panel, panels_figure

    panels = []
    for key in ("rank_correlation", "semipartial_motors"):
        curves = _curves(rows, key)
        for agent, colour in COLOURS.items():
            best, name = chosen(rows, agent=agent, variant="best"), f"standard.{key}"
            curves[f"{agent}, best, standard form"] = curve(best, name, color=colour, ls=":")
        panels.append(Panel(measure(key).label, curves, _axes(key)))
    return panels_figure(panels, size=(11, 3.8), legend="right")


def copies_figure(rows: Sequence[Row]) -> "Figure":
    """Correlation of codes with motors over that of their part which is affine in displacement."""
    from motorspace.reports.curves import Curve, Panel, panels_figure

    key, affine = "partial_motors", "partial_motors_affine"
    curves = {
        f"{agent}, {preset}": Curve(
            [row[key].at(row[affine].mean) for row in found if affine in row],
            {"color": COLOURS[agent], "mfc": COLOURS[agent] if preset == "best" else "none"},
        )
        for (agent, preset), found in _systems(rows).items()
    }
    axes = {"xlabel": measure(affine).label, "ylabel": measure(key).label}
    return panels_figure([Panel("", curves, axes, joined=False)])


def turns_figure(rows: Sequence[Row]) -> "Figure":
    """How far apart equivalent sequences lie that differ by full turns, at each rotation."""
    from motorspace.reports.curves import Curve, Panel, panels_figure

    def over_turns(row: Row) -> Curve:
        keys = {turns: f"equivalence.full_turns.{turns}" for turns in range(MOST_TURNS + 2)}
        return Curve([row[key].at(turns) for turns, key in keys.items() if key in row])

    panels = [
        Panel(
            ", ".join(label),
            {f"r = {row.cell['rotation']} π": over_turns(row) for row in found},
            {"xlabel": "full turns apart", "yscale": "log"}
            | ({"ylabel": APART} if label == ("forward", "best") else {}),
        )
        for label, found in _systems(rows).items()
    ]
    return panels_figure(panels, size=(11, 3.8), share_y=True)


def sampled_figure(rows: Sequence[Row]) -> "Figure":
    """How far apart full turns lie over how often training samples them."""
    from motorspace.reports.curves import Panel, panels_figure

    panels = []
    for agent in COLOURS:
        curves = {}
        for preset, style in STYLES.items():
            found = chosen(rows, agent=agent, variant=preset)
            for turns in range(1, MOST_TURNS + 1):
                curves[f"{preset}, {turns} full turns"] = curve(
                    found,
                    f"equivalence.full_turns.{turns}",
                    lambda row, turns=turns: share_of_turns(by_rotation(row), turns),
                    color=f"C{turns - 1}",
                    ls=style,
                )
        axes = {"xlabel": "share of the sampled sequences", "yscale": "log"}
        axes |= {"ylabel": APART} if agent == "forward" else {}
        # Three turns may never be sampled: near zero the axis is linear.
        panels.append(Panel(agent, curves, axes, linear_below=1e-5))
    return panels_figure(panels, size=(9, 3.8), share_y=True)


def share_of_turns(rotation: float, turns: int, horizon: int = 6) -> float:
    """Returns the share of random sequences whose net turn is nearest to `turns` full ones.

    The sum of `horizon` rotations uniform in +-`rotation` pi has the distribution of Irwin and
    Hall, stretched and shifted.

    Args:
        rotation: Largest rotation of a command, units of pi.
        turns: Full turns, above 0; in either direction.
        horizon: Commands of a sequence.

    Example:
        >>> share_of_turns(0.4, 2)
        0.0
    """
    from scipy.stats import irwinhall

    ends = (2 * turns - 1, 2 * turns + 1)
    low, high = (irwinhall(horizon).cdf((end / rotation + horizon) / 2) for end in ends)
    return float(2 * (high - low))


def lengths_figure(rows: Sequence[Row], rotation: float = 0.8) -> "Figure":
    """Error of the decoded translation over the length of the sequence."""
    from motorspace.reports.curves import Curve, Panel, panels_figure

    curves = {}
    for (agent, preset), found in _systems(rows).items():
        keys = {length: f"length_error.translation.{length}" for length in range(1, 25)}
        points = [
            row[key].at(length)
            for row in chosen(found, rotation=rotation)
            for length, key in keys.items()
            if key in row
        ]
        curves[f"{agent}, {preset}"] = Curve(
            points, {"color": COLOURS[agent], "ls": STYLES[preset]}
        )
    axes = {"xlabel": "commands in a sequence (trained on 6)", "xscale": "log", "yscale": "log"}
    axes |= {"ylabel": "error of the translation, world units"}
    return panels_figure([Panel("", curves, axes, mark=6)])


FIGURES = {
    "structure": structure_figure,
    "structure-motors": copies_figure,
    "structure-standard-form": standard_figure,
    "structure-turns": turns_figure,
    "structure-turn-frequency": sampled_figure,
    "structure-lengths": lengths_figure,
}
