"""What comes with the package acts at once."""

import jax
import numpy as np
import pytest

from motorspace._errors import UserError
from motorspace.control.trials import displacement_goals, displacement_trials
from motorspace.navigation.pretrained import _home, load_pretrained, pretrained_names


@pytest.mark.parametrize("name", pretrained_names())
def test_a_pretrained_controller_reaches_goals(name):
    found = load_pretrained(name)
    agent = found.run.config.data.scenario().agent
    goals = displacement_goals(agent, 200, found.controller.horizon, key=jax.random.key(1))
    trials = displacement_trials(found.controller, agent, goals, "hybrid", key=jax.random.key(2))
    assert trials.success() > 0.95
    assert "## Limits" in found.card and name in found.card


def test_there_are_some_and_all_are_small():
    assert {"forward-0.4pi", "holonomic-0.4pi"} <= set(pretrained_names())
    for name in pretrained_names():
        assert sum(path.stat().st_size for path in (_home() / name).iterdir()) < 1_000_000


def test_the_nearest_name_is_named():
    with pytest.raises(UserError, match=r"no pretrained network 'forward-04pi'.*'forward-0.4pi'"):
        load_pretrained("forward-04pi")
    with pytest.raises(UserError, match=r"choose one of forward-0\.4pi"):
        load_pretrained(str(np.nan))
