"""Codes as actions: learning and evaluation carry out the same commands, and codes are kept."""

import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np
import pytest

from motorspace import UserError
from motorspace.control.codes import Examples, Whitening, blank_probe
from motorspace.control.controller import Controller
from motorspace.control.decoder import Decoder
from motorspace.navigation.actors import LearnedInCodes
from motorspace.navigation.arenas import Size, acted_in, arena_of
from motorspace.navigation.coded import SPREAD, CodeCommands, InCodes, code_commands
from motorspace.navigation.config import NavigationConfig, PolicyConfig
from motorspace.navigation.evaluation import run_episode
from motorspace.navigation.policies import Policy
from motorspace.training.run import initial_run
from motorspace.worlds.agents import ForwardAgent
from tests.tiny import TINY

COMMANDS = ForwardAgent().commands
CODE, HORIZON = 4, 3


@pytest.fixture(scope="module")
def codes():
    decoder = Decoder((CODE, HORIZON, 2), 1, width_size=8, depth=1, key=jax.random.key(5))
    return CodeCommands(decoder, SPREAD * jnp.eye(CODE), jnp.zeros(CODE), COMMANDS)


@pytest.fixture(scope="module")
def arena():
    config = NavigationConfig(observe=("ranges", "bump"), num_layouts=2, max_steps=20)
    return arena_of(config, None, "train", Size(6, 1), key=jax.random.key(0))


def test_learning_and_evaluation_carry_out_the_same_commands(arena, codes):
    policy = Policy(PolicyConfig(8), arena.begin_at(jnp.zeros(6, int)).observation.shape[0], CODE,
                    key=jax.random.key(1))  # fmt: skip
    last = policy.actor.layers[-1].weight  # as it begins every code is nearly the same
    policy = eqx.tree_at(lambda p: p.actor.layers[-1].weight, policy, 100 * last)
    first = arena.begin_at(jnp.zeros(6, jnp.int32))
    done, poses = run_episode(arena, LearnedInCodes(policy, codes), first, key=jax.random.key(2))
    environment, state = InCodes(arena, codes), first
    step = jax.jit(lambda s, k: environment.step(s, each(s), key=k))
    each = lambda s: jax.vmap(policy)(jnp.zeros((6, 0)), environment.observed(s)).mean  # noqa: E731
    ended, decisions, early = np.zeros(6, bool), np.zeros(6, int), 0
    for number in range(40):
        before = np.asarray(state.steps)
        state, then = step(state, jax.random.key(number))
        decisions += ~ended & np.asarray(then.acted)
        ended |= np.asarray(then.terminated | then.truncated)
        for agent in np.flatnonzero(~ended):
            now = int(state.steps[agent])
            early += now - before[agent] < HORIZON
            for field in ("x", "y", "heading"):
                ours = float(getattr(state.pose, field)[agent])
                assert ours == pytest.approx(float(getattr(poses, field)[now, agent]), abs=1e-4)
    assert ended.all() and early > 0, "bumps, and the end of the wander, end a sequence"
    np.testing.assert_array_equal(decisions, done.decisions)
    assert (done.decisions < done.steps).any()


def test_actions_of_another_space_mean_the_same_codes(codes):
    random = np.random.default_rng(0)
    drawn = jnp.asarray(random.normal(size=(2, CODE, 1 + CODE)), jnp.float32)
    own, other = (Whitening(one[:, 0], one[:, 1:]) for one in drawn)

    bank = Examples(jnp.zeros((1, HORIZON, 2)), jnp.zeros((1, CODE)))
    model = initial_run(TINY).model
    known = Controller(model, codes.decoder, own, blank_probe(CODE), bank, COMMANDS)
    made, action = code_commands(known, other), jnp.asarray([0.5, -1.0, 0.1, 0.0])
    code = other.undone(SPREAD * action)
    np.testing.assert_allclose(made.weights @ action + made.offset, own(code), rtol=2e-3, atol=2e-3)
    np.testing.assert_allclose(code_commands(known).weights, SPREAD * np.eye(CODE), atol=1e-4)


def test_codes_need_a_controller(arena):
    with pytest.raises(UserError, match="codes become commands by a controller"):
        acted_in(NavigationConfig(act="codes"), arena, None)
    with pytest.raises(UserError, match="act must be 'commands' or 'codes'"):
        NavigationConfig(act="words")
