"""What makes a layout impossible: plane geometry in NumPy, which is there at once."""

import math
from collections.abc import Callable, Sequence
from itertools import pairwise

import numpy as np
from jaxtyping import Bool, Float

from motorspace._errors import UserError

Point = tuple[float, float]
Polyline = tuple[Point, ...]
Bounds = tuple[float, float, float, float]
Place = Callable[[str, int], str]
"""Where a statement was written: its word, and which of its kind it is, from 0 on."""

Points = Float[np.ndarray, "P 2"]

RESOLUTION = 1e-3
"""Half the thickness of a wall, world units: what float32 must resolve everywhere."""

LONGEST_SIDE = 32_768.0
"""Neighbouring float32 numbers up to half of it differ by less than `RESOLUTION`."""

FARTHEST = 1e12
"""Neighbouring float64 numbers up to here differ by less than `RESOLUTION`."""

MIN_FREE_SHARE = 0.05


def check_layout(
    bounds: Bounds, walls: Sequence[Polyline], solids: Sequence[Polyline], place: Place
) -> None:
    """Return if a world can be built and an agent finds a place to start in it.

    Args:
        bounds: x low, y low, x high, y high, world units.
        walls: Points of each polyline.
        solids: Corners of each closed polygon, the first one not repeated.
        place: Names a statement in messages.

    Raises:
        UserError: Names the first fault, its place and the remedy.
    """
    _check_bounds(bounds, place("bounds", 0))
    for index, line in enumerate(walls):
        _check_points(line, bounds, place("wall", index))
        _check_lengths(line, place("wall", index))
    for index, corners in enumerate(solids):
        _check_points(corners, bounds, place("solid", index))
        _check_lengths((*corners, corners[0]), place("solid", index))
        _check_outline(corners, place("solid", index))
    polygons = [np.subtract(corners, bounds[:2]) for corners in solids]
    _check_overlaps(polygons, place)
    _check_freearea(bounds, walls, solids, sum((abs(area(p)) for p in polygons), 0.0), place)


def number(value: float) -> str:
    """The shortest decimal number that reads back as exactly this one.

    >>> number(20.0), number(0.1)
    ('20', '0.1')
    """
    return repr(float(value)).removesuffix(".0")


def _check_bounds(bounds: Bounds, where: str) -> None:
    x_low, y_low, x_high, y_high = bounds
    if not (x_low < x_high and y_low < y_high):
        raise UserError(
            f"bounds must be x low, y low, x high, y high, not {numbers(bounds)!r}",
            where=where,
            remedy="write for instance: bounds 0 0 40 40",
        )
    if max(x_high - x_low, y_high - y_low) > LONGEST_SIDE:
        raise UserError(
            f"the bounds {numbers(bounds)!r} are too large for float32, which cannot resolve "
            f"{RESOLUTION} units at that extent",
            where=where,
            remedy=f"choose a larger unit, so that no side is longer than {LONGEST_SIDE:,.0f}",
        )
    if max(map(abs, bounds)) > FARTHEST:
        raise UserError(
            f"the coordinates are too large: float64 cannot resolve {RESOLUTION} units "
            f"at {max(map(abs, bounds)):g}",
            where=where,
            remedy="move the layout closer to (0, 0)",
        )


def _check_points(points: Polyline, bounds: Bounds, where: str) -> None:
    x_low, y_low, x_high, y_high = bounds
    for point in points:
        if not (x_low <= point[0] <= x_high and y_low <= point[1] <= y_high):
            raise UserError(
                f"the point {_point(point)} is outside the bounds",
                where=where,
                remedy="move it inside, or enlarge the bounds",
            )


def _check_lengths(points: Polyline, where: str) -> None:
    for a, b in pairwise(points):
        length = math.hypot(b[0] - a[0], b[1] - a[1])
        if length < RESOLUTION:
            what = (
                f"two neighbouring points are equal, {_point(a)}"
                if a == b
                else f"the points {_point(a)} and {_point(b)} are only {length:.1g} units apart, "
                f"less than the {RESOLUTION} that can be resolved"
            )
            raise UserError(what, where=where, remedy="leave one of them out")


def _check_outline(corners: Polyline, where: str) -> None:
    """Refuse a polygon without an inside, or one whose inside is ambiguous."""
    points = np.subtract(corners, corners[0])
    along = points[np.argmax(np.linalg.norm(points, axis=1))]
    if np.abs(_cross(along, points)).max() < RESOLUTION * np.linalg.norm(along):
        raise UserError(
            "the solid has no area: its points lie on one line",
            where=where,
            remedy="write it as a wall, or correct its points",
        )
    meeting = _meeting_edges(points)
    if meeting is not None:
        one, other = (
            f"{_point(corners[i])} to {_point(corners[(i + 1) % len(corners)])}" for i in meeting
        )
        raise UserError(
            f"the solid crosses or touches itself, where {one} meets {other}",
            where=where,
            remedy="list its corners in order, once around, or split it into several solids",
        )


def _check_overlaps(polygons: Sequence[np.ndarray], place: Place) -> None:
    lows = np.reshape([p.min(axis=0) for p in polygons], (-1, 2))
    highs = np.reshape([p.max(axis=0) for p in polygons], (-1, 2))
    for i, polygon in enumerate(polygons):
        near = (lows[:i] < highs[i]).all(axis=-1) & (lows[i] < highs[:i]).all(axis=-1)
        for j in map(int, np.flatnonzero(near)):
            if _enters(polygon, polygons[j]) or _enters(polygons[j], polygon):
                raise UserError(
                    f"the solid overlaps another one ({place('solid', j).rpartition(', ')[2]})",
                    where=place("solid", i),
                    remedy="join them into one outline, or leave out the inner one",
                )


def _check_freearea(
    bounds: Bounds,
    walls: Sequence[Polyline],
    solids: Sequence[Polyline],
    solid_area: float,
    place: Place,
) -> None:
    """Refuse a world that is full. Solids do not overlap here, so that their areas add up."""
    width, height = bounds[2] - bounds[0], bounds[3] - bounds[1]
    area, thickness = width * height, 4 * RESOLUTION
    closed = [(*corners, corners[0]) for corners in solids]
    segments = np.reshape(list({s for line in (*walls, *closed) for s in pairwise(line)}), (-1, 4))
    lengths = [2 * width, 2 * height, *np.hypot(*(segments[:, 2:] - segments[:, :2]).T)]
    walled_area = sum((length + thickness) * thickness for length in lengths)
    if solid_area > (1 - MIN_FREE_SHARE) * area:
        raise UserError(
            f"an agent finds no free place to start: the solids cover {solid_area / area:.0%} "
            "of the area",
            where=place("", 0),
            remedy="shrink or remove solids",
        )
    if solid_area + walled_area > (1 - MIN_FREE_SHARE) * area:
        raise UserError(
            "an agent finds no free place to start: walls, and the "
            f"{thickness / 2} units to either side of them, fill the {width:g} x {height:g} units",
            where=place("", 0),
            remedy="enlarge the bounds, or remove walls",
        )


def numbers(values: Sequence[float]) -> str:
    """Numbers that read back exactly, with spaces between them."""
    return " ".join(number(value) for value in values)


def _point(point: Point) -> str:
    return f"({number(point[0])}, {number(point[1])})"


def _cross(a: Float[np.ndarray, "*Q 2"], b: Points) -> Float[np.ndarray, " P"]:
    """Cross products of vectors in the plane, one by one or all with the same."""
    return a[..., 0] * b[..., 1] - a[..., 1] * b[..., 0]


def area(polygon: Points) -> float:
    """Enclosed area; positive when the corners run counter-clockwise."""
    return float(_cross(polygon, np.roll(polygon, -1, axis=0)).sum() / 2)


def _meeting_edges(polygon: Points) -> tuple[int, int] | None:
    """Two edges that share more than the corner between them, by the corners they begin at."""
    num, end = len(polygon), np.roll(polygon, -1, axis=0)
    edges, following = end - polygon, np.roll(end, -1, axis=0) - end
    lengths = np.linalg.norm(edges, axis=1) * np.linalg.norm(following, axis=1)
    straight = np.abs(_cross(edges, following)) < 1e-9 * lengths
    turned_back = straight & ((edges * following).sum(axis=1) < 0)
    for i in range(num):
        if turned_back[i]:
            return i, (i + 1) % num
        others = np.arange(i + 2, num - (i == 0))
        met = meet(polygon[i], end[i], polygon[others], end[others])
        if met.any():
            return i, int(others[np.argmax(met)])
    return None


def meet(
    a: Float[np.ndarray, "*P 2"], b: Float[np.ndarray, "*P 2"], c: Points, d: Points
) -> Bool[np.ndarray, " P"]:
    """Whether segments from `a` to `b`, or the only one, meet those from `c` to `d`."""
    one_side = _cross(b - a, c - a) * _cross(b - a, d - a) > 0
    other_side = _cross(d - c, a - c) * _cross(d - c, b - c) > 0
    boxes = (np.minimum(a, b) <= np.maximum(c, d)) & (np.minimum(c, d) <= np.maximum(a, b))
    return ~one_side & ~other_side & boxes.all(axis=-1)


def _enters(polygon: Points, other: Float[np.ndarray, "Q 2"]) -> bool:
    """Whether the rim of a polygon, just within its edges, is somewhere inside another one.

    Each edge is cut where it meets the other polygon: a piece is then all inside or all outside.
    """
    inward = np.sign(area(polygon))
    end = np.roll(polygon, -1, axis=0)
    # Where an edge is beside all of the other polygon, so is its rim.
    low, high = other.min(axis=0) - RESOLUTION, other.max(axis=0) + RESOLUTION
    near = (np.minimum(polygon, end) < high) & (np.maximum(polygon, end) > low)
    for index in np.flatnonzero(near.all(axis=1)):
        a, b = polygon[index], end[index]
        along, length = b - a, np.linalg.norm(b - a)
        cuts = np.unique([0.0, 1.0, *_cuts(a, along, other)])
        pieces = np.diff(cuts) * length > RESOLUTION
        middles = a + along * ((cuts[1:] + cuts[:-1]) / 2)[pieces, None]
        rim = inward * np.array([-along[1], along[0]]) * (RESOLUTION / 2 / length)
        if _inside(middles + rim, other).any():
            return True
    return False


def _cuts(
    start: Float[np.ndarray, "2"], along: Float[np.ndarray, "2"], polygon: Points
) -> Float[np.ndarray, " C"]:
    """Where a segment meets the edges of a polygon, as shares of its length."""
    edges = np.roll(polygon, -1, axis=0) - polygon
    slant = _cross(along, edges)
    crossing = slant != 0
    offset, edges, slant = (polygon - start)[crossing], edges[crossing], slant[crossing]
    share, on_edge = _cross(offset, edges) / slant, -_cross(along, offset) / slant
    return share[(share > 0) & (share < 1) & (on_edge > -1e-9) & (on_edge < 1 + 1e-9)]


def _inside(points: Points, polygon: Float[np.ndarray, "Q 2"]) -> Bool[np.ndarray, " P"]:
    """Whether points lie inside a polygon (even-odd rule)."""
    (x, y), start, end = points.T[..., None], polygon, np.roll(polygon, -1, axis=0)
    rise = np.where(end[:, 1] == start[:, 1], 1.0, end[:, 1] - start[:, 1])
    crossing_x = start[:, 0] + (y - start[:, 1]) * (end[:, 0] - start[:, 0]) / rise
    spans = (start[:, 1] > y) != (end[:, 1] > y)
    return (spans & (crossing_x > x)).sum(axis=1) % 2 == 1
