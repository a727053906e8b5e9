"""Transitions that are drawn from a recording are transitions of it, short ones first."""

from dataclasses import replace

import jax
import jax.numpy as jnp
import numpy as np
import pytest

from motorspace import Scenario, UserError, draw_windows, record

WALK = record(Scenario("paper"), num_steps=60, key=jax.random.key(0))
WALK = replace(WALK, usable=np.arange(60) % 20 != 7)


def scans_of(experience):
    """The scans that transitions begin and end at, found by their readings."""
    return [
        np.abs(WALK.sensors[:, None] - np.asarray(views)).max(axis=-1).argmin(axis=0)
        for views in (experience.sensors, experience.later_sensors)
    ]


def test_they_are_transitions_of_the_recording():
    found = draw_windows(WALK, num=400, horizon=4, min_horizon=1)(jax.random.key(1), jnp.int32(0))
    first, last = scans_of(found)
    np.testing.assert_array_equal(last - first, found.num_steps)
    for start, length, motors in zip(first, found.num_steps, found.motors, strict=True):
        expected = np.zeros((4, 2))
        expected[:length] = WALK.increments[start : start + int(length)]
        np.testing.assert_allclose(motors, expected, atol=1e-6)
        assert WALK.usable[start : start + int(length)].all()
    assert set(np.asarray(found.num_steps).tolist()) == {1, 2, 3, 4}
    # Every place of the walk is drawn, those that no transition may begin at aside.
    assert len(set(first.tolist())) > 45


def test_sequences_grow_with_the_epochs():
    source = draw_windows(WALK, num=200, horizon=3, curriculum_epochs=9)
    lengths = [
        set(np.asarray(source(jax.random.key(2), jnp.int32(epoch)).num_steps).tolist())
        for epoch in (0, 3, 8, 9)
    ]
    assert lengths == [{1}, {1, 2}, {1, 2, 3}, {3}]


@pytest.mark.parametrize("sizes", [{"num": 0}, {"horizon": 0}, {"horizon": 99}])
def test_what_cannot_be_drawn_is_refused(sizes):
    with pytest.raises(UserError):
        draw_windows(WALK, **({"num": 5, "horizon": 2} | sizes))
