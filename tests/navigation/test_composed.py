"""Codes that are no products: what a learned composition makes of the goal."""

import jax
import jax.numpy as jnp
import numpy as np
import pytest

from motorspace.control.codes import encode
from motorspace.control.learning import ControlConfig
from motorspace.navigation.composed import (
    ComposedCode,
    blank_composition,
    composition_sizes,
    learn_composition,
)
from motorspace.navigation.observations import Moment
from motorspace.navigation.problems import Problem
from motorspace.navigation.tasks import Home
from motorspace.training.checkpoint import named_arrays
from motorspace.training.run import initial_run
from tests.tiny import TINY


@pytest.fixture(scope="module")
def part():
    run = initial_run(TINY)
    config = ControlConfig(updates=2, batch_size=8, width_size=8, depth=1, labels=30, bank=64)
    agent = TINY.data.scenario().agent
    return ComposedCode(run.model, learn_composition(run, config), agent, Home())


def moment(motor, blocked):
    unknown = Problem(*[None] * len(Problem._fields))
    problem = unknown._replace(distance=jnp.zeros(2))
    return Moment(None, motor, blocked, None, None, problem)


def test_home_begins_as_the_code_of_standing_still(part):
    memory = part.begin(moment(jnp.zeros((2, 2)), jnp.zeros(2, bool)))
    still = part.known.whitening(encode(part.model, jnp.zeros((TINY.data.horizon, 2))))
    np.testing.assert_allclose(memory, np.stack([still, still], axis=-1), rtol=1e-5)


def test_what_is_left_is_composed_and_a_blocked_move_does_not_count(part):
    memory = jax.random.normal(jax.random.key(0), (len(part.known.whitening.centre), 2))
    memory = memory.at[:, 1].set(memory[:, 0])
    motor = jnp.array([[0.3, 0.3], [0.8, 0.8]])
    turned = motor.at[1, 1].set(0.0)
    now = part.update(memory, moment(motor, jnp.array([False, True])))
    both = part.update(memory, moment(turned, jnp.zeros(2, bool)))
    np.testing.assert_allclose(now, both, rtol=1e-5)
    assert not np.allclose(now[:, 0], now[:, 1])


def test_a_blank_one_has_the_same_shape(part):
    blank = blank_composition(composition_sizes(part.known), part.known.commands)
    shapes = [
        {name: leaf.shape for name, leaf in named_arrays(known).items()}
        for known in (blank, part.known)
    ]
    assert shapes[0] == shapes[1]
