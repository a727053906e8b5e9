"""Layouts as files, and messages that say where a file is broken."""

import jax
import numpy as np
import pytest
import shapely

from motorspace import UserError, layout, layout_names, random_rooms
from motorspace.worlds.layouts import load_layout, parse_layout


@pytest.mark.parametrize("name", [*layout_names(), "rooms:4"])
def test_a_layout_survives_its_own_text(name):
    described = load_layout(name)
    assert parse_layout(described.text(), where="copy") == described
    assert len(described.world().walls) == len(described.segments()[0])


def test_the_bundled_layouts():
    assert {"paper", "empty"} <= set(layout_names())
    assert layout("paper").bounds == (0.0, 0.0, 40.0, 40.0)
    assert layout("empty").walls.shape == (4, 2, 2)


@pytest.mark.parametrize(
    ("text", "line", "words"),
    [
        ("bounds 0 0 40 40\nwal 0 0 1 1", 2, "unknown statement 'wal'"),
        ("bounds 0 0 40", 1, "bounds must be"),
        ("bounds 0 40 40 0", 1, "bounds must be"),
        ("\n\nbounds 0 0 40 forty", 3, "'forty' is not a number"),
        ("bounds 0 0 40 inf", 1, "'inf' is not a number"),
        ("bounds 0 0 40 40\nwall 1 1", 2, "do not make a shape"),
        ("bounds 0 0 40 40\nwall 1 1 2", 2, "do not make a shape"),
        ("bounds 0 0 40 40\nsolid 1 1 2 2", 2, "do not make a shape"),
        ("bounds 0 0 40 40\nwall 1 1 1 1", 2, "neighbouring points are equal"),
    ],
)
def test_a_broken_file_is_told_with_its_name_and_line(tmp_path, text, line, words):
    path = tmp_path / "broken.layout"
    path.write_text(text)
    with pytest.raises(UserError) as caught:
        layout(str(path))
    assert f"{path}, line {line}: " in str(caught.value)
    assert words in str(caught.value)


@pytest.mark.parametrize(
    ("content", "words"),
    [
        (b"wall 0 0 1 1", "no bounds"),
        (b"bounds 0 0 4 4\nsolid 0 0 4 0 4 4 0 4", "no free place"),
        (b"\xff\xfe\x00", "not UTF-8"),
    ],
)
def test_a_useless_file_is_told_with_its_name(tmp_path, content, words):
    path = tmp_path / "useless.layout"
    path.write_bytes(content)
    with pytest.raises(UserError, match=words) as caught:
        layout(str(path))
    assert str(path) in str(caught.value)


@pytest.mark.parametrize("name", ["nowhere", "rooms:x", "rooms:", "absent.layout"])
def test_an_unknown_layout_is_told(name):
    with pytest.raises(UserError):
        layout(name)


def test_random_rooms_are_the_same_for_the_same_key(getkey):
    one, other = getkey(), getkey()
    assert random_rooms(key=one) == random_rooms(key=one)
    assert random_rooms(key=one) != random_rooms(key=other)


@pytest.mark.parametrize("seed", range(25))
def test_every_random_room_can_be_reached(seed):
    """The free space stays in one piece even for a body 0.4 units wide."""
    described = random_rooms(key=jax.random.key(seed))
    walls = shapely.union_all(shapely.linestrings(np.array(described.segments()[0])))
    free = shapely.box(*described.bounds).difference(walls.buffer(0.2))
    assert len(described.walls) >= 6
    assert free.geom_type == "Polygon"


def test_rooms_that_do_not_fit_are_refused(getkey):
    with pytest.raises(UserError, match="do not fit"):
        random_rooms(min_room=4.0, door=3.0, key=getkey())
