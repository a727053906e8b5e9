"""Goals are reached where the network knows displacement exactly."""

import dataclasses
import math

import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np
import pytest

from motorspace._errors import UserError
from motorspace._types import Pose
from motorspace.analysis.probes import displacement_targets
from motorspace.control.codes import encode, fit_probe, whitening
from motorspace.control.composing import (
    as_code,
    as_matrix,
    chained,
    held,
    is_product,
    remaining,
)
from motorspace.control.decoder import squash, unsquash
from motorspace.control.following import carry_out, follow
from motorspace.control.goals import CodeGoal, DisplacementGoal, SensorGoal
from motorspace.control.learning import (
    RANDOM_SPREAD,
    Task,
    _decoder_from,
    decoding_loss,
    learn_decoder,
    learn_remainder,
    remainder_loss,
)
from motorspace.control.planning import METHODS, Effort, code_target, plan, reach
from motorspace.control.refine import levenberg_marquardt
from motorspace.control.trials import displacement_goals, displacement_trials, moved
from motorspace.se2 import compose
from motorspace.worlds.agents import ForwardAgent, HolonomicAgent
from motorspace.worlds.scenario import Scenario
from tests.control import exact

HERE = np.full(9, 5.0)


@pytest.fixture(scope="module")
def controller():
    return exact.controller()


@pytest.fixture(scope="module")
def motors():
    return exact.AGENT.commands.spread(jax.random.uniform(jax.random.key(3), (2, 5))).T


def place(x, y, heading):
    return Pose(*jnp.array([x, y, heading, 0.0], jnp.float32))


def sequence(*commands):
    return jnp.array(commands, jnp.float32)


def test_commands_are_squashed_into_their_bounds_and_back(getkey):
    logits = jax.random.uniform(getkey(), (4, 2), minval=-5.0, maxval=5.0)
    motors = squash(exact.AGENT.commands, logits)
    assert (motors[:, 1] > 0).all() and (jnp.abs(motors[:, 0]) < 1).all()
    np.testing.assert_allclose(unsquash(exact.AGENT.commands, motors), logits, atol=1e-3)


def test_whitened_codes_have_unit_variance_but_flat_directions_are_not_blown_up(getkey):
    codes = jax.random.normal(getkey(), (4000, 3)) * jnp.array([5.0, 1.0, 1e-4])[None] + 7.0
    white = jax.vmap(whitening(codes))(codes)
    spread = np.sort(np.asarray(white.std(axis=0)))
    np.testing.assert_allclose(spread[1:], 1.0, rtol=1e-3)
    assert spread[0] < 1e-3
    np.testing.assert_allclose(white.mean(axis=0), 0.0, atol=1e-3)


def test_the_probe_maps_displacements_to_their_codes(controller):
    code = encode(controller.model, sequence((0.5, 1.0), (0.2, 0.3), (-1.0, 0.8)))
    displacement = moved(exact.AGENT, sequence((0.5, 1.0), (0.2, 0.3), (-1.0, 0.8)))
    np.testing.assert_allclose(controller.probe(displacement), code, atol=1e-3)


def test_the_probe_bends_where_examples_show_it_and_goes_on_straight_beyond(getkey):
    def bent(moved):
        x, y, cos, sin = np.asarray(displacement_targets(jnp.asarray(moved))).T
        return jnp.asarray(np.stack([x + 0.1 * x * y, cos + 0.1 * x * sin], axis=-1))

    moved = np.asarray(jax.random.uniform(getkey(), (50, 3), minval=-1.0, maxval=1.0))
    probe = fit_probe(moved, bent(moved))
    new = np.asarray(jax.random.uniform(getkey(), (20, 3), minval=-0.9, maxval=0.9))
    np.testing.assert_allclose(jax.vmap(probe)(jnp.asarray(new)), bent(new), atol=0.01)
    far = jnp.array([[10.0, 0.0, 0.0], [20.0, 0.0, 0.0], [30.0, 0.0, 0.0]])
    first, second = jnp.diff(jax.vmap(probe)(far), axis=0)
    np.testing.assert_allclose(first, second, atol=1e-3)


def test_the_probe_does_not_bend_for_noise(getkey):
    moved = np.asarray(jax.random.uniform(getkey(), (50, 3), minval=-1.0, maxval=1.0))
    noise = 0.1 * jax.random.normal(getkey(), (50, 1))
    probe = fit_probe(moved, jnp.asarray(moved[:, :1]) + noise)
    bend = np.abs(np.asarray(probe.weights[5:]))
    assert bend.max() < 0.03


def test_refining_finds_the_root_of_what_is_asked():
    def residual(logits):
        return jnp.array([jnp.sum(logits[0]) - 2.0, logits[1, 0] * logits[1, 1] - 1.0])

    found = levenberg_marquardt(residual, jnp.array([[0.5, 0.1], [0.7, 0.4]]), 8)
    assert float(jnp.sum(residual(found) ** 2)) < 1e-6


def test_a_refinement_that_does_not_help_is_not_made():
    start = jnp.array([[0.3, 0.2]])
    found = levenberg_marquardt(lambda logits: jnp.ones(1) + 0 * logits[0, :1], start, 3)
    np.testing.assert_array_equal(found, start)


@pytest.mark.parametrize("method", [m for m in METHODS if m != "amortised"])
def test_every_search_reaches_a_displacement(controller, method):
    target = moved(exact.AGENT, sequence((0.4, 0.9), (0.3, 0.5), (-0.2, 0.7)))
    effort = Effort(guesses=8, starts=4, refinements=8, shots=20_000, descent_steps=200)
    found = plan(controller, HERE, DisplacementGoal(*target.tolist()), method=method, effort=effort)
    reached = moved(exact.AGENT, jnp.asarray(found.motors))
    np.testing.assert_allclose(reached, target, atol=0.2 if method == "shooting" else 0.05)
    assert found.code.shape == (6,) and found.sensors.shape == (9,) and found.miss < 0.5


def test_learning_to_decode_needs_no_label_and_helps(controller):
    task = Task(controller.model, controller.commands, controller.whitening, exact.HORIZON)
    config = dataclasses.replace(exact.CONFIG, updates=300, learning_rate=5e-3)
    learned = learn_decoder(task, config, key=jax.random.key(0))
    loss = [
        float(decoding_loss(decoder, task, config, key=jax.random.key(9)))
        for decoder in (controller.decoder, learned)
    ]
    assert loss[1] < loss[0] / 4
    able = dataclasses.replace(controller, decoder=learned)
    goals = displacement_goals(exact.AGENT, 200, exact.HORIZON, key=jax.random.key(5))
    rates = [
        displacement_trials(able, exact.AGENT, goals, method, key=jax.random.key(6)).success()
        for method in ("amortised", "hybrid")
    ]
    assert 0.5 < rates[0] < rates[1] and rates[1] > 0.9


def test_of_several_decoders_the_best_is_learned(controller, monkeypatch):
    """Losses as if the second initial weights of three were the best."""
    task = Task(controller.model, controller.commands, controller.whitening, exact.HORIZON)
    config, key = dataclasses.replace(exact.CONFIG, updates=2, restarts=3), jax.random.key(4)
    losses = iter([0.3, 0.1, 0.2, 0.05])
    monkeypatch.setattr("motorspace.control.learning._loss_of", lambda *_: next(losses))
    found = learn_decoder(task, config, key=key)
    second = _decoder_from(task, config, key=jax.random.split(key, 3)[1])
    for a, b in zip(jax.tree.leaves(found), jax.tree.leaves(second), strict=True):
        np.testing.assert_array_equal(a, b)


def test_answers_that_are_alike_cost_as_much_as_was_asked_for(controller):
    weight = controller.decoder.mlp.layers[0].weight
    deaf = eqx.tree_at(
        lambda d: d.mlp.layers[0].weight, controller.decoder, weight.at[:, 6:].set(0.0)
    )
    task = Task(controller.model, controller.commands, controller.whitening, exact.HORIZON)

    def loss(diversity):
        config = dataclasses.replace(exact.CONFIG, diversity=diversity)
        return float(decoding_loss(deaf, task, config, key=jax.random.key(3)))

    assert loss(0.5) - loss(0.0) == pytest.approx((0.5 * RANDOM_SPREAD) ** 2, rel=1e-3)


def test_a_code_is_a_matrix_without_its_last_row(getkey):
    code = jax.random.normal(getkey(), (6,))
    np.testing.assert_array_equal(as_code(as_matrix(code)), code)
    np.testing.assert_array_equal(as_matrix(code)[-1], [0, 0, 1])


def test_what_remains_completes_what_was_done(controller, motors):
    assert is_product(controller.model)
    goal = encode(controller.model, motors)
    carried_out = jnp.arange(len(motors)) < 2
    rest = remaining(controller.model, goal, motors, carried_out)
    np.testing.assert_allclose(rest, encode(controller.model, motors[2:]), atol=1e-5)


def test_what_remains_is_learned_where_codes_are_no_products(controller):
    task = Task(controller.model, controller.commands, controller.whitening, exact.HORIZON)
    config = dataclasses.replace(exact.CONFIG, updates=400, learning_rate=5e-3, width_size=64)
    learned = learn_remainder(task, config, key=jax.random.key(0))
    blank = config.remainder(6, key=jax.random.key(0))
    loss = [
        float(remainder_loss(net, task, config, key=jax.random.key(9))) for net in (blank, learned)
    ]
    assert loss[1] < 0.2 * loss[0]


def test_an_agent_that_holds_stands_still_and_looks_where_it_looks():
    commands = HolonomicAgent(max_rotation=1.0).commands
    motors = jnp.ones((3, 4)) * jnp.array([0.1, 0.2, 0.3, 0.4])[None]
    np.testing.assert_allclose(held(commands, motors, jnp.array(2))[2], [0, 0, 0, 0.4])


def test_a_blocked_command_turns_and_does_not_move(controller):
    motors = sequence((0.5, 1.0), (0.2, 0.3))
    blocked = jnp.array([True, False])
    happened = controller.commands.without_translation(motors.T, blocked).T
    np.testing.assert_allclose(happened, [(0.5, 0.0), (0.2, 0.3)])
    np.testing.assert_allclose(
        as_code(chained(controller.model, happened, jnp.array([True, True]))),
        encode(controller.model, happened),
        atol=1e-6,
    )


def test_a_bump_ends_a_round():
    scenario = Scenario("empty", exact.AGENT)
    wall = place(39.5, 20.0, 0.0)
    motors = sequence((0.0, 0.3), (0.1, 1.0), (0.2, 1.0))
    poses, blocked, done = carry_out(scenario, wall, motors)
    assert blocked.tolist() == [False, True, False] and done.tolist() == [True, True, False]
    np.testing.assert_allclose(poses.x, 39.8, atol=1e-5)
    np.testing.assert_allclose(poses.heading, [0.0, 0.1, 0.1], atol=1e-6)


def test_a_goal_beyond_one_sequence_is_reached_in_rounds():
    agile = ForwardAgent(max_rotation=2.0)
    controller, scenario = exact.controller(agile, 4), Scenario("empty", agile)
    start, goal = place(10.0, 20.0, 0.3), jnp.array([7.0, 3.0, -0.5])
    code = controller.probe(goal)
    way = follow(
        controller, scenario, start, code, rounds=6, method="cross_entropy", key=jax.random.key(0)
    )
    assert way.motors.shape == (24, 2) and way.poses.x.shape == (25,)
    x, y, _ = compose(start.frame, tuple(goal))
    end = jax.tree.map(lambda field: field[-1], way.poses)
    assert math.hypot(float(end.x - x), float(end.y - y)) < 0.25
    assert abs(float(end.heading) + 0.2) < math.radians(10)


def test_readings_that_are_expected_are_reached(controller):
    """The network's own account is all that a goal of readings has."""
    wanted = controller.model.predict(jnp.asarray(HERE, jnp.float32), controller.bank.codes[7])
    found = plan(controller, HERE, SensorGoal(wanted.tolist()), effort=Effort(refinements=6))
    np.testing.assert_allclose(found.sensors, wanted, atol=0.05)


@pytest.mark.parametrize(
    ("goal", "sentence"),
    [
        (CodeGoal([1.0, 2.0]), "the code must be 6 numbers"),
        (SensorGoal([1.0]), "the readings wanted must be 9 numbers"),
    ],
)
def test_a_goal_of_the_wrong_length_is_refused(controller, goal, sentence):
    with pytest.raises(UserError, match=sentence):
        plan(controller, HERE, goal)


def test_what_is_not_finite_or_not_there_is_refused(controller):
    with pytest.raises(UserError, match="must be finite"):
        DisplacementGoal(math.nan, 0.0)
    with pytest.raises(UserError, match="the readings now must be finite"):
        plan(controller, HERE * np.inf, CodeGoal([0.0] * 6))
    with pytest.raises(UserError, match="there is no method 'magic'"):
        plan(controller, HERE, CodeGoal([0.0] * 6), method="magic")


def test_a_displacement_that_no_sequence_reaches_is_refused(controller):
    with pytest.raises(UserError, match=r"no sequence of 3 commands leads farther than 3 units"):
        plan(controller, HERE, DisplacementGoal(3.0, 0.5))


def test_the_seed_chooses_among_sequences(controller):
    target = code_target(controller, controller.bank.codes[0])
    first, second = (
        reach(controller, target, "amortised", key=jax.random.key(seed)) for seed in (0, 1)
    )
    assert float(jnp.abs(first - second).max()) > 1e-4
