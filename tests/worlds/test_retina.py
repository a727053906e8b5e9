"""Paint and eyes: colours against an independent solution in double precision."""

import jax
import jax.numpy as jnp
import numpy as np
import pytest
import shapely

from motorspace import Pose, Retina, Scenario, UserError, WalledWorld, sample
from motorspace.testing import check_sensor
from motorspace.worlds.catalog import SENSORS
from motorspace.worlds.layouts import layout, load_layout, painted, parse_layout
from motorspace.worlds.paint import TEXELS, Paint, parse_paint
from motorspace.worlds.rays import fan_directions, first_met
from motorspace.worlds.stacking import deal_worlds, stack_worlds
from motorspace.worlds.tiles import GROUP, tiled


def poses(num, size, seed=0):
    rng = np.random.default_rng(seed)
    x, y = jnp.asarray(rng.uniform(1, size - 1, (2, num)), jnp.float32)
    heading = jnp.asarray(rng.uniform(-np.pi, np.pi, num), jnp.float32)
    return Pose(x, y, heading, 0 * x)


def at(batch, index):
    return jax.tree.map(lambda leaf: leaf[index], batch)


def seen_by_shapely(paint, walls, origin, angle):
    """The number of the wall that a ray meets first, the place on it, and its colour; float64."""
    end = origin + 1000.0 * np.array([np.cos(angle), np.sin(angle)])
    met = shapely.intersection(shapely.linestrings([origin, end]), shapely.linestrings(walls))
    distances = np.where(
        shapely.is_empty(met), np.inf, shapely.distance(met, shapely.Point(origin))
    )
    number = int(np.argmin(distances))
    along = distances[number] * (end - origin) / 1000.0 + origin - walls[number, 0]
    place = np.linalg.norm(along)
    colours = paint._colours(number, walls[number])
    spaced = np.arange(len(colours)) * paint.wavelength / TEXELS
    return number, place, [np.interp(place, spaced, channel) for channel in colours.T]


@pytest.mark.parametrize("word", ["flat", "texture:2", "texture:8:0.5:3"])
@pytest.mark.parametrize("name", ["paper", "pillars", "rooms:3"])
def test_rays_meet_the_wall_the_place_and_the_colour(name, word):
    world, paint, here = layout(name, paint=word), parse_paint(word), poses(12, 40.0)
    retina = Retina(9, 2.0, samples=1)
    readings = np.asarray(retina.sense(world, here)).reshape(9, 3, -1)
    met = first_met(world.walls, None, (here.x, here.y), fan_directions(retina.angles, here.gaze))
    walls = np.asarray(load_layout(name).segments()[0], np.float64)
    for agent in range(12):
        pose = at(here, agent)
        for ray, angle in enumerate(retina.angles + float(pose.gaze)):
            origin = np.array([float(pose.x), float(pose.y)])
            number, _, colour = seen_by_shapely(paint, walls, origin, angle)
            assert int(met.wall[ray, agent]) == number
            np.testing.assert_allclose((readings[ray, :, agent] + 1) / 2, colour, atol=2e-3)


def test_a_pixel_averages_the_colours_of_its_rays():
    world, here = layout("paper", paint="texture:1"), poses(5, 40.0)
    coarse = Retina(8, np.pi, samples=4).sense(world, here).reshape(8, 3, 5)
    fine = Retina(32, np.pi, samples=1).sense(world, here).reshape(8, 4, 3, 5)
    np.testing.assert_allclose(coarse, fine.mean(axis=1), atol=1e-5)
    assert np.abs(coarse - fine[:, 0]).max() > 0.1


def test_many_walls_are_looked_up_as_if_all_were_visited():
    """Near ones in the index, and those that no indexed wall hides however far they are."""
    rng = np.random.default_rng(4)
    start = rng.uniform(0, 60, (300, 2))
    inner = np.stack([start, start + rng.normal(0, 0.4, start.shape)], axis=1)
    corners = np.array([[0, 0], [60, 0], [60, 60], [0, 60]], float)
    walls = np.concatenate([inner, np.stack([corners, np.roll(corners, -1, axis=0)], axis=1)])
    bounds = (0.0, 0.0, 60.0, 60.0)
    coat = Paint("texture", 3.0).coat(walls)
    plain = WalledWorld(walls, np.zeros((0, 2, 2)), bounds, None, coat)
    indexed = WalledWorld(walls, np.zeros((0, 2, 2)), bounds, tiled(walls, bounds), coat)
    here, retina = poses(2 * GROUP + 7, 60.0), Retina(16, 2 * np.pi)
    found = retina.sense(indexed, here)
    np.testing.assert_allclose(found, retina.sense(plain, here), atol=1e-4)
    rays = fan_directions(retina.angles, here.gaze)
    met = first_met(indexed.walls, indexed.tiles, (here.x, here.y), rays)
    assert 1 / float(met.nearness.min()) > 20 and 1 / float(met.nearness.max()) < 2


@pytest.mark.parametrize("few", [True, False])
def test_a_ray_that_meets_nothing_says_so(few, monkeypatch):
    monkeypatch.setattr("motorspace.worlds.rays.PACKED_BELOW", 128 if few else 0)
    wall, here = jnp.array([[[2.0, -1.0], [2.0, 1.0]]]), (jnp.float32(0), jnp.float32(0))
    met = first_met(wall, None, here, fan_directions(np.array([0.0, np.pi]), jnp.float32(0)))
    np.testing.assert_allclose(met.nearness, [0.5, 0.0], rtol=1e-5)
    np.testing.assert_array_equal(met.wall, [0, -1])


def test_distance_leaves_no_trace():
    """A flat wall looks the same from near and from far."""
    world, retina = layout("empty"), Retina(4, 0.4)
    near, far = (retina.sense(world, Pose(*jnp.array([x, 20.0, 0.0, 0.0]))) for x in (38.0, 20.0))
    np.testing.assert_array_equal(near, far)
    behind = retina.sense(world, Pose(*jnp.array([20.0, 20.0, np.pi, 0.0])))
    assert np.abs(near - behind).max() > 0.05


@pytest.mark.parametrize("light", ["trajectory", "view"])
def test_light_scales_views(light):
    key = jax.random.key(3)
    plain, lit = (
        sample(
            Scenario("paper", sensor=Retina(6, samples=1, light=kind)), num=64, horizon=2, key=key
        )
        for kind in ("constant", light)
    )
    np.testing.assert_array_equal(plain.experience.motors, lit.experience.motors)
    factors = [
        (np.asarray(getattr(lit.experience, view)) + 1)
        / (np.asarray(getattr(plain.experience, view)) + 1)
        for view in ("sensors", "later_sensors")
    ]
    for factor in factors:
        np.testing.assert_allclose(factor, factor[:, :1] * np.ones(18), rtol=1e-4)
        assert 0.39 < factor.min() < 0.5 and 0.9 < factor.max() <= 1.001
    same = np.allclose(factors[0][:, 0], factors[1][:, 0], rtol=1e-4)
    assert same == (light == "trajectory")


def test_stacked_and_dealt_worlds_keep_their_colours():
    worlds = [layout("empty"), layout("pillars", paint="texture:4"), layout("rooms:2")]
    here, retina = poses(6, 40.0), Retina(7, samples=2)
    alone = [retina.sense(worlds[n % 3], at(here, n)) for n in range(6)]
    dealt = retina.sense(deal_worlds(worlds, 6), here)
    np.testing.assert_allclose(dealt, np.stack(alone, axis=-1), atol=1e-5)
    stacked = stack_worlds(worlds)
    first = jax.vmap(lambda world, pose: retina.sense(world, pose))(stacked, at(here, slice(3)))
    np.testing.assert_allclose(first, np.stack(alone[:3]), atol=1e-5)


def test_a_texture_has_the_wavelength_that_it_says():
    paint = Paint("texture", 4.0)
    signal = paint._colours(0, np.array([[0.0, 0.0], [4000.0, 0.0]]))
    power = np.abs(np.fft.rfft(signal - signal.mean(axis=0), axis=0)) ** 2
    wavelengths = 1 / np.fft.rfftfreq(len(signal), 4.0 / TEXELS).clip(1e-9)
    within = (wavelengths > 3.9) & (wavelengths < 8.2)
    assert power[within].sum() / power.sum() > 0.97
    assert signal.min() >= 0 and signal.max() <= 1


def test_colours_are_a_matter_of_the_seed():
    one, same, other = (layout("paper", paint=word).coat for word in ("flat:1", "flat:1", "flat:2"))
    np.testing.assert_array_equal(one.texels, same.texels)
    assert np.abs(one.texels - other.texels).max() > 0.3
    assert len(np.unique(np.asarray(one.texels), axis=0)) == len(one.texels)


def test_share_lies_between_flat_and_textured():
    wall = np.array([[0.0, 0.0], [9.0, 0.0]])
    flat, half, full = (
        Paint(kind, 2.0, share)._colours(5, wall)
        for kind, share in (("flat", 1.0), ("texture", 0.5), ("texture", 1.0))
    )
    np.testing.assert_allclose(half, (flat + full) / 2)


def test_a_layout_file_says_its_paint():
    text = "title A room\nbounds 0 0 8 8\npaint texture:4:0.5:7\n"
    read = parse_layout(text)
    assert read.paint == Paint("texture", 4.0, 0.5, 7)
    assert parse_layout(read.text()) == read
    assert "paint" not in load_layout("paper").text()
    assert painted(read, "flat:3").paint == Paint(seed=3)
    assert painted(read, None) is read


@pytest.mark.parametrize(
    "word",
    ["", "flat:x", "flat:-1", "texture", "texture:0", "texture:4:2", "texture:4:1:1:1", "red"],
)
def test_no_paint_is_said_by_other_words(word):
    with pytest.raises(UserError):
        parse_paint(word, where="room.layout, line 3")
    with pytest.raises(UserError, match="line 2"):
        parse_layout(f"bounds 0 0 8 8\npaint {word}\n", where="room.layout")


@pytest.mark.parametrize(
    ("options", "message"),
    [
        ({"num_rays": 0}, "num_rays"),
        ({"samples": 0}, "samples"),
        ({"field_of_view": 7.0}, "field_of_view"),
    ],
)
def test_a_retina_refuses_what_it_cannot_be(options, message):
    with pytest.raises(UserError, match=message):
        Retina(**options)
    with pytest.raises(UserError, match="light"):
        SENSORS.part("retina", {"light": "dim"})


def test_walls_without_paint_are_not_seen():
    bare = WalledWorld(np.eye(2)[None], np.zeros((0, 2, 2)), (0.0, 0.0, 2.0, 2.0))
    with pytest.raises(UserError, match="paint"):
        Retina().space(bare)


def test_a_retina_is_a_sensor():
    check_sensor(Retina(5, samples=2), "paper")
    space = Retina(5).space(layout("paper"))
    assert space.shape == (5, 3) and space.names[:4] == ("r_0", "g_0", "b_0", "r_1")
    rays = Retina(3, np.pi).rays(layout("empty"), Pose(*jnp.array([30.0, 20.0, 0.0, 0.0])))
    np.testing.assert_allclose(rays[1], [[30, 20], [40, 20]], atol=1e-4)
