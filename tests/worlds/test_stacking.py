"""Worlds of different sizes as one: each answers as it does alone, bit for bit."""

import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np
import pytest

from motorspace import ForwardAgent, LatticeWorld, Pose, RangeFan
from motorspace._errors import UserError
from motorspace.worlds.exploration import explore
from motorspace.worlds.layouts import layout, parse_layout
from motorspace.worlds.stacking import stack_worlds

NUM, STEPS = 32, 4
WORLDS = (
    layout("empty"),
    layout("pillars"),
    # Bounds of its own, and far from the origin.
    parse_layout("bounds 5000 -90 5017 -80\nsolid 5003 -88 5006 -88 5005 -83").world(),
)
STACKED = stack_worlds(WORLDS)


def world_at(index):
    return jax.tree.map(lambda leaf: leaf[index], STACKED)


def same(one, other):
    jax.tree.map(np.testing.assert_array_equal, one, other)


def test_padding_makes_worlds_alike():
    num_walls, num_edges = max(len(w.walls) for w in WORLDS), max(len(w.solids) for w in WORLDS)
    assert STACKED.walls.shape == (len(WORLDS), num_walls, 2, 2)
    assert STACKED.solids.shape == (len(WORLDS), num_edges, 2, 2)
    assert np.isfinite(STACKED.walls).all()


@eqx.filter_jit
def sampled(world, key):
    """Random trajectories, and what is sensed where they end."""
    done = explore(
        world,
        ForwardAgent(),
        jnp.full(NUM, STEPS),
        horizon=STEPS,
        collision="resample",
        keys=jax.random.split(key, NUM),
    )
    return done, RangeFan().sense(world, done.pose)


@eqx.filter_jit
def answers(world, start, end):
    """Free places (walls and the insides of solids), forbidden moves, and distances."""
    return (
        world.free(start),
        world.blocked(start, end),
        RangeFan(max_range=100.0).sense(world, start),
    )


@pytest.fixture(scope="module")
def moves():
    """Starts and ends anywhere, in some worlds also out of bounds."""
    rng = np.random.default_rng(0)
    x, y = jnp.asarray(rng.uniform(-10, 45, (2, 2, 300)), jnp.float32)
    heading = jnp.asarray(rng.uniform(-np.pi, np.pi, 300), jnp.float32)
    return [Pose(x[i], y[i], heading, 0 * heading) for i in (0, 1)]


def test_stacked_worlds_answer_as_each_does_alone(moves):
    together = jax.vmap(answers, in_axes=(0, None, None))(STACKED, *moves)
    for index, world in enumerate(WORLDS):
        alone = answers(world, *moves)
        same(alone, jax.tree.map(lambda leaf: leaf[index], together))  # noqa: B023
        same(alone, answers(world_at(index), *moves))
    assert 0 < np.mean(together[0]) < 1 and 0 < np.mean(together[1]) < 1


@pytest.mark.slow
def test_trajectories_sampled_in_all_worlds_at_once_are_those_of_each(getkey):
    keys = jax.random.split(getkey(), len(WORLDS))
    together = jax.vmap(sampled)(STACKED, keys)
    for index, (world, key) in enumerate(zip(WORLDS, keys, strict=True)):
        same(sampled(world, key), jax.tree.map(lambda leaf: leaf[index], together))  # noqa: B023


@pytest.mark.parametrize("worlds", [(), (WORLDS[0], LatticeWorld())])
def test_only_walled_worlds_can_be_stacked(worlds):
    with pytest.raises(UserError, match="only walled worlds can be stacked"):
        stack_worlds(worlds)
