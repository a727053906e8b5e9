"""Random rooms: the same for the same key, and every one can be reached."""

import jax
import numpy as np
import pytest
import shapely

from motorspace._errors import UserError
from motorspace.worlds.layouts import load_layout
from motorspace.worlds.rooms import random_rooms


def test_random_rooms_are_the_same_for_the_same_key(getkey):
    one, other = getkey(), getkey()
    assert random_rooms(key=one) == random_rooms(key=one)
    assert random_rooms(key=one) != random_rooms(key=other)


@pytest.mark.parametrize("seed", [0, 7, 2**31, 2**32 - 1])
def test_a_seed_stands_for_its_key(seed):
    named = load_layout(f"rooms:{seed}")
    assert named == random_rooms(key=seed) == random_rooms(key=jax.random.key(seed))


@pytest.mark.parametrize("seed", range(25))
def test_every_random_room_can_be_reached(seed):
    """The free space stays in one piece even for a body 0.4 units wide."""
    described = random_rooms(key=seed)
    walls = shapely.union_all(shapely.linestrings(np.array(described.segments()[0])))
    free = shapely.box(*described.bounds).difference(walls.buffer(0.2))
    assert len(described.walls) >= 6
    assert free.geom_type == "Polygon"


@pytest.mark.parametrize(
    "sizes",
    [
        {"min_room": 4.0, "door": 3.0},
        {"size": 1e9},
        {"size": float("nan")},
        {"door": 0.0},
        {"min_room": -1.0},
    ],
)
def test_rooms_that_do_not_fit_are_refused(sizes):
    with pytest.raises(UserError, match="do not fit"):
        random_rooms(**sizes, key=0)


def test_rooms_of_the_narrowest_doors_make_a_world():
    rooms = random_rooms(size=30.0, min_room=1.0, door=0.02, key=3)
    assert len(rooms.world().walls) > 100
