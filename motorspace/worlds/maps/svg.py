"""Outlines in SVG: line, rect, polyline, polygon, and path with straight pieces."""

import math
import re
from collections.abc import Iterator
from pathlib import Path
from typing import Any
from xml.parsers import expat

from motorspace._errors import UserError
from motorspace.worlds.layouts import Layout
from motorspace.worlds.maps.files import map_text
from motorspace.worlds.maps.outlines import KINDS, Kind, Shape, finite, outlined
from motorspace.worlds.validation import Polyline

Matrix = tuple[float, float, float, float, float, float]
IDENTITY: Matrix = (1.0, 0.0, 0.0, 1.0, 0.0, 0.0)

DRAWN = ("line", "rect", "polyline", "polygon", "path")
HIDDEN = ("defs", "symbol", "clipPath", "mask", "marker", "pattern", "metadata", "style", "title")
DEEPEST = 256

NUMBER = r"[-+]?(?:\d+\.?\d*|\.\d+)(?:[eE][-+]?\d+)?"
TOKEN = re.compile(rf"\s*,?\s*(?:([A-Za-z])|({NUMBER}))")
TRANSFORM = re.compile(r"\s*,?\s*(matrix|translate|scale|rotate)\s*\(([^()]*)\)")


class Drawing:
    """The shapes of an SVG file, as its elements begin and end."""

    def __init__(self, path: Path) -> None:
        self.path = path
        self.shapes: list[Shape] = []
        self.left: dict[str, int] = {}
        self._parser = expat.ParserCreate()
        self._parser.StartElementHandler = self._start
        self._parser.EndElementHandler = self._end
        # An entity can stand for a file, or for more text than memory holds.
        self._parser.EntityDeclHandler = self._refuse_entity
        self._open: list[tuple[Matrix, bool, Kind]] = [(IDENTITY, True, "wall")]

    def read(self, text: str) -> None:
        """Read the whole text. Raises `UserError` naming the line at fault."""
        try:
            self._parser.Parse(text, True)
        except expat.ExpatError as error:
            raise UserError(
                f"the drawing is no XML ({expat.ErrorString(error.code)})",
                where=f"{self.path}, line {error.lineno}",
                remedy="save it again as SVG",
            ) from None

    def _place(self) -> str:
        return f"{self.path}, line {self._parser.CurrentLineNumber}"

    def _start(self, name: str, found: dict[str, str]) -> None:
        name = name.rpartition(":")[2]
        matrix, shown, kind = self._open[-1]
        if len(self._open) > DEEPEST:
            raise UserError("groups nest too deep", where=self._place(), remedy="flatten them")
        if "transform" in found:
            matrix = _product(matrix, _transform(found["transform"], self._place()))
        kind = next((k for k in KINDS if k in found.get("class", "").split()), kind)
        shown = shown and name not in HIDDEN and found.get("display") != "none"
        self._open.append((matrix, shown, kind))
        if not shown or name in ("svg", "g", "a"):
            return
        if name not in DRAWN:
            self.left[name] = self.left.get(name, 0) + 1
            return
        for points, closed in _lines(name, found, self._place()):
            placed = finite((_apply(matrix, *point) for point in points), self._place())
            self.shapes.append(Shape(kind, placed, closed, self._place()))

    def _end(self, name: str) -> None:
        self._open.pop()

    def _refuse_entity(self, *_: Any) -> None:
        raise UserError(
            "the drawing declares an entity", where=self._place(), remedy="save it as plain SVG"
        )


def read_map(path: Path) -> tuple[Layout, list[str]]:
    """The layout of a drawing, upright as it is seen, one world unit a user unit; and notes.

    The class of an element or of a group says what it is: a wall (the default), a solid, or the
    outline.

    Raises:
        UserError: Names the line at fault.
    """
    drawing = Drawing(path)
    drawing.read(map_text(path))
    # In SVG y points down.
    lowest = max((y for s in drawing.shapes for _, y in s.points), default=0.0)
    shapes = [
        s._replace(points=tuple((x, lowest - y) for x, y in s.points)) for s in drawing.shapes
    ]
    notes = [f"{count} {name} elements are left out" for name, count in drawing.left.items()]
    return outlined(shapes, path.stem, where=path), notes


def _lines(name: str, found: dict[str, str], place: str) -> Iterator[tuple[Polyline, bool]]:
    """The lines of an element, and whether they are closed."""

    def value(key: str) -> float:
        return _numbers(found.get(key, "0").removesuffix("px"), place, 1)[0]

    if name == "line":
        yield ((value("x1"), value("y1")), (value("x2"), value("y2"))), False
    elif name == "rect":
        x, y, width, height = map(value, ("x", "y", "width", "height"))
        yield ((x, y), (x + width, y), (x + width, y + height), (x, y + height)), True
    elif name == "path":
        yield from _path(found.get("d", ""), place)
    else:
        values = _numbers(found.get("points", ""), place)
        if len(values) % 2:
            raise UserError("a point lacks its y", where=place, remedy="complete the points")
        yield tuple(zip(values[::2], values[1::2], strict=True)), name == "polygon"


def _path(text: str, place: str) -> Iterator[tuple[Polyline, bool]]:
    """The lines of a path of the commands M L H V Z, absolute or relative."""
    points: list[tuple[float, float]] = []
    x = y = 0.0
    for command, values in _commands(text, place):
        own_x, own_y = (x, y) if command.islower() else (0.0, 0.0)
        if command in "Zz":
            yield tuple(points), True
            x, y = points[0] if points else (x, y)
            points = [(x, y)]
            continue
        if command in "Hh":
            x = values[0] + own_x
        elif command in "Vv":
            y = values[0] + own_y
        else:
            x, y = values[0] + own_x, values[1] + own_y
        if command in "Mm":
            if len(points) > 1:
                yield tuple(points), False
            points = []
        points.append((x, y))
    if len(points) > 1:
        yield tuple(points), False


def _commands(text: str, place: str) -> Iterator[tuple[str, list[float]]]:
    """Each command with its own numbers; one that is repeated need not be written again."""
    at, command = 0, ""
    waiting: list[float] = []
    while text[at:].strip():
        token = TOKEN.match(text, at)
        if token is None or (token[1] and (waiting or token[1] not in "MmLlHhVvZz")):
            raise UserError(
                f"the path cannot be read from {text[at : at + 20]!r} on",
                where=place,
                remedy="use the commands M L H V Z alone: turn curves into straight lines",
            )
        at = token.end()
        if token[1]:
            command = token[1]
            if command in "Zz":
                yield command, []
            continue
        waiting.append(float(token[2]))
        if len(waiting) == (1 if command in "HhVv" else 2):
            if command in ("", "Z", "z"):
                raise UserError("the path lacks a command", where=place, remedy="begin it with M")
            yield command, waiting
            waiting = []
            command = {"M": "L", "m": "l"}.get(command, command)
    if waiting:
        raise UserError("the path lacks a number at its end", where=place, remedy="complete it")


def _numbers(text: str, place: str, count: int | None = None) -> list[float]:
    words = text.replace(",", " ").split()
    try:
        values = [float(word) for word in words]
    except ValueError:
        values = [math.nan]
    if not all(map(math.isfinite, values)) or (count is not None and len(values) != count):
        raise UserError(
            f"{text[:40]!r} cannot be read", where=place, remedy="write plain numbers, no units"
        )
    return values


def _transform(text: str, place: str) -> Matrix:
    found, at = IDENTITY, 0
    while text[at:].strip():
        match = TRANSFORM.match(text, at)
        if match is None:
            raise UserError(
                f"the transform {text[at : at + 40]!r} is not known",
                where=place,
                remedy="use matrix, translate, scale or rotate",
            )
        found = _product(found, _matrix(match[1], _numbers(match[2], place), place))
        at = match.end()
    return found


def _matrix(name: str, values: list[float], place: str) -> Matrix:
    match name, values:
        case "matrix", [a, b, c, d, e, f]:
            return a, b, c, d, e, f
        case "translate", [x, *rest] if len(rest) < 2:
            return 1.0, 0.0, 0.0, 1.0, x, (rest or [0.0])[0]
        case "scale", [x, *rest] if len(rest) < 2:
            return x, 0.0, 0.0, (rest or [x])[0], 0.0, 0.0
        case "rotate", [degrees]:
            cos, sin = math.cos(math.radians(degrees)), math.sin(math.radians(degrees))
            return cos, sin, -sin, cos, 0.0, 0.0
        case "rotate", [degrees, x, y]:
            turned = _product((1.0, 0.0, 0.0, 1.0, x, y), _matrix("rotate", [degrees], place))
            return _product(turned, (1.0, 0.0, 0.0, 1.0, -x, -y))
    raise UserError(
        f"the transform {name} has {len(values)} numbers", where=place, remedy="correct it"
    )


def _product(first: Matrix, then: Matrix) -> Matrix:
    a, b, c, d, e, f = first
    p, q, r, s, t, u = then
    return (
        a * p + c * q,
        b * p + d * q,
        a * r + c * s,
        b * r + d * s,
        a * t + c * u + e,
        b * t + d * u + f,
    )


def _apply(matrix: Matrix, x: float, y: float) -> tuple[float, float]:
    a, b, c, d, e, f = matrix
    return a * x + c * y + e, b * x + d * y + f
