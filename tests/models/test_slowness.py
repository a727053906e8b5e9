"""Why slow codes are codes of displacement: the slowest functions of a walk's end, computed."""

from collections import defaultdict

import jax.numpy as jnp
import numpy as np
import scipy.linalg

from motorspace._types import Pose
from motorspace.worlds.agents import LatticeAgent

HORIZON = 5
COMMANDS = jnp.eye(6)


def transitions():
    """P(displacement before, after the last command) over random sequences of 1 to 5 commands."""
    ends, chance = {(0.0, 0.0, 0.0): 1.0}, defaultdict(float)
    for _ in range(HORIZON):
        before = Pose(
            *(jnp.repeat(jnp.array(c), 6) for c in zip(*ends, strict=True)),
            jnp.zeros(6 * len(ends)),
        )
        (after,) = LatticeAgent().move(before, jnp.tile(COMMANDS, (len(ends), 1)).T)
        quarters = np.mod(np.round(np.asarray(after.heading) * 2 / np.pi), 4) * np.pi / 2
        places = np.stack([after.x, after.y, quarters], axis=1)
        starts, reached = list(ends), defaultdict(float)
        for row, place in enumerate(map(tuple, places.tolist())):
            start = starts[row // 6]
            reached[place] += ends[start] / 6
            chance[start, place] += ends[start] / 6 / HORIZON
        ends = dict(reached)
    return chance


def test_the_two_slowest_functions_of_a_walk_are_its_displacements():
    chance = transitions()
    states = sorted({state for pair in chance for state in pair})
    number = {state: i for i, state in enumerate(states)}
    ends, moved = np.zeros(len(states)), np.zeros((len(states), len(states)))
    for (before, after), p in chance.items():
        i, j = number[before], number[after]
        ends[j] += p
        moved[[i, j], [i, j]] += p
        moved[[i, j], [j, i]] -= p
    varies = np.diag(ends) - np.outer(ends, ends)
    slowness, functions = scipy.linalg.eigh(varies, moved + 1e-6 * np.eye(len(states)))
    places = np.array(states)

    def r2(function, target):
        a, b = (v - ends @ v for v in (function, target))
        return (ends @ (a * b)) ** 2 / (ends @ a**2 * (ends @ b**2))

    lateral, longitudinal = functions[:, -1], functions[:, -2]
    assert r2(lateral, places[:, 1]) > 0.94 and r2(longitudinal, places[:, 0]) > 0.9
    # No other function comes near: the third varies a fifth less for each step.
    assert slowness[-3] < 0.8 * slowness[-2]
