"""From the outlines of a drawing to a layout."""

import math
from collections.abc import Iterable
from typing import Literal, NamedTuple, get_args

from motorspace._errors import UserError
from motorspace.worlds.layouts import Layout
from motorspace.worlds.maps.occupancy import DIGITS, outside
from motorspace.worlds.validation import RESOLUTION, Polyline

Kind = Literal["wall", "solid", "outline"]
KINDS: tuple[Kind, ...] = get_args(Kind)

MARGIN = 0.1
"""World units between an outline and the bounds."""

MOST_POINTS = 1_000_000


class Shape(NamedTuple):
    """A line of a drawing, and what it stands for."""

    kind: Kind
    """A wall; a solid, in whose inside nothing stands; the outline, outside of which it is so."""
    points: Polyline
    closed: bool
    place: str


def outlined(shapes: list[Shape], title: str, *, where: object) -> Layout:
    """The layout of some shapes; its bounds are those of all of them.

    Raises:
        UserError: There are no shapes, too many, or none of any size.
    """
    if sum(len(shape.points) for shape in shapes) > MOST_POINTS:
        raise UserError(
            f"the drawing has more than {MOST_POINTS:,} points", where=where, remedy="simplify it"
        )
    shapes = [_cleaned(shape) for shape in shapes]
    points = [point for shape in shapes for point in shape.points]
    rims = [shape for shape in shapes if shape.kind == "outline"]
    if not points or len(rims) > 1:
        what = f"the drawing has {len(rims)} outlines" if rims else "the drawing has no lines"
        raise UserError(what, where=where, remedy="draw walls, and at most one outline")
    margin = MARGIN if rims else 0.0
    x, y = zip(*points, strict=True)
    bounds = (min(x) - margin, min(y) - margin, max(x) + margin, max(y) + margin)
    if max(bounds[2] - bounds[0], bounds[3] - bounds[1]) < 1:
        raise UserError(
            f"the whole drawing spans {bounds[2] - bounds[0]:g} x {bounds[3] - bounds[1]:g} world "
            "units, less than one step of an agent",
            where=where,
            remedy="draw it in metres; project degrees to metres first",
        )
    low_x, low_y, high_x, high_y = (round(value, DIGITS) for value in bounds)
    rounded = (low_x, low_y, high_x, high_y)
    solids = [shape.points for shape in shapes if shape.kind == "solid"]
    for rim in rims:
        solids += outside(rim.points, rounded)
    walls = [_line(shape) for shape in shapes if shape.kind == "wall" and len(shape.points) > 1]
    return Layout(title.replace("#", " "), rounded, tuple(walls), tuple(solids))


def kind_of(word: object, place: str) -> Kind:
    """The kind that a drawing names. Raises `UserError` for another word."""
    for kind in KINDS:
        if word == kind:
            return kind
    raise UserError(
        f"the kind {str(word)[:40]!r}", where=place, remedy=f"one of {', '.join(KINDS)}"
    )


def finite(points: Iterable[tuple[float, float]], place: str) -> Polyline:
    """The points. Raises `UserError` where one is not finite."""
    found = tuple((float(x), float(y)) for x, y in points)
    if not all(math.isfinite(x) and math.isfinite(y) for x, y in found):
        raise UserError("a coordinate is not finite", where=place, remedy="correct it")
    return found


def _cleaned(shape: Shape) -> Shape:
    """Without points that are too near to the one before to be resolved."""
    rounded = [(round(x, DIGITS), round(y, DIGITS)) for x, y in shape.points]
    kept = rounded[:1]
    for point in rounded[1:]:
        if math.dist(point, kept[-1]) >= 2 * RESOLUTION:
            kept.append(point)
    closed = shape.closed
    if len(kept) > 3 and math.dist(kept[0], kept[-1]) < 2 * RESOLUTION:
        kept.pop()
        closed = True
    if shape.kind != "wall" and len(kept) < 3:
        raise UserError(
            f"the {shape.kind} has {len(kept)} corners", where=shape.place, remedy="draw three"
        )
    return shape._replace(points=tuple(kept), closed=closed)


def _line(shape: Shape) -> Polyline:
    """The points of a wall, the first one again where it is closed."""
    again = shape.points[:1] if shape.closed and len(shape.points) > 2 else ()
    return (*shape.points, *again)
