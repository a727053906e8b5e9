"""Named layouts, layout files and random rooms: descriptions of walls, validated.

A layout file is plain text, one statement a line, world units; `#` starts a comment:

```
title   Two rooms and a pillar
bounds  0 0 40 40                    # x low, y low, x high, y high: the outer walls
wall    20 0  20 17                  # a polyline: x y pairs, two or more
solid   8 8  10 8  10 10  8 10       # a closed polygon in whose inside nothing stands
```
"""

import math
from collections.abc import Iterator
from dataclasses import dataclass
from importlib import resources
from itertools import pairwise
from pathlib import Path

import jax
import jax.numpy as jnp
import numpy as np

from motorspace._errors import UserError
from motorspace._types import Pose
from motorspace.worlds.tiles import tiled
from motorspace.worlds.world import WalledWorld

Point = tuple[float, float]
Segment = tuple[Point, Point]

STATEMENTS = ("title", "bounds", "wall", "solid")
MIN_FREE_SHARE = 0.05

INDEXED_FROM = 100
"""Walls from which on looking up those around a place is faster than visiting all."""


@dataclass(frozen=True)
class Layout:
    """A description of a walled world. World units."""

    title: str
    bounds: tuple[float, float, float, float]
    walls: tuple[tuple[Point, ...], ...] = ()
    solids: tuple[tuple[Point, ...], ...] = ()

    def segments(self) -> tuple[list[Segment], list[Segment]]:
        """All wall segments, the outer ones included, and those of the solids alone."""
        x_low, y_low, x_high, y_high = self.bounds
        outer = ((x_low, y_low), (x_high, y_low), (x_high, y_high), (x_low, y_high))
        solids = [s for polygon in self.solids for s in _closed(polygon)]
        inner = [s for line in self.walls for s in pairwise(line)]
        return [*_closed(outer), *inner, *solids], solids

    def world(self) -> WalledWorld:
        """The world with these walls."""
        segments, solid = self.segments()
        walls, solids = jnp.asarray(segments, float), jnp.asarray(solid, float).reshape(-1, 2, 2)
        tiles = tiled(np.asarray(segments), self.bounds) if len(segments) >= INDEXED_FROM else None
        return WalledWorld(walls, solids, self.bounds, tiles)

    def text(self) -> str:
        """The layout in the file format of this module."""
        lines = [f"title   {self.title}", f"bounds  {_numbers(self.bounds)}"]
        for word, shapes in (("wall ", self.walls), ("solid", self.solids)):
            lines += [f"{word}   {'  '.join(_numbers(p) for p in shape)}" for shape in shapes]
        return "\n".join(lines) + "\n"


def layout_names() -> tuple[str, ...]:
    """The bundled layouts."""
    files = resources.files("motorspace.worlds").joinpath("layouts").iterdir()
    return tuple(sorted(f.name.removesuffix(".layout") for f in files))


def layout(name: str) -> WalledWorld:
    """The world of a bundled layout, of a layout file, or of random rooms (`"rooms:SEED"`).

    Raises `UserError` for an unknown name or a broken file.
    """
    return load_layout(name).world()


def load_layout(name: str) -> Layout:
    """The description behind `layout(name)`."""
    if name.startswith("rooms:"):
        seed = name.removeprefix("rooms:")
        if not seed.isdecimal():
            raise UserError(
                f"the seed of random rooms must be a whole number, not {seed!r}",
                where="layout",
                remedy="write for instance rooms:7",
            )
        return random_rooms(key=jax.random.key(int(seed)))
    if name in layout_names():
        bundled = resources.files("motorspace.worlds").joinpath("layouts", f"{name}.layout")
        return _checked(parse_layout(bundled.read_text("utf-8"), where=name), name)
    if Path(name).suffix or Path(name).exists():
        return read_layout(Path(name))
    raise UserError(
        f"there is no layout {name!r}",
        remedy=f"choose one of {', '.join(layout_names())}, rooms:SEED, or a layout file",
    )


def read_layout(path: Path) -> Layout:
    """The layout in a file. Raises `UserError` naming the file and the line at fault."""
    try:
        text = path.read_text("utf-8")
    except (OSError, UnicodeDecodeError) as error:
        reason = error.strerror if isinstance(error, OSError) else "it is not UTF-8 text"
        raise UserError(
            f"the layout cannot be read ({reason})", where=path, remedy="give a layout file"
        ) from None
    return _checked(parse_layout(text, where=str(path)), str(path))


def parse_layout(text: str, *, where: str) -> Layout:
    """The layout written in `text`; `where` names it in messages."""
    title, bounds = "", None
    shapes: dict[str, list[tuple[Point, ...]]] = {"wall": [], "solid": []}
    for number, line in enumerate(text.splitlines(), start=1):
        word, _, rest = line.split("#")[0].strip().partition(" ")
        place = f"{where}, line {number}"
        if word == "title":
            title = rest.strip()
        elif word == "bounds":
            bounds = _bounds(rest, place)
        elif word in shapes:
            shapes[word].append(_points(rest, place, at_least=2 if word == "wall" else 3))
        elif word:
            raise UserError(
                f"unknown statement {word!r}",
                where=place,
                remedy=f"begin the line with one of {', '.join(STATEMENTS)}",
            )
    if bounds is None:
        raise UserError(
            "the layout has no bounds", where=where, remedy="add a line like: bounds 0 0 40 40"
        )
    return Layout(title, bounds, tuple(shapes["wall"]), tuple(shapes["solid"]))


def random_rooms(
    *, size: float = 40.0, min_room: float = 8.0, door: float = 3.0, key: jax.Array
) -> Layout:
    """Rooms by recursive division: every wall has one door, so every room can be reached.

    `size` is the side of the square, `min_room` the smallest side of a room, `door` the width
    of the openings; world units. Same key, same rooms.
    """
    if not 0 < 2 * door < min_room <= size:
        raise UserError(
            f"rooms of side {min_room} with doors of {door} do not fit a square of {size}",
            remedy="keep 2 x door < min_room <= size",
        )
    rng = np.random.default_rng(np.asarray(jax.random.key_data(key)).ravel().tolist())
    walls = tuple(_divide(rng, (0.0, 0.0, size, size), min_room, door))
    return Layout("random rooms", (0.0, 0.0, size, size), walls)


def _divide(
    rng: np.random.Generator,
    room: tuple[float, float, float, float],
    min_room: float,
    door: float,
) -> Iterator[tuple[Point, ...]]:
    """Walls that split `room` and then each half, until the rooms are small."""
    x_low, y_low, x_high, y_high = room
    width, height = x_high - x_low, y_high - y_low
    if max(width, height) < 2 * min_room:
        return
    upright = width >= height
    low, high, start, stop = (
        (x_low, x_high, y_low, y_high) if upright else (y_low, y_high, x_low, x_high)
    )
    at = round(float(rng.uniform(low + min_room, high - min_room)), 2)
    gap = round(float(rng.uniform(start + door / 2, stop - 1.5 * door)), 2)
    for a, b in ((start, gap), (gap + door, stop)):
        yield ((at, a), (at, b)) if upright else ((a, at), (b, at))
    halves = (
        ((x_low, y_low, at, y_high), (at, y_low, x_high, y_high))
        if upright
        else ((x_low, y_low, x_high, at), (x_low, at, x_high, y_high))
    )
    for half in halves:
        yield from _divide(rng, half, min_room, door)


def _closed(polygon: tuple[Point, ...]) -> list[Segment]:
    return list(zip(polygon, polygon[1:] + polygon[:1], strict=True))


def _numbers(values: tuple[float, ...]) -> str:
    return " ".join(f"{value:g}" for value in values)


def _floats(text: str, place: str) -> list[float]:
    values = []
    for word in text.split():
        try:
            value = float(word)
        except ValueError:
            value = math.nan
        if not math.isfinite(value):
            raise UserError(
                f"{word!r} is not a number",
                where=place,
                remedy="write coordinates as x y pairs",
            )
        values.append(value)
    return values


def _bounds(text: str, place: str) -> tuple[float, float, float, float]:
    values = _floats(text, place)
    if len(values) != 4 or values[0] >= values[2] or values[1] >= values[3]:
        raise UserError(
            f"bounds must be x low, y low, x high, y high, not {text.strip()!r}",
            where=place,
            remedy="write for instance: bounds 0 0 40 40",
        )
    return values[0], values[1], values[2], values[3]


def _points(text: str, place: str, *, at_least: int) -> tuple[Point, ...]:
    values = _floats(text, place)
    points = tuple(zip(values[::2], values[1::2], strict=False))
    if len(values) % 2 or len(points) < at_least:
        raise UserError(
            f"{len(values)} coordinates do not make a shape of {at_least} or more points",
            where=place,
            remedy="write x y pairs",
        )
    if any(a == b for a, b in pairwise(points)):
        raise UserError(
            "two neighbouring points are equal", where=place, remedy="leave one of them out"
        )
    return points


def _checked(layout: Layout, where: str) -> Layout:
    """The layout, if an agent finds a place to start in it."""
    world = layout.world()
    x_low, y_low, x_high, y_high = layout.bounds
    grid = jnp.stack(
        jnp.meshgrid(jnp.linspace(x_low, x_high, 66)[1:-1], jnp.linspace(y_low, y_high, 66)[1:-1])
    ).reshape(2, -1)
    x, y, zero = *grid, jnp.zeros(grid.shape[1])
    share = float(world.free(Pose(x, y, zero, zero)).mean())
    if share < MIN_FREE_SHARE:
        raise UserError(
            f"an agent finds no free place to start (only {share:.0%} of the area is free)",
            where=where,
            remedy="shrink or remove the solids",
        )
    return layout
