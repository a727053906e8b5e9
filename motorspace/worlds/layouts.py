"""Layouts: descriptions of walls, by name or from a file. Reading one needs no JAX.

A layout file is plain text, one statement a line, world units; `#` starts a comment:

```
title   Two rooms and a pillar
bounds  0 0 40 40                    # x low, y low, x high, y high: the outer walls
wall    20 0  20 17                  # a polyline: x y pairs, two or more
solid   8 8  10 8  10 10  8 10       # a closed polygon in whose inside nothing stands
paint   texture:4                    # colours of all walls (see `paint`); flat where none is said
```
"""

import os
from dataclasses import dataclass, replace
from difflib import get_close_matches
from itertools import pairwise
from pathlib import Path
from typing import TYPE_CHECKING, Literal

import numpy as np

from motorspace._errors import UserError
from motorspace.worlds.layout_text import read_statements
from motorspace.worlds.paint import PLAIN, Paint, parse_paint
from motorspace.worlds.validation import Bounds, Point, Polyline, check_layout, numbers

if TYPE_CHECKING:
    from motorspace.worlds.world import WalledWorld

Segment = tuple[Point, Point]

BUNDLED = Path(__file__).parent / "layouts"

INDEXED_FROM = 100
"""Walls from which on looking up those around a place is faster than visiting all."""

NEAR = 1024.0
"""Coordinates up to here are kept as they are: float32 resolves a ten thousandth of a unit."""

LARGEST_SEED = 2**32 - 1

LARGEST_SIDE = 1000
"""Nodes along a lattice; there is one sensor for each node."""


@dataclass(frozen=True)
class Layout:
    """A description of a walled world, in the coordinates of its file, world units.

    Args:
        title: One line of text.
        bounds: x low, y low, x high, y high; the outer walls run along them.
        walls: Points of each polyline, two or more.
        solids: Corners of each closed polygon in whose inside nothing stands.
        paint: The colours of its walls, which only eyes see.

    Raises:
        UserError: For a title that contains the sign of a comment.

    >>> Layout("A wall", (0.0, 0.0, 8.0, 8.0), (((4.0, 0.0), (4.0, 5.0)),)).origin
    (0.0, 0.0)
    """

    title: str
    bounds: Bounds
    walls: tuple[Polyline, ...] = ()
    solids: tuple[Polyline, ...] = ()
    paint: Paint = PLAIN

    def __post_init__(self) -> None:
        if "#" in self.title:
            raise UserError(
                "a title cannot contain '#', which starts a comment",
                where=f"layout {self.title!r}",
                remedy="leave it out",
            )
        object.__setattr__(self, "title", " ".join(self.title.split()))

    @property
    def origin(self) -> Point:
        """What to add to a position in `world()` for the coordinates of the layout.

        (0, 0) unless the layout is so far from it that float32 would lose precision: then a
        whole number near the middle of the bounds.
        """
        if max(map(abs, self.bounds)) <= NEAR:
            return 0.0, 0.0
        x_low, y_low, x_high, y_high = self.bounds
        return float(round((x_low + x_high) / 2)), float(round((y_low + y_high) / 2))

    def segments(self) -> tuple[list[Segment], list[Segment]]:
        """All wall segments, the outer ones included, and those of the solids alone."""
        x_low, y_low, x_high, y_high = self.bounds
        outer = ((x_low, y_low), (x_high, y_low), (x_high, y_high), (x_low, y_high))
        solids = [s for polygon in self.solids for s in _closed(polygon)]
        inner = [s for line in self.walls for s in pairwise(line)]
        return [*_closed(outer), *inner, *solids], solids

    def world(self) -> "WalledWorld":
        """The world with these walls, relative to `origin`, in float32.

        Raises:
            UserError: For walls, solids or bounds of which no world can be made.
        """
        import jax.numpy as jnp

        from motorspace.worlds.tiles import tiled
        from motorspace.worlds.world import WalledWorld

        check_layout(self.bounds, self.walls, self.solids, self._place)
        walls, solids = (np.reshape(s, (-1, 2, 2)) - self.origin for s in self.segments())
        x_low, y_low, x_high, y_high = np.subtract(self.bounds, 2 * self.origin).tolist()
        bounds = (x_low, y_low, x_high, y_high)
        tiles = tiled(walls, bounds) if len(walls) >= INDEXED_FROM else None
        coat = self.paint.coat(walls)
        return WalledWorld(
            jnp.asarray(walls, jnp.float32), jnp.asarray(solids, jnp.float32), bounds, tiles, coat
        )

    def text(self) -> str:
        """The layout in the file format of this module; `parse_layout` gives it back exactly."""
        lines = [f"title   {self.title}", f"bounds  {numbers(self.bounds)}"]
        for word, shapes in (("wall ", self.walls), ("solid", self.solids)):
            lines += [f"{word}   {'  '.join(numbers(p) for p in shape)}" for shape in shapes]
        if self.paint != PLAIN:
            lines.append(f"paint   {self.paint.name}")
        return "\n".join(lines) + "\n"

    def _place(self, word: str, index: int) -> str:
        return f"layout {self.title!r}" + (f", {word} {index + 1}" if word else "")


@dataclass(frozen=True)
class NamedWorld:
    """What the name of a world stands for."""

    kind: Literal["layout", "rooms", "lattice"]
    argument: str | int
    """A bundled layout or the path of a file; the seed of random rooms; the side of a lattice."""


def layout(name: str | Path, *, paint: str | None = None) -> "WalledWorld":
    """Return the world of a bundled layout, of a layout file, of a map, or of random rooms.

    Args:
        name: One of `layout_names()`, the path of a layout or a map, or `"rooms:SEED"`.
        paint: The colours of its walls, such as `"texture:4"`; by default the layout's own.

    Raises:
        UserError: For an unknown name or paint, or a broken file.
    """
    return painted(load_layout(name), paint).world()


def painted(layout: Layout, paint: str | None) -> Layout:
    """The layout in other colours, or as it is. Raises `UserError` for an unknown paint."""
    return layout if paint is None else replace(layout, paint=parse_paint(paint, where="paint"))


def layout_names() -> tuple[str, ...]:
    """Return the names of the bundled layouts.

    >>> layout_names()
    ('corridors', 'empty', 'four_rooms', 'paper', 'pillars')
    """
    return tuple(sorted(path.stem for path in BUNDLED.glob("*.layout")))


def load_layout(name: str | Path) -> Layout:
    """Return the description behind `layout(name)`. Arguments and errors are the same."""
    named = parse_world_name(name)
    if named.kind == "rooms":
        from motorspace.worlds.rooms import random_rooms

        return random_rooms(key=named.argument)
    if named.kind == "lattice":
        raise UserError(
            "a lattice has no walls and no layout",
            where=str(name),
            remedy=f"choose one of {_choices(layout_names(), 'rooms:SEED')}",
        )
    known = named.argument in layout_names()
    path = BUNDLED / f"{named.argument}.layout" if known else Path(str(named.argument))
    if not known:
        from motorspace.worlds.maps.reading import kind_of_map, read_map

        if kind := kind_of_map(path):
            return read_map(path, kind)[0]
    return parse_layout(_text_in(path), where=str(named.argument))


def layout_content(name: str | Path) -> str:
    """Return the name of a world, or the content of a layout file, checked.

    Raises:
        UserError: For an unknown name or a broken file.
    """
    if "\n" in str(name):
        return parse_layout(str(name)).text()
    named = parse_world_name(name)
    own_file = named.kind == "layout" and named.argument not in layout_names()
    return load_layout(name).text() if own_file else str(name)


def parse_world_name(name: str | Path) -> NamedWorld:
    """Return what the name of a world stands for. No file is read.

    Args:
        name: A bundled layout, the path of a layout file, `"rooms:SEED"` or `"lattice:SIDE"`.

    Raises:
        UserError: For an unknown name, or a seed or side out of range.

    >>> parse_world_name("rooms:7")
    NamedWorld(kind='rooms', argument=7)
    """
    text = str(name)
    kind, _, argument = text.partition(":")
    if kind == "rooms" and argument:
        return NamedWorld("rooms", _whole(argument, 0, LARGEST_SEED, text, "seed of random rooms"))
    if kind == "lattice" and argument:
        return NamedWorld("lattice", _whole(argument, 1, LARGEST_SIDE, text, "side of a lattice"))
    if text in layout_names() or os.path.exists(text) or Path(text).suffix:
        return NamedWorld("layout", text)
    known = (*layout_names(), "rooms:SEED", "lattice:SIDE")
    near = get_close_matches(text, known, 1)
    raise UserError(
        f"there is no layout {_shortened(text)!r}"
        + "".join(f" (perhaps {name!r})" for name in near),
        remedy=f"choose one of {_choices(known)}",
    )


def parse_layout(text: str, *, where: str | Path = "layout") -> Layout:
    """Return the layout written in `text`.

    Args:
        text: Statements of the file format of this module.
        where: What to call the text in messages.

    Raises:
        UserError: Names the line at fault, the fault and the remedy.

    >>> parse_layout("bounds 0 0 8 8").bounds
    (0.0, 0.0, 8.0, 8.0)
    """
    return Layout(*read_statements(text, where=str(where)))


def _text_in(path: Path) -> str:
    """The text in a file, UTF-8 or Latin-1."""
    try:
        content = path.read_bytes()
    except (OSError, ValueError) as error:
        reason = getattr(error, "strerror", None) or "no such file or directory"
        raise UserError(
            f"the layout cannot be read ({reason})",
            where=path,
            remedy=f"check the path, or choose one of {', '.join(layout_names())}",
        ) from None
    if b"\0" in content:
        raise UserError(
            "the layout cannot be read (it is not UTF-8 text)",
            where=path,
            remedy="save it as plain text, UTF-8",
        )
    try:
        return content.decode("utf-8")
    except UnicodeDecodeError:
        return content.decode("latin-1")


def _whole(text: str, low: int, high: int, name: str, what: str) -> int:
    """A whole number in a range. Python refuses to read very long ones, so their length counts."""
    short = text.isascii() and text.isdecimal() and len(text) <= 20
    if not short or not low <= int(text) <= high:
        raise UserError(
            f"the {what} must be a whole number from {low} to {high}, not {_shortened(text)!r}",
            where=f"layout {_shortened(name)!r}",
            remedy=f"write for instance {name.partition(':')[0]}:7",
        )
    return int(text)


def _shortened(text: str) -> str:
    return text if len(text) <= 60 else f"{text[:60]}..."


def _choices(*names: str | tuple[str, ...]) -> str:
    flat = [n for entry in names for n in ((entry,) if isinstance(entry, str) else entry)]
    return f"{', '.join(flat)}, or a layout file"


def _closed(polygon: Polyline) -> list[Segment]:
    return list(zip(polygon, polygon[1:] + polygon[:1], strict=True))
