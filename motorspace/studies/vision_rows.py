"""What the study of vision shows: its rows, tables, targets and the curve."""

from collections.abc import Callable, Mapping, Sequence
from types import MappingProxyType
from typing import TYPE_CHECKING, Any

from motorspace.running.jobs import Value
from motorspace.studies.angle_scale import above, ratio_to
from motorspace.studies.rows import Numbers, Row, Settings, Spread, chosen, paired
from motorspace.studies.study import Line, Table, Target
from motorspace.studies.vision_jobs import HALF, PAPER, ROTATION, SCALED, Place
from motorspace.worlds.paint import parse_paint

if TYPE_CHECKING:
    from matplotlib.figure import Figure

PIXELS = 32
"""Pixels where a cell says nothing."""
FLAT = "flat"
LIGHTS = {"trajectory": "one for each trajectory", "view": "one for each view"}
FORWARD = MappingProxyType[str, Value]({"agent": "forward", "rotation": ROTATION})
R2, RATIO, TOPOLOGY = "linear_r2.worst", "equivalence_ratio", "normalised_topology_error"
ERROR, TO_ORACLE, UNTRAINED = "vision.error", "vision.to_oracle", "vision.untrained"
LOST = "vision.lost_to_light"
SHORTER = (1, 2, 3)
"""Commands of the shorter sequences that errors are measured on, too."""
QUALITY = {"linear R²": R2, "equivalence ratio": RATIO, "error / mean": ERROR}


def rows(found: Sequence[Row]) -> list[Row]:
    """The rows of the study, compared with the oracle and constant light, and distances' rows."""
    own = [_compared(row, found) for row in found if row.study == "vision"]
    return own + chosen(found, "structure", variant="best")


def _main(found: Sequence[Row]) -> list[Row]:
    return [row for row in chosen(found, "vision", variant="vision") if row.cell["paint"] != HALF]


def _same_place(row: Row) -> dict[str, Value]:
    return {name: row.cell[name] for name in Place._fields}


def _compared(row: Row, found: Sequence[Row]) -> Row:
    """The row with what it costs not to be told the displacement, or that the light changes."""
    match row.cell["variant"]:
        case "vision":
            pairs = _pairs(row, "oracle", found)
            key, values = TO_ORACLE, [float(own[ERROR]) / float(best[ERROR]) for own, best in pairs]
        case "light":
            pairs = _pairs(row, "vision", found)
            key, values = LOST, [float(steady[R2]) - float(own[R2]) for own, steady in pairs]
        case _:
            return row
    return row.with_measures({key: Spread(tuple(values))}) if values else row


def _pairs(row: Row, variant: str, found: Sequence[Row]) -> list[tuple[Numbers, Numbers]]:
    """The runs of a row, each with that of another variant at the same place and seed."""
    return [
        pair
        for other in chosen(found, "vision", **_same_place(row), variant=variant)
        for pair in paired(row, other)
    ]


def _place(row: Row) -> dict[str, Any]:
    return {
        "agent": row.cell["agent"],
        "r": f"{float(row.cell['rotation']):g} π",
        "paint": row.cell["paint"],
    }


def _named(row: Row) -> dict[str, Any]:
    """The place in one word, for tables of many measures."""
    return {"place": ", ".join(str(value) for value in _place(row).values())}


def _line(start: Mapping[str, Any], row: Row, heads: Mapping[str, str]) -> dict[str, Any]:
    """A line that goes on with mean and interval of the measures that the row has."""
    ends = {head: row[key].ends for head, key in heads.items() if key in row}
    return {**start, **ends}


def structure_lines(found: Sequence[Row]) -> list[Line]:
    """How well codes are organised."""
    heads = {"linear R²": R2, "equivalence ratio": RATIO, "D_topo": TOPOLOGY}
    return [_line(_place(row), row, heads) for row in _main(found)]


def error_lines(found: Sequence[Row]) -> list[Line]:
    """Errors over that of the mean view, beside those that know more and less."""
    variants = ("vision", "oracle", "no motors", "untrained")
    made: list[Line] = []
    for row in _main(found):
        line = _named(row)
        for variant in variants:
            for other in chosen(found, "vision", **_same_place(row), variant=variant):
                line["codes" if variant == "vision" else variant] = other[ERROR].ends
        made.append(_line(line, row, {"persistence": "vision.persistence"}))
    return made


def beside_lines(found: Sequence[Row]) -> list[Line]:
    """The least R² of learned codes, of those of distances, and of untrained ones."""
    made: list[Line] = []
    for row in _main(found):
        line = _line(_place(row), row, {"colours": R2})
        place = _same_place(row)
        blind = chosen(found, "vision", **place, variant="untrained")
        ranges = chosen(found, "structure", agent=place["agent"], rotation=place["rotation"])
        for head, others in (("distances", ranges), ("untrained", blind)):
            if others and R2 in others[0]:
                line[head] = others[0][R2].ends
        made.append(line)
    return made


def length_lines(found: Sequence[Row]) -> list[Line]:
    """Errors by the length of the sequence."""
    heads = {f"T = {length}": f"{ERROR}.{length}" for length in SHORTER} | {"T = 6": ERROR}
    return [_line(_named(row), row, heads) for row in _main(found)]


def curve_lines(found: Sequence[Row]) -> list[Line]:
    """Organisation and error over wavelengths and numbers of pixels."""
    return [
        _line({"paint": r.cell["paint"], "pixels": r.cell.get("pixels", PIXELS)}, r, QUALITY)
        for r in _curve(found)
    ]


def _curve(found: Sequence[Row]) -> list[Row]:
    of_forward = chosen(found, "vision", **FORWARD, variant=("vision", "pixels"))
    textured = [row for row in of_forward if row.cell["paint"] != FLAT]
    return sorted(textured, key=lambda row: (-_wavelength(row), row.cell.get("pixels", PIXELS)))


def _wavelength(row: Row) -> float:
    return parse_paint(str(row.cell["paint"])).wavelength


def light_lines(found: Sequence[Row]) -> list[Line]:
    """Flat colours in constant and in changing light."""
    return [
        _line({"light": LIGHTS.get(str(row.cell.get("light")), "constant")}, row, QUALITY)
        for variant in ("vision", "light")
        for row in chosen(found, "vision", **FORWARD, paint=FLAT, variant=variant)
    ]


def loss_lines(found: Sequence[Row]) -> list[Line]:
    """What is predicted: pixels, these and blurred ones, learned features; and by which network."""
    names = {"vision": "pixels + blurred pixels"}
    heads = QUALITY | {"error at T = 24": "length_error.translation.24"}
    return [
        _line({"predicted": names.get(variant, variant), "paint": paint}, row, heads)
        for variant in ("vision", "pixels alone", "features", PAPER)
        for paint in (FLAT, "texture:4")
        for row in chosen(found, "vision", **FORWARD, variant=variant, paint=paint)
    ]


def sequence_lines(found: Sequence[Row]) -> list[Line]:
    """What sequences codes are learned from; measured on those of six commands."""
    names = {
        "vision": "one command, then up to six",
        "one command": "one command alone",
        "six commands": "six commands alone",
        "six commands, small steps": "six alone, a learning rate of 1e-3",
    }
    return [
        _line({"learned from": name}, row, QUALITY)
        for variant, name in names.items()
        for row in chosen(found, "vision", **FORWARD, variant=variant, paint="texture:4")
    ]


def image_lines(found: Sequence[Row]) -> list[Line]:
    """Codes that learn from a camera's images."""
    heads = QUALITY | {"persistence / mean": "vision.persistence", "R², untrained": UNTRAINED}
    taken = chosen(found, "vision", variant="images")
    return [_line({"agent": row.cell["agent"]}, row, heads) for row in taken]


def angle_lines(found: Sequence[Row]) -> list[Line]:
    """What an oracle loses whose rotations are scaled by one factor."""
    scaled = chosen(found, "vision", variant=SCALED)
    return [
        {
            "r": _place(row)["r"],
            "rotations scaled by": f"{float(row.cell['angle']):g}",
            "increase of the error, %": above(ratio_to(right, row)).ends,
        }
        for right in scaled
        if right.cell["angle"] == 1.0
        for row in scaled
    ]


def use_lines(found: Sequence[Row]) -> list[Line]:
    """What codes from colours and from distances are good for, beside chance."""
    heads = {
        "displacement goals": "control.success.hybrid",
        "goals four sequences away": "control.success.far",
        "came home": "vision.home",
        "ATE of chained codes": "odometry.ate.codes",
    }
    chance = {
        "displacement goals": "control.success.random",
        "came home": "vision.home.chance",
        "ATE of chained codes": "odometry.ate.still",
    }
    used = chosen(found, "vision", variant="use")
    lines = [_line({"codes from": row.cell["used"]}, row, heads) for row in used]
    return lines + [
        _line({"codes from": "chance; standing still"}, row, chance) for row in used[:1]
    ]


def curve_figure(found: Sequence[Row]) -> "Figure":
    """The least R² and the error over the number of pixels, a line for each wavelength."""
    from motorspace.reports.figures.measures import Axis, curves_figure

    points = [
        {"pixels": PIXELS, **row.line(R2, ERROR), "wavelength": f"{_wavelength(row):g} units"}
        for row in _curve(found)
        if parse_paint(str(row.cell["paint"])).share == 1
    ]
    axis = Axis("pixels", scale="log")
    return curves_figure(points, axis, [R2, ERROR], series=("wavelength",))


TABLES = {
    "vision": Table(structure_lines),
    "vision_errors": Table(error_lines),
    "vision_beside": Table(beside_lines),
    "vision_lengths": Table(length_lines),
    "vision_curve": Table(curve_lines),
    "vision_light": Table(light_lines),
    "vision_losses": Table(loss_lines),
    "vision_sequences": Table(sequence_lines),
    "vision_images": Table(image_lines),
    "vision_angles": Table(angle_lines),
    "vision_use": Table(use_lines),
}
FIGURES: dict[str, Callable[[Sequence[Row]], "Figure"]] = {"vision": curve_figure}


def _cells(agent: str, paint: str, variant: str = "vision", **further: int) -> Settings:
    return {"agent": agent, "paint": paint, "variant": variant, **further}


BOUNDS: tuple[tuple[str, Settings, str, float | None, float | None], ...] = (
    ("flat colours, forward", _cells("forward", FLAT), R2, 0.98, None),
    ("flat colours, forward", _cells("forward", FLAT), RATIO, None, 0.004),
    ("flat colours, forward", _cells("forward", FLAT), TO_ORACLE, None, 1.02),
    ("flat colours, holonomic", _cells("holonomic", FLAT), R2, 0.95, None),
    ("flat colours, the paper's network", _cells("forward", FLAT, PAPER), R2, 0.92, None),
    ("texture of 12 units", _cells("forward", "texture:12"), R2, 0.97, None),
    ("texture of 12 units", _cells("forward", "texture:12"), RATIO, None, 0.006),
    ("texture of 4 units, forward", _cells("forward", "texture:4"), R2, 0.95, None),
    ("texture of 4 units, forward", _cells("forward", "texture:4"), RATIO, None, 0.015),
    ("texture of 4 units, forward", _cells("forward", "texture:4"), TOPOLOGY, None, 0.05),
    ("texture of 4 units, holonomic", _cells("holonomic", "texture:4"), R2, 0.7, None),
    ("flat colours in changing light", _cells("forward", FLAT, "light"), LOST, None, 0.02),
    ("first-person images", _cells("forward", "MiniWorld", "images"), R2, 0.9, None),
    ("texture of 1 unit", _cells("forward", "texture:1", "pixels", pixels=128), R2, 0.9, None),
)
"""Where, the cells, the measure, its lower and its upper bound."""

LABELS = {R2: "linear R²", RATIO: "equivalence ratio", TOPOLOGY: "D_topo"}
LABELS |= {TO_ORACLE: "error over the oracle's", LOST: "R² lost"}

TARGETS = tuple(
    Target(f"{where}: {LABELS[key]}", key, at_least=least, at_most=most, cells=cells)
    for where, cells, key, least, most in BOUNDS
)
