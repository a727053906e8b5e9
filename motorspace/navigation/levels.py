"""How hard a problem is, and the random rooms that it is posed in."""

from dataclasses import dataclass
from functools import lru_cache
from typing import TYPE_CHECKING

from motorspace._errors import UserError
from motorspace.worlds.checks import one_of, whole
from motorspace.worlds.rooms import random_rooms

if TYPE_CHECKING:
    from motorspace.worlds.world import AbstractWorld, WalledWorld

FIRST_SEED = {"train": 0, "test": 1_000_000}
"""The seeds of the rooms that policies are trained in, and of those that they never see."""


@dataclass(frozen=True)
class Level:
    """Distances in world units, walked around walls; times in commands."""

    nearest: float
    """Goals are at least so far away."""
    farthest: float
    """Goals are at most so far away."""
    min_room: float
    """The smallest side of a room; the whole is 40 units wide."""
    max_steps: int
    """Commands until an episode is truncated."""
    wander: tuple[int, int]
    """Fewest and most random commands of one who must find home."""


LEVELS = {
    1: Level(2.0, 5.0, min_room=16.0, max_steps=40, wander=(8, 16)),
    2: Level(2.0, 8.0, min_room=8.0, max_steps=50, wander=(12, 32)),
    3: Level(6.0, 16.0, min_room=6.5, max_steps=100, wander=(32, 64)),
}


def level_of(number: int) -> Level:
    """The level with a number. Raises `UserError` for one that there is not."""
    if number not in LEVELS:
        raise UserError(
            f"there is no level {number!r}", remedy=f"choose one of {', '.join(map(str, LEVELS))}"
        )
    return LEVELS[number]


def layouts(level: Level, split: str, num: int) -> "tuple[AbstractWorld, ...]":
    """The worlds that a word stands for: random rooms, or the one world of this name.

    Args:
        level: How large rooms are.
        split: `"train"`, `"test"`, both in turn as `"train+test"`, or the name of a world such
            as `"paper"`.
        num: Random layouts of a split.

    Raises:
        UserError: As `rooms`, and for a world that there is not.
    """
    from motorspace.worlds.scenario import world_of

    names = split.split("+")
    if not set(names) <= set(FIRST_SEED):
        return (world_of(split),)
    each = [rooms(level, name, num) for name in names]
    return tuple(world for together in zip(*each, strict=True) for world in together)


@lru_cache(maxsize=4)
def rooms(level: Level, split: str, num: int) -> "tuple[WalledWorld, ...]":
    """`num` different random layouts; those of training and of test have no seed in common.

    Raises:
        UserError: For fewer than one layout, or more than there are seeds.
    """
    if whole("the number of layouts", num) > FIRST_SEED["test"]:
        raise UserError(f"there are no {num} layouts", remedy="use a million at most")
    first = FIRST_SEED[one_of("split", split, tuple(FIRST_SEED))]
    return tuple(
        random_rooms(min_room=level.min_room, door=3.0, key=seed).world()
        for seed in range(first, first + num)
    )
