"""How the structure of codes changes with the largest rotation and the length of sequences."""

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any

from motorspace.studies.rows import Row, chosen

if TYPE_CHECKING:
    from matplotlib.figure import Figure

TARGETS = {
    "linear_r2.worst": 0.99,
    "equivalence_ratio": 0.01,
    "equivalence_auc": 0.99,
    "partial_motors": 0.05,
    "normalised_topology_error": 0.1,
    "trustworthiness.20": 0.98,
    "winding_number": 1.0,
}
SERIES = ("agent", "variant")
ROTATION = "largest rotation, units of π"
TURNS = "equivalence.full_turns"
MOST_TURNS = 3

Line = dict[str, Any]


def presets(rows: Sequence[Row], *keys: str) -> list[Line]:
    """The rows of both presets with these measures, as figures take them."""
    found = [
        row for preset in ("best", "paper") for row in chosen(rows, variant=preset, agent=AGENTS)
    ]
    return [row.line(*keys) for row in found]


AGENTS = ("forward", "holonomic")


def structure_figure(rows: Sequence[Row]) -> "Figure":
    """Every measure that has a target over the largest rotation."""
    from motorspace.reports.figures.measures import Axis, curves_figure

    keys = (*TARGETS, "loop_persistence")
    return curves_figure(
        presets(rows, *keys), Axis("rotation", ROTATION), keys, series=SERIES, targets=TARGETS
    )


def motors_figure(rows: Sequence[Row]) -> "Figure":
    """Correlation of codes with motors over that of their part which is affine in displacement."""
    from motorspace.reports.figures.measures import comparison_figure

    keys = ("partial_motors_affine", "partial_motors")
    return comparison_figure(presets(rows, *keys), *keys, series=SERIES)


def standard_figure(rows: Sequence[Row]) -> "Figure":
    """Codes as they are and in standard form."""
    from motorspace.reports.figures.measures import Axis, curves_figure

    keys = ("rank_correlation", "semipartial_motors")
    lines = presets(rows, *keys)
    for row in chosen(rows, agent=AGENTS, variant="best"):
        standard = row.line(*(f"standard.{key}" for key in keys))
        named = {name.removeprefix("standard."): value for name, value in standard.items()}
        lines.append(named | {"variant": "best, standard form"})
    return curves_figure(lines, Axis("rotation", ROTATION), keys, series=SERIES)


def turns_figure(rows: Sequence[Row]) -> "Figure":
    """How far apart equivalent sequences lie that differ by full turns, at each rotation."""
    from motorspace.reports.figures.measures import Axis, along, curves_figure

    lines = presets(rows, *(f"{TURNS}.{turns}" for turns in range(MOST_TURNS + 2)))
    for line in lines:
        line["r"] = f"r = {line['rotation']} π"
        line["codes"] = f"{line['agent']}, {line['variant']}"
    return curves_figure(
        along(lines, TURNS, "turns"),
        Axis("turns", "full turns apart"),
        [TURNS],
        series=("r",),
        panels="codes",
    )


def frequency_figure(rows: Sequence[Row]) -> "Figure":
    """How far apart full turns lie over how often training samples them."""
    from motorspace.reports.figures.measures import Axis, along, curves_figure

    lines = presets(rows, *(f"{TURNS}.{turns}" for turns in range(1, MOST_TURNS + 1)))
    long = [dict(line) for line in along(lines, TURNS, "turns")]
    for line in long:
        line["share"] = share_of_turns(line["rotation"], line["turns"])
        line["apart"] = f"{line['turns']} full turns"
    return curves_figure(
        long,
        Axis("share", "share of the sampled sequences", "symlog"),
        [TURNS],
        series=("apart", "variant"),
        panels="agent",
    )


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


def lengths_figure(rows: Sequence[Row]) -> "Figure":
    """Error of the decoded translation over the length of the sequence."""
    from motorspace.reports.figures.measures import Axis, along, curves_figure

    family = "length_error.translation"
    keys = [f"{family}.{length}" for length in (1, 2, 3, 6, 12, 24)]
    lines: list[Mapping[str, Any]] = along(
        presets(chosen(rows, rotation=0.8), *keys), family, "commands"
    )
    commands = Axis("commands", "commands in a sequence (trained on 6)", "log", mark=6.0)
    return curves_figure(lines, commands, [family], series=SERIES)


FIGURES = {
    "structure": structure_figure,
    "structure-motors": motors_figure,
    "structure-standard-form": standard_figure,
    "structure-turns": turns_figure,
    "structure-turn-frequency": frequency_figure,
    "structure-lengths": lengths_figure,
}
