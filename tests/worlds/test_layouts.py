"""Layouts as files: what is read, and messages that say where a file is broken."""

import hashlib
import subprocess
import sys
from pathlib import Path

import jax
import numpy as np
import pytest
import shapely

import motorspace
from motorspace._errors import UserError
from motorspace.worlds.layouts import (
    Layout,
    NamedWorld,
    layout,
    layout_names,
    load_layout,
    parse_layout,
    parse_world_name,
)

SQUARE = "bounds 0 0 40 40\n"

WORLDS = {
    "corridors": "b7f2b267c6b2f4cc",
    "empty": "76b320dd4ba5368c",
    "four_rooms": "1efcf5ba1c00fe7e",
    "paper": "5453a07a04132a9b",
    "pillars": "0486b82d80493f35",
    "rooms:0": "d0bc27edca61e901",
    "rooms:1": "b9f336781bcf6101",
}
"""Walls, solids and bounds of worlds that results were published on, as SHA-256."""


def digest(world):
    content = [np.asarray(world.walls), np.asarray(world.solids), np.array(world.bounds)]
    return hashlib.sha256(b"".join(array.tobytes() for array in content)).hexdigest()[:16]


@pytest.mark.parametrize("name", WORLDS)
def test_the_worlds_behind_published_results_do_not_change(name):
    assert digest(layout(name)) == WORLDS[name]


def test_the_bundled_layouts():
    assert set(layout_names()) == {name for name in WORLDS if ":" not in name}
    assert layout("paper").bounds == (0.0, 0.0, 40.0, 40.0)
    assert layout("empty").walls.shape == (4, 2, 2)


AWKWARD = Layout(
    "  Numbers\tthat :g would\nround, ü ",
    (-1 / 3, -0.1, 123.45678901234567, 1e3 / 7),
    (((0.1 + 0.2, 1e-5), (100 / 3, 2.0)),),
    (((50.0, 50.0), (60.00000000000001, 50.0), (55.0, 59.99999999999999)),),
)
FAR_AWAY = Layout(
    "",
    (450000.25, 5400000.1, 450040.3, 5400040.0),
    (((450020.7, 5400000.1), (450021.0, 5400020.9)),),
)


@pytest.mark.parametrize(
    "described",
    [*map(load_layout, [*layout_names(), "rooms:4"]), AWKWARD, FAR_AWAY],
    ids=lambda described: described.title or "far away",
)
def test_a_layout_survives_its_own_text_bit_for_bit(described):
    copy = parse_layout(described.text())
    assert copy == described
    assert copy.text() == described.text()
    assert digest(copy.world()) == digest(described.world())


def test_a_title_is_one_line():
    assert AWKWARD.title == "Numbers that :g would round, ü"
    with pytest.raises(UserError, match="cannot contain '#'"):
        Layout("Plan #3", (0.0, 0.0, 1.0, 1.0))


PLAN = b"title Caf\xc3\xa9\nbounds 0 0 40 40 # comment\nwall 10 0 10 20\nsolid 20 20 25 20 22 24\n"


@pytest.mark.parametrize(
    "content",
    [
        PLAN,
        PLAN.replace(b" ", b"\t"),
        PLAN.replace(b"\n", b"\r\n"),
        PLAN.replace(b"\n", b"\r"),
        b"\xef\xbb\xbf" + PLAN,
        PLAN.replace(b"\xc3\xa9", b"\xe9"),
        PLAN.replace(b" 22 24", b" 22 24 20 20"),
        b"\n \n# only a comment\n" + PLAN.replace(b"wall ", b"   wall    "),
    ],
    ids=["plain", "tabs", "crlf", "cr", "bom", "latin-1", "closed solid", "blanks"],
)
@pytest.mark.parametrize("kind", [str, Path])
def test_files_as_editors_write_them_are_read(tmp_path, content, kind):
    path = tmp_path / "plan.layout"
    path.write_bytes(content)
    assert load_layout(kind(path)) == parse_layout(PLAN.decode())


FAULTS = [
    ("wal 0 0 1 1", "unknown statement 'wal' (perhaps 'wall')"),
    ("BOUNDS 0 0 1 1", "unknown statement 'BOUNDS' (perhaps 'bounds')"),
    ("{", "unknown statement '{';"),
    ("bounds 0 0 10 10", "a second statement 'bounds' (the first is in line 1)"),
    ("wall 1 1", "2 coordinates do not make a shape of 2 or more points"),
    ("wall 1 1 2", "3 coordinates do not make a shape"),
    ("wall", "0 coordinates do not make a shape"),
    ("solid 1 1 2 2", "do not make a shape of 3 or more points"),
    ("solid 1 1 2 2 1 1", "do not make a shape of 3 or more points"),
    ("wall 1 1 2 nan", "'nan' is not a finite number"),
    ("wall 1 1 2 1e999", "'1e999' is not a finite number"),
    ("wall 1,1 2,2", "'1,1' is not a finite number; write numbers with decimal points"),
    ("wall 1 1 1 1", "two neighbouring points are equal, (1, 1)"),
    ("solid 1 1 5 1 5 1 3 3", "two neighbouring points are equal, (5, 1)"),
    ("wall 1 1 1.0000001 1", "the points (1, 1) and (1.0000001, 1) are only 1e-07 units apart"),
    ("solid 1 1 5 1 3 3 1 1.00001", "the points (1, 1.00001) and (1, 1) are only 1e-05 units"),
    ("wall 50 0 50 10", "the point (50, 0) is outside the bounds"),
    ("wall 1 1 2 40.001", "the point (2, 40.001) is outside the bounds"),
    ("solid 1 1 5 1 -3 3", "the point (-3, 3) is outside the bounds"),
    ("wall 1 1 2 1e300", "the point (2, 1e+300) is outside the bounds"),
    ("solid 1 1 2 2 3 3", "the solid has no area: its points lie on one line"),
    ("solid 1 1 2 2 3 3 2.5 2.5", "the solid has no area"),
    ("solid 1 1 5 5 5 1 1 5", "crosses or touches itself, where (1, 1) to (5, 5) meets (5, 1)"),
    ("solid 1 1 9 1 9 9 5 1", "crosses or touches itself"),
    ("solid 1 1 12 1 9 1 9 9 1 9", "itself, where (1, 1) to (12, 1) meets (12, 1) to (9, 1)"),
    ("solid 1 1 5 1 5 5 1 5 1 1 5 1 5 5 1 5", "crosses or touches itself"),
    ("title a\ntitle b", "a second statement 'title' (the first is in line 2)"),
    ("solid 1 1 5 1 5 5 1 5\nsolid 3 3 7 3 7 7 3 7", "overlaps another one (line 2)"),
    ("solid 1 1 5 1 5 5 1 5\nsolid 5 5 5 1 1 1 1 5", "overlaps another one (line 2)"),
    ("solid 1 1 9 1 9 9 1 9\nsolid 3 3 5 3 5 5 3 5", "overlaps another one (line 2)"),
    ("solid 1 1 3 1 3 2 1 2\nsolid 2 1 4 1 4 2 2 2", "overlaps another one (line 2)"),
]


@pytest.mark.parametrize(("lines", "words"), FAULTS)
def test_a_broken_line_is_named(tmp_path, lines, words):
    path = tmp_path / "broken.layout"
    path.write_text(SQUARE + lines)
    with pytest.raises(UserError) as caught:
        layout(path)
    assert str(caught.value).startswith(f"{path}, line {2 + lines.count(chr(10))}: ")
    assert words in str(caught.value)
    assert caught.value.remedy


@pytest.mark.parametrize(
    ("bounds", "words"),
    [
        ("0 0 40", "bounds must be x low, y low, x high, y high, not '0 0 40'"),
        ("0 40 40 0", "bounds must be x low, y low, x high, y high, not '0 40 40 0'"),
        ("0 0 40 0", "bounds must be"),
        ("0 0 40 forty", "'forty' is not a finite number"),
        ("0 0 40 inf", "'inf' is not a finite number"),
        ("0 0 1e9 1e9", "too large for float32, which cannot resolve 0.001 units"),
        ("0 0 32769 10", "too large for float32"),
        ("-1e308 -1e308 1e308 1e308", "too large for float32"),
        ("1e15 0 1000000000000040 40", "float64 cannot resolve 0.001 units at 1e+15"),
    ],
)
def test_broken_bounds_are_named(bounds, words):
    with pytest.raises(UserError) as caught:
        parse_layout(f"# a comment\n\nbounds {bounds}", where="plan")
    assert str(caught.value).startswith("plan, line 3: ")
    assert words in str(caught.value)


@pytest.mark.parametrize(
    ("content", "words"),
    [
        (b"", "the layout has no bounds"),
        (b"wall 0 0 1 1", "the layout has no bounds"),
        (b"bounds 0 0 4 4\nsolid 0 0 4 0 4 4 0 4", "no free place to start: the solids cover 100%"),
        (b"bounds 0 0 10 10\nsolid 0 0 10 0 10 9.6 0 9.6", "the solids cover 96% of the area"),
        (b"bounds 0 0 0.01 0.01", "walls, and the 0.002 units to either side of them, fill"),
        (b"\xff\xfe\x00", "not UTF-8"),
    ],
)
def test_a_useless_file_is_named(tmp_path, content, words):
    path = tmp_path / "useless.layout"
    path.write_bytes(content)
    with pytest.raises(UserError, match=words) as caught:
        layout(path)
    assert str(caught.value).startswith(f"{path}: ")


def test_a_missing_file_and_a_folder_are_named(tmp_path):
    with pytest.raises(UserError, match="No such file or directory"):
        layout(tmp_path / "absent.layout")
    with pytest.raises(UserError, match="Is a directory"):
        layout(tmp_path)


@pytest.mark.parametrize(
    "lines",
    [
        "bounds 0 0 0.5 0.5",
        "bounds 0 0 10 10\nsolid 0 0 10 0 10 9.4 0 9.4",
        SQUARE + "solid 1 1 5 1 5 5 1 5\nsolid 5 1 9 1 9 5 5 5\nsolid 5 5 9 9 1 9",
        SQUARE + "wall 1 1 5 5 5 1 1 5\nwall 1 1 5 5\nwall 0 0 40 0",
        SQUARE + "solid 10 10 20 10 20 20 10 20\nwall 0 15 40 15",
    ],
    ids=["small", "nearly full", "touching solids", "crossing walls", "wall through a solid"],
)
def test_unusual_layouts_have_free_places(lines):
    world = parse_layout(lines).world()
    assert world.free(world.place(key=jax.random.key(0)))


def accepted(text):
    try:
        parse_layout(text)
    except UserError:
        return False
    return True


def test_solids_are_judged_as_by_an_exact_library():
    """Random polygons on a coarse grid, where corners and edges often touch."""
    rng = np.random.default_rng(5)
    judged = []
    for _ in range(400):
        solids = [rng.integers(4, 9, (num, 2)) for num in (rng.integers(3, 6), 3)]
        if any((corners == np.roll(corners, 1, axis=0)).all(axis=1).any() for corners in solids):
            continue
        one, other = map(shapely.Polygon, solids)
        # A valid polygon may still visit a point of its outline twice.
        fine = one.is_valid and other.is_valid and shapely.LinearRing(solids[0]).is_simple
        fine = fine and one.intersection(other).area < 1e-6
        lines = [f"solid {' '.join(map(str, corners.ravel()))}" for corners in solids]
        assert accepted(SQUARE + "\n".join(lines)) == fine, lines
        judged.append(fine)
    assert 40 < sum(judged) < len(judged) - 40


def test_a_layout_far_from_the_origin_is_moved_without_loss():
    near = parse_layout("bounds -20 -20 20 20\nwall 0 -20 0.25 0\nsolid 1 1 5 1 3 3")
    far = parse_layout(
        "bounds 450000 5400000 450040 5400040\nwall 450020 5400000 450020.25 5400020\n"
        "solid 450021 5400021 450025 5400021 450023 5400023"
    )
    assert near.origin == (0.0, 0.0)
    assert far.origin == (450020.0, 5400020.0)
    assert digest(far.world()) == digest(near.world())


def test_the_largest_layout_resolves_a_thousandth_of_a_unit():
    world = parse_layout("bounds 0 0 32768 32768").world()
    assert world.bounds == (-16384.0, -16384.0, 16384.0, 16384.0)
    # The last number before the bounds.
    assert 0 < 16384 - np.nextafter(np.float32(16384), np.float32(0)) < 1e-3


def test_a_layout_from_python_is_checked_too():
    outside = Layout(
        "Mine", (0.0, 0.0, 4.0, 4.0), (((1.0, 1.0), (2.0, 2.0)), ((0.0, 0.0), (5.0, 1.0)))
    )
    with pytest.raises(UserError, match=r"layout 'Mine', wall 2: the point \(5, 1\) is outside"):
        outside.world()


@pytest.mark.parametrize(
    ("name", "meant"),
    [
        ("paper", NamedWorld("layout", "paper")),
        (Path("paper"), NamedWorld("layout", "paper")),
        ("rooms:7", NamedWorld("rooms", 7)),
        ("rooms:4294967295", NamedWorld("rooms", 2**32 - 1)),
        ("lattice:6", NamedWorld("lattice", 6)),
        ("plans/home.layout", NamedWorld("layout", "plans/home.layout")),
    ],
)
def test_names_of_worlds(name, meant):
    assert parse_world_name(name) == meant


@pytest.mark.parametrize(
    ("name", "words"),
    [
        ("nowhere", "there is no layout 'nowhere'; choose one of corridors, "),
        ("papr", "there is no layout 'papr' (perhaps 'paper')"),
        ("rooms", "(perhaps 'rooms:SEED')"),
        ("rooms:", "(perhaps 'rooms:SEED')"),
        ("", "there is no layout ''"),
        ("a\0b", "there is no layout 'a\\x00b'"),
        ("x" * 5000, "there is no layout 'xxx"),
        ("rooms:x", "must be a whole number from 0 to 4294967295, not 'x'"),
        ("rooms:-1", "must be a whole number from 0 to 4294967295, not '-1'"),
        ("rooms:1.5", "must be a whole number from 0 to 4294967295, not '1.5'"),
        ("rooms:99999999999999999999", "must be a whole number from 0 to 4294967295"),
        ("rooms:" + "9" * 5000, "must be a whole number from 0 to 4294967295"),
        ("lattice:0", "the side of a lattice must be a whole number from 1 to 1000, not '0'"),
        ("lattice:-2", "the side of a lattice must be a whole number from 1 to 1000"),
        ("lattice:1001", "the side of a lattice must be a whole number from 1 to 1000"),
    ],
)
def test_names_of_no_world_are_refused(name, words):
    with pytest.raises(UserError) as caught:
        parse_world_name(name)
    assert words in str(caught.value)
    assert len(str(caught.value)) < 400


def test_a_lattice_is_no_layout():
    with pytest.raises(UserError, match="a lattice has no walls"):
        load_layout("lattice:6")


def test_reading_layouts_loads_nothing_heavy():
    """Whatever the package itself imports: a stand-in for it finds the module alone."""
    code = (
        "import sys, types; package = types.ModuleType('motorspace');"
        f"package.__path__ = {list(motorspace.__path__)}; sys.modules['motorspace'] = package;"
        "from motorspace.worlds.layouts import load_layout;"
        "load_layout('paper'), load_layout('rooms:7');"
        "sys.exit(', '.join({'jax', 'equinox', 'scipy'} & set(sys.modules)) or 0)"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
