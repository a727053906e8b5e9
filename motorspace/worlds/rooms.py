"""Random rooms: layouts by recursive division."""

from collections.abc import Iterator
from typing import Any

import numpy as np

from motorspace._errors import UserError
from motorspace.worlds.layouts import Layout
from motorspace.worlds.validation import LONGEST_SIDE, Bounds, Polyline

NARROWEST_DOOR = 0.02
"""Walls are placed to a hundredth of a unit."""


def random_rooms(
    *, size: float = 40.0, min_room: float = 8.0, door: float = 3.0, key: Any
) -> Layout:
    """Return a layout of rooms where every wall has one door, so that every room can be reached.

    Args:
        size: Side of the square, world units.
        min_room: Smallest side of a room, world units.
        door: Width of the openings, world units.
        key: A JAX key, or the whole number that it is made from: `key=7` and
            `key=jax.random.key(7)` give the rooms named `rooms:7`. Same key, same rooms.

    Raises:
        UserError: For rooms or doors that do not fit.

    >>> len(random_rooms(key=7).walls) > 6
    True
    """
    if not (door >= NARROWEST_DOOR and 2 * door < min_room <= size <= LONGEST_SIDE):
        raise UserError(
            f"rooms of side {min_room} with doors of {door} do not fit a square of {size}",
            remedy=f"keep {NARROWEST_DOOR} <= door, 2 x door < min_room <= size <= "
            f"{LONGEST_SIDE:,.0f}",
        )
    square = (0.0, 0.0, size, size)
    walls = tuple(_divide(np.random.default_rng(_words(key)), square, min_room, door))
    return Layout("random rooms", square, walls)


def _words(key: Any) -> list[int]:
    """The 32-bit words of a JAX key; those of a small seed are known without JAX."""
    if isinstance(key, int):
        return [0, key]
    import jax

    words: list[int] = np.asarray(jax.random.key_data(key)).ravel().tolist()
    return words


def _divide(
    rng: np.random.Generator, room: Bounds, min_room: float, door: float
) -> Iterator[Polyline]:
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
