"""Outlines in GeoJSON: lines and polygons, in a plane of metres."""

import json
from collections.abc import Iterator
from pathlib import Path
from typing import Any

from motorspace._errors import UserError
from motorspace.worlds.layouts import Layout
from motorspace.worlds.maps.files import map_text
from motorspace.worlds.maps.outlines import Kind, Shape, finite, kind_of, outlined

DEEPEST = 16
"""Collections within collections, at most."""

LINES = {"LineString": 0, "MultiLineString": 1, "Polygon": 1, "MultiPolygon": 2}
"""How many lists of lines are around each line."""


def read_map(path: Path) -> tuple[Layout, list[str]]:
    """The layout of the lines and polygons, and notes on what was left out.

    The property `kind` of a feature says what it is: a wall (the default), a solid, or the outline.

    Raises:
        UserError: Names the feature at fault.
    """
    try:
        content = json.loads(map_text(path))
    except (ValueError, RecursionError) as error:
        raise UserError(
            f"the file is no JSON ({error})", where=path, remedy="write it again"
        ) from None
    left: dict[str, int] = {}
    shapes = list(_shapes(content, "wall", str(path), left, 0))
    notes = [f"{count} {kind} are left out" for kind, count in left.items()]
    return outlined(shapes, path.stem, where=path), notes


def _shapes(
    found: Any, kind: Kind, place: str, left: dict[str, int], depth: int
) -> Iterator[Shape]:
    if not isinstance(found, dict) or depth > DEEPEST:
        raise UserError("this is no GeoJSON object", where=place, remedy="check the file")
    name = str(found.get("type"))
    if name in ("FeatureCollection", "GeometryCollection"):
        parts = found.get("features" if name == "FeatureCollection" else "geometries")
        for index, part in enumerate(_listed(parts, place), start=1):
            yield from _shapes(part, kind, f"{place}, feature {index}", left, depth + 1)
    elif name == "Feature":
        properties = found.get("properties") or {}
        if isinstance(properties, dict) and "kind" in properties:
            kind = kind_of(properties["kind"], place)
        if found.get("geometry") is not None:
            yield from _shapes(found["geometry"], kind, place, left, depth + 1)
    elif name in LINES:
        closed = name.endswith("Polygon")
        for line in _lines(found.get("coordinates"), LINES[name], place):
            points = finite((_point(point, place) for point in _listed(line, place)), place)
            yield Shape(kind, points, closed, place)
    else:
        left[name] = left.get(name, 0) + 1


def _lines(found: Any, depth: int, place: str) -> Iterator[Any]:
    if depth == 0:
        yield found
        return
    for part in _listed(found, place):
        yield from _lines(part, depth - 1, place)


def _listed(found: Any, place: str) -> list[Any]:
    if not isinstance(found, list):
        raise UserError("a list is missing", where=place, remedy="correct the GeoJSON")
    return found


def _point(found: Any, place: str) -> tuple[float, float]:
    pair = _listed(found, place)[:2]
    numbers = [v for v in pair if isinstance(v, int | float) and not isinstance(v, bool)]
    if len(numbers) != 2:
        raise UserError(
            f"a point is {str(found)[:40]}", where=place, remedy="write [x, y] as numbers"
        )
    try:
        return float(numbers[0]), float(numbers[1])
    except OverflowError:
        return float("inf"), 0.0
