"""Sampling is reproducible, and what it logs is what happened."""

import re

import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np
import pytest

from motorspace import (
    ForwardAgent,
    HolonomicAgent,
    LatticeAgent,
    LatticeWorld,
    NodeIndex,
    RangeFan,
    Scenario,
    UserError,
    sample,
)
from motorspace.trajectories.sampling import SamplingPlan, bytes_per_trajectory, simulate
from motorspace.worlds.layouts import layout, load_layout

PAPER, FAN = layout("paper"), RangeFan()
SYSTEMS = {
    "forward": Scenario(PAPER, ForwardAgent(), FAN),
    "holonomic": Scenario(PAPER, HolonomicAgent(), FAN),
    "lattice": Scenario(LatticeWorld(), LatticeAgent(), NodeIndex()),
}
KEY = jax.random.key(3)
NUM = 400  # the same everywhere: every other number is another compilation
systems = pytest.mark.parametrize("system", SYSTEMS.values(), ids=SYSTEMS)


def as_bytes(tree):
    return [np.asarray(leaf).tobytes() for leaf in jax.tree.leaves(tree)]


@systems
def test_shapes_and_same_key_same_bytes(system):
    first, again = (sample(system, num=NUM, horizon=6, key=KEY) for _ in range(2))
    sensors, motors = system.space.size, system.commands.size
    assert first.experience.sensors.shape == (NUM, sensors)
    assert first.experience.later_sensors.shape == (NUM, sensors)
    assert first.experience.motors.shape == (NUM, 6, motors)
    assert first.displacements.achieved.shape == (NUM, 3)
    assert len(first) == NUM and len(first[:5]) == 5
    assert as_bytes(first) == as_bytes(again)
    other = sample(system, num=NUM, horizon=6, key=jax.random.key(4))
    assert as_bytes(first.experience.motors) != as_bytes(other.experience.motors)


@systems
def test_resampled_displacements_are_what_the_commands_say(system):
    drawn = sample(system, num=NUM, horizon=6, key=KEY)
    difference = drawn.displacements.nominal - drawn.displacements.achieved
    wrapped = np.angle(np.exp(1j * np.asarray(difference[:, 2])))
    np.testing.assert_allclose(difference[:, :2], 0, atol=1e-4)
    np.testing.assert_allclose(wrapped, 0, atol=1e-4)
    assert (drawn.experience.num_steps == 6).all()


@systems
def test_blocked_commands_are_logged_all_the_same(system):
    drawn = sample(system, num=NUM, horizon=6, collision="block", key=KEY)
    assert (drawn.experience.num_steps == 6).all()
    assert (np.abs(drawn.experience.motors).max(-1) > 0).all()
    shift = np.asarray(drawn.displacements.nominal - drawn.displacements.achieved)[:, :2]
    blocked = np.abs(shift).max(-1) > 1e-3
    assert 0.02 < blocked.mean() < 0.98
    # A wall takes translations alone: the turns are the commanded ones.
    turn = drawn.displacements.nominal[:, 2] - drawn.displacements.achieved[:, 2]
    np.testing.assert_allclose(np.angle(np.exp(1j * np.asarray(turn))), 0, atol=1e-4)


def test_lengths_vary_between_their_limits_and_the_rest_is_zero():
    drawn = sample(SYSTEMS["forward"], num=NUM, horizon=6, min_horizon=2, key=KEY).experience
    counts = np.bincount(drawn.num_steps, minlength=7)
    assert (counts[:2] == 0).all() and (counts[2:] > 50).all()
    empty = np.arange(6) >= np.asarray(drawn.num_steps)[:, None]
    np.testing.assert_array_equal((np.asarray(drawn.motors) == 0).all(-1), empty)


def test_a_trajectory_depends_on_the_key_and_its_number_alone():
    """However many others are drawn beside it, or in which chunk it is simulated."""
    few, many = (
        sample(SYSTEMS["holonomic"], num=num, horizon=3, key=KEY).experience for num in (7, 100)
    )
    np.testing.assert_allclose(many.motors[:7], few.motors, atol=1e-6)
    np.testing.assert_allclose(many.later_sensors[:7], few.later_sensors, atol=1e-3)


@pytest.mark.parametrize(
    ("sizes", "message"),
    [
        ({"num": 0, "horizon": 6}, "num must be at least 1, got 0"),
        ({"num": 5, "horizon": 0}, "horizon must be at least 1, got 0"),
        ({"num": 5, "horizon": 3, "min_horizon": 4}, "min_horizon 4 is above horizon 3"),
        ({"num": 5, "horizon": 3, "min_horizon": 0}, "min_horizon must be at least 1, got 0"),
    ],
)
def test_impossible_sizes_are_refused(sizes, message):
    with pytest.raises(UserError, match=message):
        sample(SYSTEMS["forward"], **sizes, key=KEY)


def test_whatever_names_a_world_is_sampled(tmp_path):
    described = load_layout("paper")
    path = tmp_path / "own.layout"
    path.write_text(described.text())
    expected = as_bytes(sample(SYSTEMS["forward"], num=NUM, horizon=6, key=KEY))
    for world in ("paper", path, str(path), described, described.text(), PAPER, Scenario(path)):
        assert as_bytes(sample(world, num=NUM, horizon=6, key=KEY)) == expected


def ahead(*, key):
    return jnp.array([0.0, 1.0]) * jax.random.uniform(key)


def test_an_own_policy_chooses_the_commands():
    drawn = sample(SYSTEMS["forward"], num=NUM, horizon=6, policy=ahead, key=KEY)
    np.testing.assert_array_equal(drawn.experience.motors[..., 0], 0)
    np.testing.assert_allclose(drawn.displacements.achieved[:, 1:], 0, atol=1e-4)


@pytest.mark.slow
def test_trajectories_are_the_same_where_float64_is_enabled():
    """Whoever enables it for work of their own gets float32 and the same numbers."""
    expected = sample(SYSTEMS["holonomic"], num=NUM, horizon=6, key=KEY)
    with jax.enable_x64(True):
        found = sample(Scenario(PAPER, HolonomicAgent()), num=NUM, horizon=6, key=KEY)
    assert as_bytes(found) == as_bytes(expected)


def test_more_than_memory_holds_is_refused_before_it_is_drawn():
    with pytest.raises(
        UserError, match=r"1,000,000,000,000 trajectories .* GiB.*at most [\d,]+ at"
    ):
        sample(SYSTEMS["forward"], num=10**12, horizon=6, key=KEY)


def test_the_stated_size_is_the_size():
    drawn = sample(SYSTEMS["holonomic"], num=NUM, horizon=6, key=KEY)
    size = sum(leaf.nbytes for leaf in jax.tree.leaves(drawn))
    assert size == NUM * bytes_per_trajectory(6, 4, 9)


def test_batches_of_sensors_equal_a_loop():
    fan = FAN
    places = jax.vmap(lambda key: PAPER.place(key=key))(jax.random.split(KEY, 20))
    together = eqx.filter_jit(jax.vmap(fan.sense, in_axes=(None, 0)))(PAPER, places)
    for index in range(20):
        alone = fan.sense(PAPER, jax.tree.map(lambda leaf, i=index: leaf[i], places))
        np.testing.assert_allclose(together[index], alone, atol=1e-4)


def test_sensing_the_same_as_before_costs_a_lot():
    """Predicting no change must be a poor predictor, or there is nothing to learn."""
    drawn = sample(SYSTEMS["forward"], num=NUM, horizon=6, key=KEY).experience
    assert jnp.mean((drawn.sensors - drawn.later_sensors) ** 2) > 5.0
    assert jnp.var(drawn.sensors) > 3.0


def test_the_compiled_program_repeats_neither_random_numbers_nor_sines():
    """Fused into what uses them, they would be computed again for every ray and every field."""
    num = 2000
    text = simulate.lower(
        Scenario(),
        SamplingPlan(num, 6, "resample"),
        (jnp.array(6), jnp.array(6)),
        key=jax.random.key(0),
    ).compile().compiled.as_text()  # fmt: skip
    # Sixteen rounds of the generator are one loop over unsigned integers.
    loops = [line for line in text.split("\n") if " while(" in line and "u32[4]{0}, u32[4]" in line]
    everybody = [line for line in loops if f",{num}," in line or f"u32[{num}" in line]
    prologue, per_round = 7, 2
    assert len(everybody) == prologue + per_round
    assert " sine(" not in text and " cosine(" not in text
    # Our own sine is known by its coefficients; no computation over rays may hold them.
    computations = re.split(r"\n}\n", text)
    with_sine = [c for c in computations if "0.00833216" in c]
    assert with_sine and not any(re.search(rf"f32\[9,{num}\]", c) for c in with_sine)
