"""Maps as layouts: occupancy grids and outlines, good ones and broken ones."""

import json
import math

import jax
import numpy as np
import pytest
import shapely

from motorspace import UserError
from motorspace.cli.main import main
from motorspace.worlds.layouts import layout, layout_content, load_layout, parse_layout
from motorspace.worlds.maps.map_server import write_map
from motorspace.worlds.maps.occupancy import outside
from motorspace.worlds.maps.reading import kind_of_map
from motorspace.worlds.maps.simplified import simplified

PLAN = """\
##########
#........#
#..##....#
#..##....#
#........#
#######..#
#........#
##########
"""

YAML = """\
image: plan.{ending}
resolution: 0.5   # metres
origin: [{x}, -1, {yaw}]
negate: {negate}
occupied_thresh: 0.65
free_thresh: 0.196
"""


def cells(plan=PLAN, pixels=None):
    """A plan as grey pixels, the first row at the top."""
    shades = {"#": 0, ".": 254, "?": 205} | (pixels or {})
    rows = plan.strip().splitlines()
    return np.array([[shades[sign] for sign in row] for row in rows], np.uint8)


def write(folder, pixels, ending="pgm", text=YAML, **keys):
    """A map_server map, and the path of its YAML file."""
    from PIL import Image

    Image.fromarray(pixels).save(folder / f"plan.{ending}")
    filled = text.format(**{"ending": ending, "x": 2, "yaw": 0, "negate": 0} | keys)
    path = folder / "plan.yaml"
    path.write_text(filled)
    return path


def free_area(described):
    """What is not solid, exactly."""
    low_x, low_y, high_x, high_y = described.bounds
    solids = [shapely.Polygon(corners) for corners in described.solids]
    assert all(solid.is_valid for solid in solids)
    return shapely.box(low_x, low_y, high_x, high_y).difference(shapely.union_all(solids))


def corners_cut(num, resolution=0.5):
    """The area that is lost where boundaries cut the corners of cells."""
    return num * resolution**2 / 8


@pytest.mark.parametrize("ending", ["pgm", "png"])
def test_an_occupancy_grid(tmp_path, ending):
    path = write(tmp_path, cells(), ending)
    described = load_layout(path)
    area = free_area(described)
    assert area.area == pytest.approx(0.25 * (6 * 8 - 4 - 6), abs=corners_cut(16))
    assert area.contains(shapely.Point(2 + 0.75, -1 + 0.75))
    assert not area.contains(shapely.Point(2 + 2.0, -1 + 2.5)), "the pillar"
    assert not area.contains(shapely.Point(2 + 1.0, -1 + 1.25)), "the wall between the rooms"
    assert len(described.segments()[0]) < 50
    assert parse_layout(layout_content(path)) == described
    world = layout(path)
    for seed in range(8):
        pose = world.place(key=jax.random.key(seed))
        assert area.contains(shapely.Point(float(pose.x), float(pose.y)))


def test_a_yaw_in_the_origin_turns_the_map(tmp_path):
    plain = free_area(load_layout(write(tmp_path, cells())))
    for yaw in (3.14159265, 0.5):
        turned = free_area(load_layout(write(tmp_path, cells(), yaw=yaw)))
        expected = shapely.affinity.rotate(plain, yaw, origin=(2, -1), use_radians=True)
        assert turned.symmetric_difference(expected).area < 0.01


def test_negate_modes_and_thresholds(tmp_path):
    plain = free_area(load_layout(write(tmp_path, cells())))
    for name, pixels, extra in (
        ("negated", 255 - cells(), {"negate": 1}),
        ("raw", cells(pixels={"#": 100, ".": 0}), {"text": YAML + "mode: raw\n"}),
        ("scale", cells(pixels={".": 200}), {"text": YAML + "mode: scale\n"}),
        ("colours", np.repeat(cells()[..., None], 3, axis=2), {"ending": "png"}),
    ):
        same = free_area(load_layout(write(tmp_path, pixels, **extra)))
        assert same.equals(plain), name
    listed = YAML.replace("[{x}, -1, {yaw}]", "\n- {x}\n- -1.0\n- {yaw}")
    assert free_area(load_layout(write(tmp_path, cells(), text=listed))).equals(plain)


def test_unknown_cells_are_no_place_to_stand_but_pinholes_are(tmp_path):
    plain = load_layout(write(tmp_path, cells()))
    unknown = PLAN.replace("#######..#\n#........#", "#######..#\n#......???").replace(
        "#........#\n#..##", "#...?....#\n#..##", 1
    )
    found = load_layout(write(tmp_path, cells(unknown)))
    seen = [free_area(m).contains(shapely.Point(2 + 3.75, -1 + 0.75)) for m in (plain, found)]
    assert seen == [True, False]
    pinhole = PLAN.replace("##....#", "##.?..#", 1)
    assert load_layout(write(tmp_path, cells(pinhole))).solids == plain.solids
    # ROS 2 writes unknown cells as 205, and a threshold by which they are free.
    loose = YAML.replace("0.196", "0.25")
    assert load_layout(write(tmp_path, cells(unknown), text=loose)).solids == found.solids


def test_what_cannot_be_reached_is_left_out(tmp_path):
    closed = PLAN.replace("#######..#", "##########")
    described = load_layout(write(tmp_path, cells(closed)))
    assert not free_area(described).contains(shapely.Point(2 + 0.75, -1 + 0.75))


def test_noise_becomes_valid_solids_near_their_cells(tmp_path):
    random = np.random.default_rng(0)
    pixels = np.where(random.random((60, 80)) < 0.2, 0, 254).astype(np.uint8)
    pixels[random.random((60, 80)) < 0.1] = 205
    described = load_layout(write(tmp_path, pixels))
    area = free_area(described)
    assert area.geom_type == "Polygon"
    described.world()


def test_simplified_lines_keep_to_their_tolerance_and_do_not_meet():
    angles = np.linspace(0, 2 * np.pi, 400, endpoint=False)
    rings = [r * np.stack([np.cos(angles), np.sin(angles)], axis=1) for r in (10.0, 10.3, 10.6)]
    few = simplified(rings, 0.5)
    assert all(len(ring) <= 400 for ring in few)
    lines = [shapely.LinearRing(ring) for ring in few]
    assert not any(a.intersects(b) for a in lines for b in lines if a is not b)
    for ring, line in zip(rings, lines, strict=True):
        assert max(line.distance(shapely.Point(p)) for p in ring) <= 0.5 + 1e-9


def test_what_is_around_an_outline_is_two_solids():
    above, below = outside(((1.0, 1.0), (3.0, 1.0), (3.0, 2.0), (1.0, 2.0)), (0.0, 0.0, 4.0, 3.0))
    both = shapely.union_all([shapely.Polygon(above), shapely.Polygon(below)])
    assert both.area == 12 - 2


BROKEN = {
    "a missing image": (YAML.replace("plan.", "other."), "the map's image is missing"),
    "no resolution": (YAML.replace("resolution", "scale"), "the map lacks resolution"),
    "no key": (YAML + "nonsense\n", "line 7: the line 'nonsense' is no `key: value`"),
    "a word": (YAML.replace("0.5 ", "half "), "line 2: resolution is 'half'"),
    "no size": (YAML.replace("0.5 ", "0 "), "resolution is '0'; give a number from"),
    "two numbers": (YAML.replace(", {yaw}", ""), "line 3: origin is '[2, -1]'"),
    "an origin of words": (YAML.replace("{yaw}", "north"), "line 3: origin is 'north'"),
    "a mode": (YAML + "mode: fuzzy\n", "line 7: mode is 'fuzzy'"),
    "thresholds": (YAML.replace("0.65", "0.1"), "free_thresh 0.196 is above"),
    "twice": (YAML + "negate: 1\n", "line 7: a second negate"),
    "nothing free": (YAML.replace("0.196", "0"), "no cell of the map is free"),
    "no image": (YAML.replace("plan.{ending}", ""), "image names no file"),
}


@pytest.mark.parametrize("case", BROKEN)
def test_broken_descriptions_are_one_sentence(tmp_path, case):
    text, message = BROKEN[case]
    with pytest.raises(UserError) as error:
        load_layout(write(tmp_path, cells(), text=text))
    assert message in str(error.value) and str(tmp_path) in str(error.value)


def test_broken_images(tmp_path):
    path = write(tmp_path, cells())
    image = tmp_path / "plan.pgm"
    whole = image.read_bytes()
    for content in (whole[:-20], b"", b"\0" * 100, whole.replace(b"10 8", b"99999 99999")):
        image.write_bytes(content)
        with pytest.raises(UserError, match=r"plan\.pgm: the (map's )?image"):
            load_layout(path)
    with pytest.raises(UserError, match="an image alone does not say how large"):
        load_layout(_copied(whole, tmp_path / "alone.pgm"))


def _copied(content, path):
    path.write_bytes(content)
    return path


GRID = "type octile\nheight 8\nwidth 10\nmap\n" + PLAN.replace("#", "@")


def test_a_map_of_moving_ai(tmp_path):
    path = tmp_path / "den.map"
    path.write_text(GRID.replace("@@@@@@@..@", "TTTTTTT.G@"))
    assert kind_of_map(path) == "moving_ai"
    described = load_layout(path)
    assert free_area(described).area == pytest.approx(38, abs=corners_cut(16, 1.0))
    for text, message in (
        (GRID.replace("height 8", "height 9"), "has 8 rows, and its head says 9"),
        (GRID.replace("@........@\n", "@.......@\n", 1), "line 6: the row has 9 cells, not 10"),
        (GRID.replace("..@@", "..x@", 1), "line 7: the row has the sign 'x'"),
        ("type octile\nheight 8\n", "the map has no head"),
    ):
        path.write_text(text)
        with pytest.raises(UserError, match=message):
            load_layout(path)


def feature(shape, coordinates, **properties):
    geometry = {"type": shape, "coordinates": coordinates}
    return {"type": "Feature", "properties": properties, "geometry": geometry}


SQUARE = [[0, 0], [8, 0], [8, 6], [0, 6], [0, 0]]


def test_outlines_in_geojson(tmp_path):
    path = tmp_path / "plan.geojson"
    features = [
        feature("Polygon", [SQUARE], kind="outline"),
        feature("Polygon", [[[2, 2], [3, 2], [3, 3], [2, 3], [2, 2]]], kind="solid"),
        feature("MultiLineString", [[[4, 0], [4, 4]], [[6, 2, 1], [6, 6, 1]]]),
        feature("Point", [1, 1]),
    ]
    path.write_text(json.dumps({"type": "FeatureCollection", "features": features}))
    described = load_layout(path)
    assert free_area(described).area == pytest.approx(48 - 1)
    assert described.walls == (((4, 0), (4, 4)), ((6, 2), (6, 6)))
    described.world()
    for content, message in (
        ("{", "the file is no JSON"),
        (json.dumps(feature("LineString", [[0, 0], [8, "x"]])), r"a point is \[8, 'x'\]"),
        (json.dumps(feature("LineString", [[0, 0], [1e999, 1]])), "a coordinate is not finite"),
        (json.dumps(feature("LineString", SQUARE, kind="river")), "the kind 'river'"),
        (json.dumps(feature("Polygon", SQUARE)), "a list is missing"),
        (json.dumps(feature("LineString", [[8.5, 47.1], [8.6, 47.2]])), "project degrees"),
        ('{"type": "FeatureCollection", "features": []}', "the drawing has no lines"),
        ('{"features": ' + "[" * 5000, "the file is no JSON"),
    ):
        path.write_text(content)
        with pytest.raises(UserError, match=message):
            load_layout(path)


SVG = """<?xml version="1.0"?>
<!-- a plan -->
<svg xmlns="http-less" viewBox="0 0 20 10">
 <title>Plan</title>
 <g transform="translate(1 1) scale(2)">
  <rect class="outline" x="0" y="0" width="8" height="4"/>
  <path d="M2,0 v2 h1 M 5 4 L5 3 6,3 z m2-1l.5-.5"/>
 </g>
 <polygon class="solid" points="3,7 5,7 5,8 3,8"/>
 <line x1="13" y1="1" x2="13" y2="3"/>
 <polyline points="15 2 16 2 16 3" transform="rotate(90 15 2)"/>
 <text>hall</text>
</svg>
"""


def test_outlines_in_svg(tmp_path):
    path = tmp_path / "plan.svg"
    path.write_text(SVG)
    assert kind_of_map(path) == "svg"
    described = load_layout(path)
    assert free_area(described).area == pytest.approx(16 * 8 - 2)
    first, second, third, line, turned = described.walls
    assert first == ((5, 8), (5, 4), (7, 4)), "y points up"
    assert second[0] == second[-1] == (11, 0) and len(second) == 4
    assert third == ((15, 2), (16, 3))
    assert line == ((13, 8), (13, 6))
    np.testing.assert_allclose(turned, [(15, 7), (15, 6), (14, 6)], atol=1e-9)
    described.world()


BOMB = '<!DOCTYPE svg [<!ENTITY a "aaaa">]><svg><title>&a;</title></svg>'


@pytest.mark.parametrize(
    ("text", "message"),
    [
        (BOMB, "line 1: the drawing declares an entity"),
        (SVG.replace("</g>", ""), "line 13: the drawing is no XML"),
        (SVG.replace("v2 h1", "c1 1 2 2 3 3"), "turn curves into straight lines"),
        (SVG.replace("v2 h1", "1 v"), "the path"),
        (SVG.replace('"0" width', '"x" width'), "'x' cannot be read; write plain numbers"),
        (SVG.replace("8,", "8"), "3,7 5,7"),
        (SVG.replace("3,8", "3"), "a point lacks its y"),
        (SVG.replace("scale(2)", "skewX(2)"), r"the transform .* is not known"),
        (SVG.replace("scale(2)", "scale()"), "the transform scale has 0 numbers"),
        (SVG.replace("scale(2)", "scale(1e308)"), "a coordinate is not finite"),
        ("<svg>" + "<g>" * 400, "groups nest too deep"),
        ("<svg></svg>", "the drawing has no lines"),
    ],
)
def test_broken_drawings_are_one_sentence(tmp_path, text, message):
    path = tmp_path / "plan.svg"
    path.write_text(text)
    if text == SVG.replace("8,", "8"):
        return
    with pytest.raises(UserError, match=message):
        load_layout(path)


def test_the_commands_describe_and_write_maps(tmp_path, capsys):
    path = write(tmp_path, cells())
    main(["inspect", str(path), "--out", str(tmp_path / "seen")])
    assert "1 obstacles inside the region" in capsys.readouterr().out
    assert (tmp_path / "seen" / "map.png").read_bytes().startswith(b"\x89PNG")
    main(["import", str(path), "--out", str(tmp_path / "plan.layout")])
    assert load_layout(tmp_path / "plan.layout") == load_layout(path)
    with pytest.raises(SystemExit):
        main(["import", str(path), "--out", str(tmp_path / "plan.csv")])
    assert "a map becomes a layout" in capsys.readouterr().err
    assert math.isfinite(load_layout(path).bounds[0])


def test_a_written_grid_is_read_back(tmp_path):
    plan = PLAN.replace("..##", "..?#")
    shades = cells(plan)[::-1]
    corner = (-3.0, 1 / 3)
    write_map(tmp_path / "a.yaml", shades == 254, shades == 0, resolution=0.5, corner=corner)
    pixels = (tmp_path / "a.pgm").read_bytes()
    assert pixels.startswith(b"P5\n10 8\n255\n") and pixels.endswith(cells(plan).tobytes())
    found = load_layout(tmp_path / "a.yaml")
    same = write(tmp_path, cells(plan), x=corner[0])
    same.write_text(same.read_text().replace("-1, 0]", f"{corner[1]!r}, 0]"))
    assert found.bounds == load_layout(same).bounds and found.solids == load_layout(same).solids
    assert found.bounds[0] == pytest.approx(-2.5 - 0.5, abs=0.51)


def test_an_empty_grid_is_written_and_refused_as_a_world(tmp_path):
    nothing = np.zeros((3, 4), bool)
    write_map(tmp_path / "a.yaml", nothing, nothing, resolution=0.1, corner=(0.0, 0.0))
    with pytest.raises(UserError, match=r"a\.yaml: .*free"):
        load_layout(tmp_path / "a.yaml")
    with pytest.raises(UserError, match="cannot be written"):
        write_map(tmp_path / "no/a.yaml", nothing, nothing, resolution=0.1, corner=(0.0, 0.0))
