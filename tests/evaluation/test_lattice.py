"""The count of every lattice case, against a count by hand and a model that is always right."""

import itertools
from dataclasses import replace
from functools import partial

import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np
import pytest

from motorspace._types import Pose
from motorspace.evaluation import lattice
from motorspace.evaluation.evaluate import evaluate
from motorspace.evaluation.lattice import lattice_counts
from motorspace.evaluation.prediction import CHUNK_SIZE
from motorspace.models.config import ModelConfig
from motorspace.models.encoders.base import AbstractMotorEncoder
from motorspace.models.model import Model, Scaling, build_model
from motorspace.models.predictors import SensorPredictor
from motorspace.training.config import RunConfig, TrainingConfig
from motorspace.training.data import Simulated
from motorspace.training.run import Run, initial_run
from motorspace.worlds.agents import LatticeAgent
from motorspace.worlds.sensors.node_index import NodeIndex
from motorspace.worlds.simulation import rollout
from motorspace.worlds.world import LatticeWorld

SIDE, HORIZON = 3, 3
CONFIG = RunConfig(
    Simulated("lattice", layout=f"lattice:{SIDE}", horizon=HORIZON, min_horizon=1),
    ModelConfig(hidden_size=8, code_size=4, width_size=8, depth=1),
    TrainingConfig(epochs=1, trajectories_per_epoch=10, batch_size=10),
)
SCALING = Scaling((1.0,) * (SIDE**2 + 4), (1.0,) * 6)


class Laid(AbstractMotorEncoder):
    """The sequence itself and its length, as a code."""

    def __call__(self, motors, num_steps):
        return jnp.concatenate([motors.reshape(-1), num_steps[None].astype(float)])


class Walker(SensorPredictor):
    """A predictor that walks the sequence, and may turn once too often."""

    wrong_turn: jax.Array

    def __init__(self, wrong_turn):
        self.mlp = eqx.nn.MLP(1, 1, 1, 1, key=jax.random.key(0))
        self.wrong_turn = jnp.array(float(wrong_turn))

    def __call__(self, sensors, code):
        node, quarter = sensors[:-4].argmax(), sensors[-4:].argmax()
        x, y, heading, head = (
            v.astype(float) for v in (node % SIDE, node // SIDE, quarter, 0 * node)
        )
        start = Pose(x, y, heading * jnp.pi / 2, head)
        motors = code[:-1].reshape(HORIZON, 6)
        path = rollout(LatticeWorld(SIDE, SIDE), LatticeAgent(), start, motors)
        end = jax.tree.map(lambda field: field[code[-1].astype(int)], path)
        end = Pose(end.x, end.y, end.heading + self.wrong_turn * jnp.pi / 2, end.head)
        return NodeIndex().sense(LatticeWorld(SIDE, SIDE), end)


def valid_by_hand(num_steps):
    """Starts and sequences that stay on the lattice, in whole numbers."""
    ahead = [(1, 0), (0, 1), (-1, 0), (0, -1)]
    valid = 0
    for x0, y0, turned in itertools.product(range(SIDE), range(SIDE), range(4)):
        for sequence in itertools.product(itertools.product((-1, 0, 1), (0, 1)), repeat=num_steps):
            x, y, quarter, inside = x0, y0, turned, True
            for turn, move in sequence:
                quarter = (quarter + turn) % 4
                x, y = x + move * ahead[quarter][0], y + move * ahead[quarter][1]
                inside &= 0 <= x < SIDE and 0 <= y < SIDE
            valid += inside
    return valid


@pytest.mark.parametrize("wrong_turn", [False, True])
def test_every_valid_case_is_counted_once(wrong_turn):
    counts = lattice_counts(Run(CONFIG, Model(Laid(), Walker(wrong_turn), None, SCALING)))
    assert [c.num_steps for c in counts] == [1, 2, 3]
    for count in counts:
        assert count.valid == valid_by_hand(count.num_steps)
        assert count.correct == (0 if wrong_turn else count.valid)


def test_lengths_with_too_many_sequences_are_sampled(monkeypatch):
    monkeypatch.setattr(lattice, "MOST_SEQUENCES", 100)
    one, two, three = (lattice.sequences(num_steps) for num_steps in (1, 2, 3))
    assert one.shape == (6, 1) and two.shape == (36, 2)
    assert three.shape == (100, 3) and len(np.unique(three, axis=0)) > 50
    counts = lattice_counts(Run(CONFIG, Model(Laid(), Walker(False), None, SCALING)))
    assert [count.correct for count in counts] == [count.valid for count in counts]
    assert counts[1].valid == valid_by_hand(2)
    assert 0 < counts[2].valid < valid_by_hand(3)


def test_a_horizon_of_ten_is_measured_in_bounded_memory():
    sequences = lattice.sequences(10)
    assert sequences.shape == (lattice.MOST_SEQUENCES, 10)
    assert sequences.nbytes < 2**23
    np.testing.assert_array_equal(sequences, lattice.sequences(10))


@pytest.mark.slow
def test_a_lattice_of_long_sequences_is_evaluated():
    data = Simulated("lattice", horizon=10)
    run = initial_run(replace(CONFIG, data=data))
    measured = evaluate(run, num=CHUNK_SIZE)
    assert 0 < measured["lattice.valid.10"] < 144 * lattice.MOST_SEQUENCES
    assert 0 <= measured["lattice.accuracy"] < 0.2


@pytest.mark.slow
def test_an_untrained_network_is_measured_and_found_wanting(getkey, monkeypatch):
    # As many as a chunk has everywhere: each other number is compiled anew.
    few = partial(lattice.measure_lattice, num_codes=CHUNK_SIZE)
    monkeypatch.setattr("motorspace.evaluation.evaluate.measure_lattice", few)
    model = build_model(CONFIG.model, SCALING, horizon=HORIZON, key=getkey())
    measured = evaluate(Run(CONFIG, model), num=CHUNK_SIZE)
    assert measured["lattice.accuracy"] < 0.2
    assert measured["lattice.valid.1"] == valid_by_hand(1)
    assert 0 < measured["lattice.within_to_total"] <= 1
    assert measured["prediction.num"] == CHUNK_SIZE
