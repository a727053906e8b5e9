"""The same seeds give the same training as when the results were measured."""

import pytest

from motorspace.studies.cells import system
from motorspace.training.run import train
from motorspace.training.settings import changed

SHORT = {"epochs": 3, "trajectories_per_epoch": 400}
BEFORE = {
    ("forward", "paper"): ({}, 0.20976470),
    ("holonomic", "paper"): ({"encoder": "attention"}, 0.14071129),
    ("forward", "best"): ({"restarts": 1, "curriculum": 0.34}, 0.21842100),
}
"""Loss after three short epochs, measured on one older processor."""


@pytest.mark.slow
@pytest.mark.parametrize(("agent", "preset"), BEFORE)
def test_losses_are_what_they_were(agent, preset):
    settings, loss = BEFORE[agent, preset]
    run = train(changed(system(agent, 0.8, "paper", 1, preset), SHORT | settings))
    assert run.log[-1]["prediction_loss"] == pytest.approx(loss, rel=1e-3)
