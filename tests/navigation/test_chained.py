"""Chained codes of an encoder that is right by construction."""

import math

import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np
import pytest

from motorspace import Part, UserError
from motorspace.models.config import ModelConfig
from motorspace.models.encoders.base import AbstractMotorEncoder
from motorspace.models.model import Scaling, build_model
from motorspace.navigation.arenas import Codes, Size, arena_of
from motorspace.navigation.chained import chained_code, fitted_probe, inverted, multiplied
from motorspace.navigation.config import NavigationConfig
from motorspace.navigation.tasks import DisplacementGoal, Home
from motorspace.worlds.agents import ForwardAgent, HolonomicAgent

TURN = 0.4 * math.pi


class Exact(AbstractMotorEncoder):
    """The matrices of the forward agent's motions, in units of its own."""

    def __call__(self, motors, num_steps):
        raise NotImplementedError

    def matrices(self, motor):
        turn, move = motor[0], motor[1]
        cos, sin = jnp.cos(turn), jnp.sin(turn)
        made = jnp.stack(
            [
                jnp.stack([cos, -sin, 3 * cos * move]),
                jnp.stack([sin, cos, 3 * sin * move]),
                jnp.array([0.0, 0.0, 1.0]),
            ]
        )
        return made, jnp.eye(3)


PRODUCTS = ModelConfig(encoder="matrix_product", hidden_size=8, code_size=6)


def network(config=PRODUCTS):
    return build_model(config, Scaling((1.0,), (1.0, 1.0)), horizon=2, key=jax.random.key(0))


EXACT = eqx.tree_at(lambda model: model.encoder, network(), Exact())


def arena(task, **options):
    config = NavigationConfig(
        task=task, agent=Part("forward", (("max_rotation", TURN),)), num_layouts=2,
        observe=("code", "displacement"), **options,
    )  # fmt: skip
    return arena_of(config, Codes(EXACT, network()), "train", Size(6, 2), key=jax.random.key(0))


@pytest.mark.parametrize("task", ["home", "displacement_goal"])
def test_chained_codes_are_where_the_goal_is_seen_from_here(task):
    found = arena(task)

    def forth(state, key):
        action = jax.random.uniform(key, (2, 6), minval=-1.0)
        after, outcome = found.advance(state, found.scenario.commands.from_unit(action))
        return after, (after.observation, outcome.blocked)

    first = found.begin_at(jnp.zeros(6, jnp.int32))
    _, (seen, blocked) = jax.jit(lambda s, k: jax.lax.scan(forth, s, k))(
        first, jax.random.split(jax.random.key(1), 30)
    )
    assert blocked.any(), "bumps are part of the test"
    code, true = seen[:, :6].reshape(30, 2, 3, 6), seen[:, 6:10]
    np.testing.assert_allclose(code[:, :, 2], 30 * true[:, :2], atol=0.02)
    if task == "home":
        np.testing.assert_allclose(code[:, 0, 0], true[:, 2], atol=1e-3)


def test_a_blocked_command_that_is_not_sensed_leads_astray():
    found = arena("displacement_goal", sense_blocked=False)
    ahead = jnp.tile(jnp.array([[0.0], [1.0]]), (1, 6))
    forth = jax.jit(lambda _, state: found.advance(state, ahead)[0])
    state = jax.lax.fori_loop(0, 45, forth, found.begin_at(jnp.zeros(6, jnp.int32)))
    assert np.abs(state.observation[2] - 30 * state.observation[6]).max() > 3.0


def test_the_map_from_displacements_to_matrices_is_fitted_to_fifty_walks():
    probe = fitted_probe(EXACT, ForwardAgent(TURN), key=jax.random.key(0))
    x, y, turn = 1.5, -0.5, 0.3
    inputs = np.array([x, y, math.cos(turn), math.sin(turn), 1.0])
    cos, sin = math.cos(turn), math.sin(turn)
    np.testing.assert_allclose(
        inputs @ np.asarray(probe), [cos, -sin, 3 * x, sin, cos, 3 * y], atol=2e-3
    )


@pytest.mark.parametrize("size", [3, 4])
def test_inverses(size):
    random = np.random.default_rng(0)
    made = np.broadcast_to(np.eye(size, dtype=np.float32)[..., None], (size, size, 5)).copy()
    made[:-1] += 0.3 * random.normal(size=(size - 1, size, 5)).astype(np.float32)
    found = multiplied(inverted(jnp.asarray(made)), jnp.asarray(made))
    np.testing.assert_allclose(
        found, np.broadcast_to(np.eye(size)[..., None], made.shape), atol=1e-5
    )


def test_networks_that_cannot_be_chained_are_refused():
    key = jax.random.key(0)
    with pytest.raises(UserError, match=r"run's commands have 2 channels, .* Holonomic.* have 4"):
        chained_code(network(), HolonomicAgent(), Home(), key=key)
    other = network(ModelConfig(hidden_size=8, code_size=6))
    with pytest.raises(UserError, match=r"no products of matrices.*preset best"):
        chained_code(other, ForwardAgent(), DisplacementGoal(), key=key)
    config = NavigationConfig(observe=("code",), num_layouts=1)
    with pytest.raises(UserError, match="computed by a trained network; give the run"):
        arena_of(config, None, "train", Size(2, 1), key=key)
