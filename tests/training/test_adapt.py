"""Parts of a network that learn while others stay."""

from dataclasses import replace

import equinox as eqx
import jax
import numpy as np
import pytest

from motorspace import RangeFan, UserError
from motorspace.training.adapt import adapt
from motorspace.training.config import RunConfig
from motorspace.training.data import Simulated
from motorspace.training.run import initial_run
from motorspace.training.settings import changed
from tests.tiny import TINY

SETTINGS = {"encoder": "matrix_product", "code_size": 6, "epochs": 2, "restarts": 1}


@pytest.fixture(scope="module")
def run():
    return initial_run(changed(TINY, SETTINGS))


def same(one, other):
    pairs = zip(*(jax.tree.leaves(eqx.filter(m, eqx.is_array)) for m in (one, other)), strict=True)
    return all(np.array_equal(a, b) for a, b in pairs)


@pytest.mark.parametrize("restarts", [1, 2])
def test_an_encoder_learns_what_the_predictor_takes(run, restarts):
    body = Simulated("holonomic", layout="empty", horizon=2)
    training = replace(run.config.training, restarts=restarts)
    found = adapt(run, body, learn="encoder", training=training)
    assert same(found.model.predictor, run.model.predictor)
    blank = initial_run(RunConfig(body, run.config.model, training))
    assert not same(found.model.encoder, blank.model.encoder)
    assert found.log[-1]["epoch"] == 2 and found.config.data.agent.kind == "holonomic"


def test_a_predictor_learns_of_the_codes_there_are(run):
    sensor = Simulated("forward", RangeFan(num_rays=3), layout="empty", horizon=2)
    found = adapt(run, sensor, learn="predictor")
    assert same(found.model.encoder, run.model.encoder)
    blank = initial_run(RunConfig(sensor, run.config.model, run.config.training))
    assert not same(found.model.predictor, blank.model.predictor)
    assert len(found.model.scaling.sensors) == 3


def test_what_stays_must_fit(run):
    few = Simulated("forward", RangeFan(num_rays=3), layout="empty", horizon=2)
    with pytest.raises(UserError, match="the sensors are not those of the run, whose predictor"):
        adapt(run, few, learn="encoder")
    other = Simulated("holonomic", layout="empty", horizon=2)
    with pytest.raises(UserError, match="the commands are not those of the run, whose encoder"):
        adapt(run, other, learn="predictor")
    with pytest.raises(UserError, match="learn must be 'encoder' or 'predictor'"):
        adapt(run, other, learn="everything")
