"""No executed move crosses a wall in exact arithmetic, whatever is commanded."""

import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np
import pytest
import shapely
from hypothesis import given, settings
from hypothesis import strategies as st

from motorspace import (
    ForwardAgent,
    HolonomicAgent,
    LatticeAgent,
    LatticeWorld,
    Pose,
    WalledWorld,
    layout_names,
    rollout,
)
from motorspace.worlds.exploration import MAX_REFUSALS, explore
from motorspace.worlds.layouts import Layout, layout
from motorspace.worlds.simulation import nominal_displacement, step

NUM, STEPS = 128, 24
AGENTS = {"forward": ForwardAgent(), "holonomic": HolonomicAgent()}
PAPER = layout("paper")
CORNERS = np.unique(np.asarray(PAPER.walls, float).reshape(-1, 2), axis=0)
STEP = eqx.filter_jit(step)
FREE = eqx.filter_jit(WalledWorld.free)


def padded(world):
    """The same world with repeated walls, so that all layouts share one compiled program."""
    walls = jnp.concatenate([world.walls, jnp.repeat(world.walls[:1], 64 - len(world.walls), 0)])
    edges = jnp.concatenate([world.solids, jnp.zeros((64 - len(world.solids), 2, 2))])
    return WalledWorld(walls, edges, world.bounds)


def obstacles(world):
    """The walls of a world as one exact geometry."""
    return shapely.union_all(shapely.linestrings(np.asarray(world.walls, np.float64)))


PAPER_WALLS = obstacles(PAPER)


def paths(before, after, headings, motors):
    """The path of each executed command in float64: legs recomputed from the logged poses."""
    before, after, motors = (np.asarray(v, np.float64) for v in (before, after, motors))
    heading = np.asarray(headings, np.float64)
    if motors.shape[-1] == 2:
        return shapely.linestrings(np.stack([before, after], axis=-2))
    ahead = np.stack([np.cos(heading), np.sin(heading)], axis=-1)
    middle = before + motors[..., 1:2] * ahead
    return shapely.linestrings(np.stack([before, middle, after], axis=-2))


@eqx.filter_jit
def explorations(world, agent, collision, keys):
    """Poses along many explorations, fields of shape [N, T + 1], and the explorations."""
    done = explore(
        world, agent, jnp.full(len(keys), STEPS), horizon=STEPS, collision=collision, keys=keys
    )
    poses = rollout(world, agent, done.start, done.motors)
    return jax.tree.map(jnp.transpose, poses), done


@pytest.mark.parametrize("name", [*layout_names(), "rooms:1", "rooms:2"])
@pytest.mark.parametrize("agent", AGENTS.values(), ids=AGENTS)
def test_no_executed_move_crosses_a_wall(name, agent):
    world = padded(layout(name))
    keys = jax.random.split(jax.random.key(5), NUM)
    poses, done = explorations(world, agent, "block", keys)
    places = np.stack([poses.x, poses.y], axis=-1)
    before, after = places[:, :-1], places[:, 1:]
    moved = (before != after).any(-1)
    commands = np.moveaxis(np.asarray(done.motors), -1, 0)
    legs = paths(before[moved], after[moved], poses.heading[:, 1:][moved], commands[moved])
    walls = obstacles(world)
    shapely.prepare(walls)
    assert not shapely.intersects(walls, legs).any()
    assert 0.6 < moved.mean() < 1.0, "some commands are blocked, most are not"
    turned = np.asarray(poses.heading)[:, 1:] != np.asarray(poses.heading)[:, :-1]
    assert turned[~moved].all(), "a blocked command still turns the agent"


@pytest.mark.parametrize("agent", AGENTS.values(), ids=AGENTS)
def test_resampled_commands_are_all_executed(agent):
    keys = jax.random.split(jax.random.key(6), NUM)
    poses, done = explorations(PAPER, agent, "resample", keys)
    np.testing.assert_array_equal(done.steps_done, STEPS)
    assert (np.asarray(done.proposals) > STEPS).any(), "some commands were refused"
    np.testing.assert_allclose(poses.x[:, -1], done.pose.x, atol=1e-4)
    np.testing.assert_allclose(poses.y[:, -1], done.pose.y, atol=1e-4)


@pytest.mark.parametrize("agent", AGENTS.values(), ids=AGENTS)
def test_stages_change_nothing_but_the_time(agent, monkeypatch):
    """Whoever keeps step with whom: the same trajectories, stuck agents included."""
    keys = jax.random.split(jax.random.key(7), NUM)
    crowded = layout("pillars")
    explore_all = lambda: eqx.filter_jit(explore)(  # noqa: E731
        crowded, agent, jnp.arange(NUM) % 6 + 1, horizon=6, collision="resample", keys=keys
    )
    staged = explore_all()
    monkeypatch.setattr("motorspace.worlds.exploration.STAGES", ((2, 1),))
    eqx.clear_caches()
    plain = explore_all()
    for one, other in zip(jax.tree.leaves(staged), jax.tree.leaves(plain), strict=True):
        np.testing.assert_allclose(one, other, atol=1e-5)


def test_a_stuck_agent_begins_anew_elsewhere():
    """In cells so narrow that most places are dead ends."""
    walls = tuple(((x, 0.0), (x, 2.0)) for x in np.arange(1, 40) / 20)
    cells = Layout("cells", (0.0, 0.0, 2.0, 2.0), walls).world()
    keys, three = jax.random.split(jax.random.key(8), 64), jnp.full(64, 3)
    agent = ForwardAgent(0.01)
    done = explore(cells, agent, three, horizon=3, collision="resample", keys=keys)
    np.testing.assert_array_equal(done.steps_done, 3)
    assert int(done.attempt.max()) > 0 and int(done.refusals.max()) < MAX_REFUSALS
    end = rollout(cells, agent, done.start, done.motors)
    np.testing.assert_allclose(end.x[-1], done.pose.x, atol=1e-5)
    np.testing.assert_array_equal(end.x[0] // 0.05, end.x[-1] // 0.05)


@settings(max_examples=300, deadline=None)
@given(
    corner=st.integers(0, len(CORNERS) - 1),
    bearing=st.one_of(st.sampled_from([k * np.pi / 4 for k in range(8)]), st.floats(-np.pi, np.pi)),
    distance=st.one_of(st.floats(0.0021, 0.01), st.floats(0.01, 1.0)),
    miss=st.one_of(st.just(0.0), st.floats(-0.003, 0.003)),
    share=st.sampled_from([0.999, 1.0, 0.5]),
)
def test_commands_aimed_at_corners_ends_and_along_walls(corner, bearing, distance, miss, share):
    """From beside a corner, at it, a hair past it, or along the wall that ends there."""
    away = distance * np.array([np.cos(bearing), np.sin(bearing)])
    x, y = jnp.asarray(CORNERS[corner] - away, jnp.float32)
    start = Pose(x, y, jnp.zeros(()), jnp.zeros(()))
    if not FREE(PAPER, start):
        return
    aim = jnp.float32(bearing + miss)
    for agent, motor in (
        (AGENTS["forward"], jnp.array([aim, share])),
        (AGENTS["holonomic"], jnp.array([aim, share, 0.002, 0.0])),
        (AGENTS["holonomic"], jnp.array([aim, distance, share, 0.0])),
    ):
        end, blocked = STEP(PAPER, agent, start, motor)
        if blocked:
            assert (end.x, end.y) == (start.x, start.y)
            continue
        leg = paths(np.stack([start.x, start.y]), np.stack([end.x, end.y]), end.heading, motor)
        assert not shapely.intersects(PAPER_WALLS, leg)
        assert FREE(PAPER, end)


def test_a_wall_takes_the_translation_and_leaves_the_turn():
    start = Pose(*jnp.array([39.5, 20.0, 0.0, 0.0]))
    end, blocked = step(layout("empty"), ForwardAgent(), start, jnp.array([0.1, 1.0]))
    assert blocked
    np.testing.assert_allclose([end.x, end.y, end.heading], [39.5, 20.0, 0.1], rtol=1e-6)


def test_nominal_displacement_ignores_walls_and_padding():
    start = Pose(*jnp.array([39.5, 20.0, 0.0, 0.0]))
    motors = jnp.array([[0.0, 1.0], [np.pi / 2, 1.0], [1.0, 1.0]])
    found = nominal_displacement(ForwardAgent(), start, motors, jnp.array(2))
    np.testing.assert_allclose(found, [1.0, 1.0, np.pi / 2], atol=1e-6)


def test_the_edge_of_the_lattice_stops_the_agent():
    world, agent = LatticeWorld(3, 3), LatticeAgent()
    ahead = jax.nn.one_hot(jnp.full(4, 3), 6)
    poses = rollout(world, agent, Pose(*jnp.zeros(4)), ahead)
    np.testing.assert_array_equal(poses.x, [0, 1, 2, 2, 2])
    np.testing.assert_array_equal(poses.y, 0)
