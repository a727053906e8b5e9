"""From the cells of an occupancy grid to a few walls.

What a robot can stand on is the largest connected region of free cells. Everything else becomes
solid: obstacles within the region, and all that is around it. Unknown cells are no place to stand,
but for pinholes that no beam happened to hit: unknown cells with nothing but free ones around them.
"""

import math
from typing import NamedTuple

import numpy as np
from jaxtyping import Bool, Float

from motorspace._errors import UserError
from motorspace.worlds.layouts import Layout
from motorspace.worlds.maps.simplified import simplified
from motorspace.worlds.validation import Point, Polyline, area

TOLERANCE = 0.5
"""Cells by which a wall may leave the boundary that it is traced along."""

DIGITS = 4
"""Decimals of coordinates: a tenth of what worlds resolve."""


class Grid(NamedTuple):
    """Cells, the first row at the bottom, and where they are."""

    free: Bool[np.ndarray, "H W"]
    occupied: Bool[np.ndarray, "H W"]
    """All other cells are unknown."""
    resolution: float
    """World units along a cell."""
    origin: tuple[float, float, float] = (0.0, 0.0, 0.0)
    """x, y, angle of the lower left corner of the first cell."""


def traced(grid: Grid, title: str, *, where: object) -> tuple[Layout, list[str]]:
    """The layout of a grid, and notes on what was left out.

    Raises:
        UserError: No cell is free.
    """
    filled, notes = _without_pinholes(grid)
    region = _largest_region(filled, notes, where)
    boundary, holes = _boundaries(region)
    notes.append(f"{len(holes)} obstacles inside the region")
    rings = [_placed(ring, grid) for ring in simplified([boundary, *holes], TOLERANCE)]
    return _layout(rings[0], rings[1:], round(grid.resolution, DIGITS), title), notes


def _without_pinholes(grid: Grid) -> tuple[Bool[np.ndarray, "H W"], list[str]]:
    """The free cells, and the unknown ones that have neither walls nor the rim beside them."""
    from scipy import ndimage

    # Around the map nothing is known to be free.
    closed, occupied = (np.pad(c, 1, constant_values=True) for c in (~grid.free, grid.occupied))
    labels, num = ndimage.label(closed, np.ones((3, 3)))
    has_wall = np.bincount(labels[occupied], minlength=num + 1) > 0
    pinholes = closed & ~has_wall[labels]
    notes = [f"{pinholes.sum()} unknown cells amid free ones count as free"] * bool(pinholes.any())
    return (~closed | pinholes)[1:-1, 1:-1], notes


def _largest_region(
    free: Bool[np.ndarray, "H W"], notes: list[str], where: object
) -> Bool[np.ndarray, "H+2 W+2"]:
    """The largest region of free cells that share sides, with a rim of other cells around it."""
    from scipy import ndimage

    labels, num = ndimage.label(free)
    if not num:
        raise UserError(
            "no cell of the map is free", where=where, remedy="check negate and free_thresh"
        )
    sizes = np.bincount(labels.ravel())[1:]
    largest = int(np.argmax(sizes)) + 1
    rest = int(sizes.sum() - sizes[largest - 1])
    notes.append(f"{sizes[largest - 1]} free cells are connected: the region of the world")
    if rest:
        notes.append(f"{rest} free cells in {num - 1} other regions cannot be reached: left out")
    return np.pad(labels == largest, 1)


def _boundaries(
    region: Bool[np.ndarray, "H W"],
) -> tuple[Float[np.ndarray, "P 2"], list[Float[np.ndarray, "Q 2"]]]:
    """The outer boundary of the region and those of its holes, in cells, each point once.

    Marching squares: lines run midway between free and other cells and cut corners, so that they
    neither touch nor cross. Corners between straight pieces are put back.
    """
    import contourpy

    lines = contourpy.contour_generator(z=region.astype(np.float32)).lines(0.5)
    # Cells have their middles at half numbers; the rim is one cell wide.
    rings = _with_corners([np.asarray(line)[:-1] - 0.5 for line in lines])
    areas = [abs(area(ring)) for ring in rings]
    outer = int(np.argmax(areas))
    return rings[outer], [ring for index, ring in enumerate(rings) if index != outer]


def _with_corners(rings: list[np.ndarray]) -> list[np.ndarray]:
    """The rings with the corners of cells that were cut off between two straight pieces."""
    ends = [np.roll(ring, -1, axis=0) for ring in rings]
    cut = [(ring != end).all(axis=1) for ring, end in zip(rings, ends, strict=True)]
    # Of the two ends of a cut, one has the corner's x, which is whole, and one its y.
    corners = [np.where(ring % 1 == 0, ring, end) for ring, end in zip(rings, ends, strict=True)]
    whole = np.concatenate([c[k] for c, k in zip(corners, cut, strict=True)])
    found, counts = np.unique(whole, axis=0, return_counts=True)
    # Where two cuts face each other, both lines would run through the one corner.
    shared = {(x, y) for x, y in found[counts > 1].tolist()}
    restored = []
    for ring, corner, is_cut in zip(rings, corners, cut, strict=True):
        between = is_cut & ~np.roll(is_cut, 1) & ~np.roll(is_cut, -1)
        at = [
            i for i in np.flatnonzero(between).tolist() if tuple(corner[i].tolist()) not in shared
        ]
        restored.append(np.insert(ring, [i + 1 for i in at], corner[at], axis=0))
    return restored


def _layout(rim: Polyline, holes: list[Polyline], margin: float, title: str) -> Layout:
    x, y = np.array(rim).T
    low_x, low_y, high_x, high_y = (
        round(float(value), DIGITS)
        for value in (x.min() - margin, y.min() - margin, x.max() + margin, y.max() + margin)
    )
    bounds = (low_x, low_y, high_x, high_y)
    return Layout(title.replace("#", " "), bounds, (), (*outside(rim, bounds), *holes))


def outside(rim: Polyline, bounds: tuple[float, float, float, float]) -> tuple[Polyline, Polyline]:
    """Two solids, above and below, that fill the bounds around a closed outline.

    They part at its leftmost and its rightmost corner, from where nothing of it lies in the way.
    """
    x_low, y_low, x_high, y_high = bounds
    points = list(rim)
    if area(np.array(points)) > 0:
        points.reverse()
    # Clockwise: from the leftmost corner over the top to the rightmost one.
    left = min(range(len(points)), key=lambda i: points[i])
    points = points[left:] + points[:left]
    right = max(range(len(points)), key=lambda i: points[i])
    upper, lower = points[: right + 1], points[right:] + points[:1]
    left_y, right_y = points[0][1], points[right][1]
    above = ((x_low, left_y), *upper, (x_high, right_y), (x_high, y_high), (x_low, y_high))
    below = ((x_high, right_y), *lower, (x_low, left_y), (x_low, y_low), (x_high, y_low))
    return above, below


def _placed(ring: Float[np.ndarray, "P 2"], grid: Grid) -> Polyline:
    """Points in cells as world units."""
    x, y, angle = grid.origin
    cos, sin = math.cos(angle), math.sin(angle)
    dx, dy = grid.resolution * ring.T
    points = np.stack([x + cos * dx - sin * dy, y + sin * dx + cos * dy], axis=-1)
    found: list[Point] = [(a, b) for a, b in points.round(DIGITS).tolist()]
    return tuple(found)
