"""What each command does, against positions computed by hand."""

import jax
import jax.numpy as jnp
import numpy as np
import pytest

from motorspace import ForwardAgent, HolonomicAgent, LatticeAgent, LatticeWorld, Pose, UserError
from motorspace.worlds.layouts import layout

QUARTER = np.pi / 2
START = Pose(*jnp.array([1.0, 2.0, QUARTER, 0.0]))


def numbers(pose):
    return [float(v) for v in (pose.x, pose.y, pose.heading, pose.head)]


def test_forward_turns_then_moves():
    (end,) = ForwardAgent().move(START, jnp.array([-QUARTER, 0.5]))
    np.testing.assert_allclose(numbers(end), [1.5, 2.0, 0.0, 0.0], atol=1e-6)


def test_holonomic_turns_then_moves_ahead_then_left_then_sets_its_head():
    along, end = HolonomicAgent().move(START, jnp.array([-QUARTER, 0.5, 0.25, 1.0]))
    np.testing.assert_allclose(numbers(along), [1.5, 2.0, 0.0, 1.0], atol=1e-6)
    np.testing.assert_allclose(numbers(end), [1.5, 2.25, 0.0, 1.0], atol=1e-6)


@pytest.mark.parametrize(("rule", "head"), [("set", 0.5), ("turn", 0.8)])
def test_the_head_rule(rule, head):
    start = Pose(START.x, START.y, START.heading, jnp.float32(0.3))
    end = HolonomicAgent(head_rule=rule).turn(start, jnp.array([0.0, 0.0, 0.0, 0.5]))
    np.testing.assert_allclose(end.head, head, rtol=1e-6)


def test_the_head_starts_aligned_or_anywhere(getkey):
    assert HolonomicAgent().start(START, key=getkey()).head == 0
    scattered = HolonomicAgent(head_start="random")
    heads = jax.vmap(lambda k: scattered.start(START, key=k).head)(jax.random.split(getkey(), 99))
    assert np.ptp(heads) > 2.5 and np.abs(heads).max() <= QUARTER


@pytest.mark.parametrize(
    ("index", "expected"),
    [
        (0, (1, 2, 0)),
        (1, (2, 2, 0)),
        (2, (1, 2, QUARTER)),
        (3, (1, 3, QUARTER)),
        (4, (1, 2, np.pi)),
        (5, (0, 2, np.pi)),
    ],
)
def test_lattice_commands(index, expected):
    (end,) = LatticeAgent().move(START, jax.nn.one_hot(index, 6))
    np.testing.assert_allclose(numbers(end)[:3], expected, atol=1e-6)


@pytest.mark.parametrize(
    ("agent", "low", "high"),
    [
        (ForwardAgent(0.5), [-0.5, 0], [0.5, 1]),
        (HolonomicAgent(0.5), [-0.5, -1, -1, -QUARTER], [0.5, 1, 1, QUARTER]),
    ],
)
def test_sampled_commands_fill_their_ranges(agent, low, high, getkey):
    commands = agent.commands
    drawn = jax.vmap(lambda key: commands.sample(key=key))(jax.random.split(getkey(), 4000))
    np.testing.assert_allclose([commands.low, commands.high], [low, high], rtol=1e-6)
    span = np.subtract(high, low)
    drawn = np.asarray(drawn)
    assert (drawn >= np.array(low) - 1e-6).all() and (drawn <= np.array(high) + 1e-6).all()
    np.testing.assert_allclose(drawn.mean(0), np.add(low, high) / 2, atol=0.03 * span.max())
    np.testing.assert_allclose(drawn.std(0), span / np.sqrt(12), rtol=0.05)
    np.testing.assert_allclose(commands.scale, np.abs(high), rtol=1e-6)


def test_sampled_lattice_commands_are_one_hot(getkey):
    commands = LatticeAgent().commands
    drawn = jax.vmap(lambda key: commands.sample(key=key))(jax.random.split(getkey(), 300))
    np.testing.assert_array_equal(drawn.sum(1), 1)
    assert (drawn.sum(0) > 25).all()


@pytest.mark.parametrize("rotation", [0.0, -1.0, np.inf, np.nan])
@pytest.mark.parametrize("body", [ForwardAgent, HolonomicAgent])
def test_impossible_rotations_are_refused(body, rotation):
    with pytest.raises(UserError, match="max_rotation must be"):
        body(rotation)


def test_the_lattice_agent_needs_nodes():
    LatticeAgent().check(LatticeWorld())
    with pytest.raises(UserError, match=r"moves from node to node.* layout such as lattice:6"):
        LatticeAgent().check(layout("empty"))


def test_commands_say_what_their_channels_do():
    assert ForwardAgent().commands.turning == (0,)
    assert HolonomicAgent().commands.translating == (1, 2)
    assert HolonomicAgent().commands.looking == (3,)
    assert HolonomicAgent(head_rule="turn").commands.looking == ()
    assert LatticeAgent().commands.names[3] == "straight_move"
