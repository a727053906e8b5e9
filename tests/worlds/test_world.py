"""Places to stand and places to start."""

import jax
import jax.numpy as jnp
import numpy as np
import pytest
import shapely

from motorspace import LatticeWorld, Pose, layout_names
from motorspace.worlds.layouts import layout, load_layout


@pytest.mark.parametrize("name", layout_names())
def test_starts_are_free_and_outside_all_solids(name):
    world = layout(name)
    places = jax.vmap(lambda key: world.place(key=key))(jax.random.split(jax.random.key(0), 500))
    points = shapely.points(np.asarray(places.x, float), np.asarray(places.y, float))
    walls = shapely.union_all(shapely.linestrings(np.asarray(world.walls, float)))
    assert shapely.distance(walls, points).min() > 1e-3
    solids = shapely.union_all([shapely.Polygon(p) for p in load_layout(name).solids])
    assert not shapely.intersects(solids, points).any()
    assert shapely.box(*world.bounds).contains(points).all()
    assert (np.abs(places.heading) <= np.pi).all() and np.ptp(places.heading) > 6
    assert (places.head == 0).all()
    # Starts reach every quarter of the square.
    assert len(set(zip(np.asarray(places.x) > 20, np.asarray(places.y) > 20, strict=True))) == 4


def test_a_move_onto_a_wall_is_blocked_and_one_beside_it_is_not():
    world, zero = layout("empty"), jnp.zeros(())
    at = lambda x: Pose(jnp.float32(x), jnp.float32(20), zero, zero)  # noqa: E731
    assert world.blocked(at(39), at(40))
    assert world.blocked(at(39), at(41))
    assert not world.blocked(at(38), at(39))


def test_the_lattice_starts_on_its_nodes_and_ends_at_its_edge():
    world, zero = LatticeWorld(4, 2), jnp.zeros(())
    places = jax.vmap(lambda key: world.place(key=key))(jax.random.split(jax.random.key(0), 200))
    assert set(np.asarray(places.x).tolist()) == {0.0, 1.0, 2.0, 3.0}
    assert set(np.asarray(places.y).tolist()) == {0.0, 1.0}
    assert len(np.unique(np.asarray(places.heading))) == 4
    at = lambda x, y: Pose(jnp.float32(x), jnp.float32(y), zero, zero)  # noqa: E731
    assert world.blocked(at(3, 0), at(4, 0))
    assert world.blocked(at(0, 0), at(0, -1))
    assert not world.blocked(at(0, 0), at(0, 1))
