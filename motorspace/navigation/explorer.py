"""The upper row of exploration: one who knows the map enters the nearest new cell, again and again.

That is greedy, so a better order may exist.
"""

import equinox as eqx
import jax
import jax.numpy as jnp
from jaxtyping import Array, Float

from motorspace._types import Key
from motorspace.navigation.actors import AbstractActor, Actions, best_command
from motorspace.navigation.arena import Arena, State
from motorspace.navigation.planner import next_stop, way_lengths, ways_to
from motorspace.navigation.policies import Hiddens
from motorspace.navigation.tasks import cell_centres

Cells = Float[Array, "C N"]


class Explorer(AbstractActor):
    """Heads for the cell that it has not entered and that the shortest way leads to."""

    x: Cells
    """The middle of each cell of each agent's world."""
    y: Cells
    from_corners: Float[Array, "C V N"]
    """The shortest way to it from every point where ways bend."""

    def __call__(
        self, arena: Arena, state: State, hidden: Hiddens, *, key: Key
    ) -> tuple[Hiddens, Actions]:
        walls, corners = arena.setting.walls, arena.setting.corners
        place = state.pose.x, state.pose.y
        ways = way_lengths(walls, corners, self.from_corners, (self.x, self.y), place)
        nearest = jnp.argmin(jnp.where(state.seen, jnp.inf, ways), axis=0)[None]
        x, y = (jnp.take_along_axis(cells, nearest, axis=0)[0] for cells in (self.x, self.y))
        to_goal = jnp.take_along_axis(self.from_corners, nearest[None], axis=0)[0]
        stop = next_stop(walls, corners, to_goal, (x, y), place)
        return hidden, best_command(arena, state, stop, key=key)


@eqx.filter_jit
def explorer(arena: Arena) -> Explorer:
    """Returns who explores an arena with the map in hand."""
    walls, corners = arena.setting.walls, arena.setting.corners
    x, y = cell_centres(arena.scenario)
    from_corners = jax.lax.map(lambda cell: ways_to(walls, corners, (cell[0], cell[1])), (x, y))
    return Explorer(x, y, from_corners)
