"""The statements of a layout file, read and validated. `layouts` describes the format."""

import math
from collections.abc import Callable
from difflib import get_close_matches
from typing import Any

from motorspace._errors import UserError
from motorspace.worlds.paint import PLAIN, Paint, parse_paint
from motorspace.worlds.validation import Bounds, Polyline, check_layout


def read_statements(
    text: str, *, where: str
) -> tuple[str, Bounds, tuple[Polyline, ...], tuple[Polyline, ...], Paint]:
    """The title, bounds, walls, solids and paint in the text of a layout.

    `where` names it in messages.

    Raises:
        UserError: Names the line at fault, the fault and the remedy.
    """
    found: dict[str, list[tuple[int, Any]]] = {word: [] for word in STATEMENTS}
    for line_number, line in enumerate(_lines(text), start=1):
        word, *rest = line.split("#")[0].split(maxsplit=1) or [""]
        place = f"{where}, line {line_number}"
        if word in ONCE and found[word]:
            raise UserError(
                f"a second statement {word!r} (the first is in line {found[word][0][0]})",
                where=place,
                remedy="leave one of them out",
            )
        if word in found:
            found[word].append((line_number, STATEMENTS[word](" ".join(rest), place)))
        elif word:
            raise _unknown_statement(word, place)
    if not found["bounds"]:
        raise UserError(
            "the layout has no bounds", where=where, remedy="add a line like: bounds 0 0 40 40"
        )
    title, bounds, walls, solids, paint = (
        [value for _, value in found[word]] for word in STATEMENTS
    )
    check_layout(
        bounds[0],
        walls,
        solids,
        lambda word, i: f"{where}, line {found[word][i][0]}" if word else where,
    )
    return "".join(title), bounds[0], tuple(walls), tuple(solids), (*paint, PLAIN)[0]


def _lines(text: str) -> list[str]:
    """Lines that end in any of the usual ways; a byte order mark belongs to none."""
    return text.removeprefix("\ufeff").replace("\r\n", "\n").replace("\r", "\n").split("\n")


def _unknown_statement(word: str, place: str) -> UserError:
    near = get_close_matches(word.lower(), STATEMENTS, 1)
    return UserError(
        f"unknown statement {word!r}" + "".join(f" (perhaps {name!r})" for name in near),
        where=place,
        remedy=f"begin the line with one of {', '.join(STATEMENTS)}",
    )


def _title(text: str, place: str) -> str:
    del place
    return text


def _floats(text: str, place: str) -> list[float]:
    values: list[float] = []
    for word in text.split():
        try:
            values.append(float(word))
        except ValueError:
            values.append(math.nan)
        if not math.isfinite(values[-1]):
            raise UserError(
                f"{word!r} is not a finite number",
                where=place,
                remedy="write numbers with decimal points, and spaces between them",
            )
    return values


def _bounds(text: str, place: str) -> Bounds:
    values = _floats(text, place)
    if len(values) != 4:
        raise UserError(
            f"bounds must be x low, y low, x high, y high, not {text.strip()!r}",
            where=place,
            remedy="write for instance: bounds 0 0 40 40",
        )
    return values[0], values[1], values[2], values[3]


def _points(text: str, place: str) -> Polyline:
    values = _floats(text, place)
    return _at_least(2, tuple(zip(values[::2], values[1::2], strict=False)), values, place)


def _corners(text: str, place: str) -> Polyline:
    """The corners of a polygon, also of one that ends with its first point again."""
    values = _floats(text, place)
    points = tuple(zip(values[::2], values[1::2], strict=False))
    closed = len(points) > 1 and points[0] == points[-1]
    return _at_least(3, points[:-1] if closed else points, values, place)


def _at_least(num: int, points: Polyline, values: list[float], place: str) -> Polyline:
    if len(values) % 2 or len(points) < num:
        raise UserError(
            f"{len(values)} coordinates do not make a shape of {num} or more points",
            where=place,
            remedy="write x y pairs",
        )
    return points


def _paint(text: str, place: str) -> Paint:
    return parse_paint(text, where=place)


STATEMENTS: dict[str, Callable[[str, str], Any]] = {
    "title": _title,
    "bounds": _bounds,
    "wall": _points,
    "solid": _corners,
    "paint": _paint,
}
ONCE = ("title", "bounds", "paint")
