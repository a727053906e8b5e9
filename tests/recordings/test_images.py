"""Images of a walk: what a camera sees, where it stands, and what is said where it cannot see."""

import math
import sys
from dataclasses import replace
from functools import cache
from importlib.util import find_spec

import jax
import numpy as np
import pytest

from motorspace import UserError
from motorspace.recordings import images
from motorspace.recordings.images import Camera, with_images
from motorspace.recordings.readers.base import read_log
from motorspace.recordings.record import record
from motorspace.recordings.windows import windows
from motorspace.recordings.written import write_table
from motorspace.reports.figures.images import images_figure
from motorspace.testing.reader import check_recording
from motorspace.worlds.agents import HolonomicAgent
from motorspace.worlds.layouts import parse_layout
from motorspace.worlds.scenario import Scenario
from motorspace.worlds.world import LatticeWorld

HALL = parse_layout("bounds 0 0 40 40")
SMALL = Camera(12, 16)


@cache
def lack():
    """Why no image can be drawn here; None where one can."""
    if find_spec("miniworld") is None:  # its import opens a window unless it is told not to
        return "the extra vision is not installed"
    try:
        with_images(standing((20.0, 20.0, 0.0)), HALL, SMALL)
    except UserError as error:
        return str(error)
    return None


@pytest.fixture
def drawn():
    """Skips where no image can be drawn."""
    if why := lack():
        pytest.skip(why)


def walked(num_steps=6, agent=None, layout="paper"):
    return record(Scenario(layout, agent), num_steps=num_steps, key=jax.random.key(1))


def standing(*places):
    """A recording with these poses (x, y, heading) and no movement that leads to them."""
    num = max(len(places), 2)
    poses = np.zeros((num, 4))
    poses[:, :3] = places if len(places) > 1 else places * 2
    return replace(walked(num - 1, layout=HALL), poses=poses, increments=np.zeros((num - 1, 2)))


def views(recording):
    return recording.sensors.reshape(-1, *recording.shape)


def greyness(view):
    """How little colour each pixel has; floor and ceiling are grey, walls are not."""
    return np.ptp(view, axis=-1) < 0.15


def test_a_walk_of_images_is_a_recording_that_can_be_learned_from(drawn):
    before = walked()
    after = with_images(before, "paper", SMALL)
    check_recording(after)
    assert after.shape == (12, 16, 3) and after.sensors.shape == (7, 12 * 16 * 3)
    assert -1 <= after.sensors.min() < 0 < after.sensors.max() <= 1
    assert set(after.sensor_scale) == {1.0} and not after.planar
    for name in ("time", "increments", "interval", "poses", "usable"):
        np.testing.assert_array_equal(getattr(after, name), getattr(before, name))
    pairs = windows(after, horizon=2, per_scan=True)
    assert pairs.experience.sensors.shape == (5, 576)


def test_the_same_walk_gives_the_same_images(drawn):
    walk = walked()
    first, other, again = (with_images(walk, "paper", c) for c in (SMALL, Camera(), SMALL))
    np.testing.assert_array_equal(first.sensors, again.sensors)
    assert other.shape == (24, 32, 3)
    assert len(np.unique(first.sensors, axis=0)) == 7, "each place looks different"


def test_a_full_turn_leads_back_to_the_same_image(drawn):
    turns = [(7.0, 20.0, 0.3 + index * math.pi / 2) for index in range(5)]
    seen = views(with_images(standing(*turns), "paper"))
    np.testing.assert_allclose(seen[0], seen[4], atol=2.1 / 255)
    assert np.abs(seen[0] - seen[2]).mean() > 0.1


def test_the_four_walls_of_a_hall_look_different(drawn):
    quarters = [(20.0, 20.0, index * math.pi / 2) for index in range(4)]
    seen = views(with_images(standing(*quarters), HALL))
    walls = seen[:, 11:13, 12:20].mean(axis=(1, 2))
    apart = np.linalg.norm(walls[:, None] - walls, axis=-1)[np.triu_indices(4, 1)]
    assert apart.min() > 0.3


def test_a_wall_to_the_left_is_on_the_left_and_the_floor_is_below(drawn):
    (seen, _) = views(with_images(standing((20.0, 39.0, 0.0)), HALL))
    grey = greyness(seen)
    assert not grey[:, :6].any(), "the wall at y = 40"
    assert grey[-4:, -6:].all() and grey[:4, -6:].all(), "floor and ceiling"
    assert seen[-1, -1].mean() < seen[0, -1].mean(), "the floor is darker"


def test_a_wall_is_seen_however_near_it_is(drawn):
    far, near = views(with_images(standing((38.0, 20.0, 0.0), (39.999, 20.0, 0.0)), HALL))
    assert not greyness(far).any() and not greyness(near).any()
    corner = with_images(standing((40 - 1e-3, 40 - 1e-3, math.pi / 4)), HALL)
    assert not greyness(views(corner)).any()


@pytest.mark.parametrize("angle", [1.0, 2.0])
def test_the_field_of_view_is_the_horizontal_one(drawn, angle):
    """A wall that begins just within half of it is seen, and one just beyond is not."""
    camera, found = Camera(field_of_view=angle), []
    for edge in (angle / 2 - 0.1, angle / 2 + 0.1):
        x, y = 20 + 3 * math.cos(edge), 20 + 3 * math.sin(edge)
        end = f"{x - 1.5 * math.sin(edge)} {y + 1.5 * math.cos(edge)}"
        screen = parse_layout(f"bounds 0 0 40 40\nwall {x} {y}  {end}")
        here = standing((20.0, 20.0, 0.0))
        seen, hall = (with_images(here, layout, camera).sensors for layout in (screen, HALL))
        found.append(bool((seen != hall).any()))
    assert found == [True, False]


def test_the_camera_looks_where_the_head_looks(drawn):
    walk = walked(3, HolonomicAgent())
    turned = walk.poses.copy()
    turned[:, 2], turned[:, 3] = turned[:, 2] + turned[:, 3], 0.0
    one, other = (with_images(w, "paper", SMALL) for w in (walk, replace(walk, poses=turned)))
    np.testing.assert_allclose(one.sensors, other.sensors, atol=2.1 / 255)


def test_layouts_far_from_the_origin_and_large_ones_are_drawn(drawn):
    text = "bounds {0} {0} {1} {1}"
    for low, high in ((5000, 5040), (0, 900)):
        layout = parse_layout(text.format(low, high))
        seen = with_images(walked(2, layout=layout), layout, Camera(eye_level=60.0))
        assert (~greyness(views(seen))).any(), "walls, and nothing of a sky"


def test_images_are_drawn_in_order_of_time(drawn):
    seen = with_images(walked(), "paper", SMALL)
    shown = [axes.images[0].get_array() for axes in images_figure(seen, num=3).axes]
    np.testing.assert_allclose(shown, (views(seen)[[0, 3, 6]] + 1) / 2, atol=1e-6)
    assert sum(len(axes.images) for axes in images_figure(seen).axes) == 7


def test_images_are_written_and_read_back(tmp_path, drawn):
    before = with_images(walked(), "paper", SMALL)
    write_table(before, tmp_path / "a.csv")
    after = read_log(tmp_path / "a.csv")
    assert after.shape == before.shape
    np.testing.assert_array_equal(after.sensors, before.sensors)


@pytest.mark.parametrize(
    ("options", "message"),
    [
        ({"height": 0}, "height must be at least 1"),
        ({"width": -3}, "width must be at least 1"),
        ({"field_of_view": math.pi}, "field_of_view must be above 0 and at most"),
        ({"field_of_view": 0.0}, "field_of_view must be above 0"),
        ({"eye_level": -1.0}, "eye_level must be above 0 and finite world units"),
    ],
)
def test_a_camera_that_cannot_be_is_one_sentence(options, message):
    with pytest.raises(UserError, match=message):
        Camera(**options)


@pytest.mark.parametrize("ending", [".csv", ".parquet"])
def test_the_shape_is_kept_in_tables(tmp_path, ending):
    if ending == ".parquet":
        pytest.importorskip("pyarrow")
    before = replace(walked(), shape=(3, 3, 1))
    for recording in (before, replace(before, shape=())):
        write_table(recording, tmp_path / f"a{ending}")
        assert read_log(tmp_path / f"a{ending}").shape == recording.shape


def test_a_shape_has_to_hold_all_channels():
    with pytest.raises(UserError, match=r"9 channels cannot be arranged as \(2, 3\)"):
        replace(walked(), shape=(2, 3))


@pytest.mark.parametrize(
    ("recording", "layout", "message"),
    [
        (lambda: standing((20.0, 20.0, 0.0)), LatticeWorld(3, 3), "LatticeWorld has no walls"),
        (lambda: standing((1.0, 1.0, 0.0), (99.0, 1.0, 0.0)), HALL, r"scan 1 is at \(99, 1\)"),
        (lambda: standing((1.0, 1.0, 0.0), (math.nan,) * 3), HALL, "pose of scan 1 is unknown"),
        (lambda: standing((1.0, 1.0, 0.0)), "nowhere", "there is no layout"),
    ],
)
def test_a_walk_that_cannot_be_seen_is_one_sentence(recording, layout, message):
    with pytest.raises(UserError, match=message):
        with_images(recording(), layout)


@pytest.mark.parametrize("module", ["pyglet", "miniworld.entity"])
def test_without_the_extra_it_is_named(monkeypatch, module):
    monkeypatch.setitem(sys.modules, module, None)
    with pytest.raises(UserError, match=r"need MiniWorld; pip install 'motorspace\[vision\]'"):
        with_images(walked(), "paper")


def test_without_anything_to_draw_with_the_packages_are_named(monkeypatch):
    def lacking(*_):
        raise ImportError('Library "GLU" not found.')

    monkeypatch.setattr(images, "_scene", lacking)
    monkeypatch.setitem(sys.modules, "pyglet", type(sys)("pyglet"))
    monkeypatch.setitem(sys.modules, "pyglet.gl", type(sys)("pyglet.gl"))
    with pytest.raises(UserError, match=r'Library "GLU" not found.*apt-get install libegl1'):
        with_images(walked(), "paper")


@pytest.mark.parametrize(
    ("shape", "num", "message"), [((), 3, "no images"), ((3, 3, 1), 0, "num must be at least 1")]
)
def test_a_figure_of_no_images_is_one_sentence(shape, num, message):
    with pytest.raises(UserError, match=message):
        images_figure(replace(walked(), shape=shape), num)


def test_grey_images_of_ones_own_are_drawn():
    assert len(images_figure(replace(walked(), shape=(3, 3, 1)), 2).axes) == 2
