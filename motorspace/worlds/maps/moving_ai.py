"""Grid maps of the MovingAI benchmarks: rows of signs, a world unit a cell."""

import re
from pathlib import Path

import numpy as np

from motorspace._errors import UserError
from motorspace.worlds.layouts import Layout
from motorspace.worlds.maps.files import map_text
from motorspace.worlds.maps.occupancy import Grid, traced

HEAD = re.compile(r"type\s+\w+\s+height\s+(\d{1,6})\s+width\s+(\d{1,6})\s+map\s*\n")

FREE = ".GS"
SIGNS = FREE + "@OTW"
"""Ground, ground and swamp; out of bounds, out of bounds, trees and water."""


def read_map(path: Path) -> tuple[Layout, list[str]]:
    """The layout of a map, one world unit a cell, and notes on what was left out.

    Raises:
        UserError: Names the line at fault.
    """
    text = map_text(path).replace("\r\n", "\n")
    head = HEAD.match(text)
    if head is None:
        raise UserError(
            "the map has no head",
            where=path,
            remedy="begin with the lines: type octile, height N, width N, map",
        )
    height, width = int(head[1]), int(head[2])
    first = text[: head.end()].count("\n") + 1
    rows = text[head.end() :].split("\n")
    while rows and not rows[-1]:
        rows.pop()
    if len(rows) != height:
        raise UserError(
            f"the map has {len(rows)} rows, and its head says {height}",
            where=path,
            remedy="correct the head, or copy the map again",
        )
    for number, row in enumerate(rows, start=first):
        wrong = sorted(set(row) - set(SIGNS))
        if len(row) != width or wrong:
            what = f"the sign {wrong[0]!r}" if wrong else f"{len(row)} cells, not {width}"
            raise UserError(
                f"the row has {what}", where=f"{path}, line {number}", remedy=f"write {SIGNS} alone"
            )
    signs = np.frombuffer("".join(rows).encode("ascii"), np.uint8).reshape(height, width)
    free = np.isin(signs, np.frombuffer(FREE.encode(), np.uint8))
    return traced(Grid(free[::-1], ~free[::-1], 1.0), path.stem, where=path)
