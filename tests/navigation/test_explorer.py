"""The upper row of exploration, and ways to many places at once."""

import jax
import jax.numpy as jnp
import numpy as np
import pytest

from motorspace.navigation.actors import Chance
from motorspace.navigation.arenas import Size, arena_of
from motorspace.navigation.config import NavigationConfig
from motorspace.navigation.evaluation import evaluate_actor
from motorspace.navigation.explorer import explorer
from motorspace.navigation.planner import way_length, way_lengths
from motorspace.navigation.tasks import CELLS


@pytest.mark.slow
def test_with_the_map_in_hand_a_new_cell_is_entered_every_other_command():
    config = NavigationConfig("explore", num_layouts=2, max_steps=20)
    arena = arena_of(config, None, "train", Size(4, 1), key=jax.random.key(0))
    knows, key = explorer(arena), jax.random.key(1)
    mine, chance = (evaluate_actor(arena, actor, key=key)["cells"] for actor in (knows, Chance()))
    assert mine > 8 > chance
    walls, corners = arena.setting.walls, arena.setting.corners
    place = arena.problems.start.x[0], arena.problems.start.y[0]
    ways = way_lengths(walls, corners, knows.from_corners, (knows.x, knows.y), place)
    one = 3 * CELLS + 5
    goal = knows.x[one], knows.y[one]
    np.testing.assert_allclose((goal[0][0], goal[1][0]), (11.0, 7.0))
    alone = way_length(walls, corners, knows.from_corners[one], goal, place)
    np.testing.assert_allclose(ways[one], alone, rtol=1e-5)
    assert jnp.isfinite(alone).all()
