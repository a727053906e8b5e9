"""A roadmap: remembered places, joined where the map shows no wall between them."""

import numpy as np
import scipy.sparse as sparse
from jaxtyping import Float
from scipy.sparse.csgraph import dijkstra
from scipy.spatial import cKDTree

from motorspace.mapping.walls import WallMap, clearance

SPACING, LINK = 0.04, 0.12
"""Between places that are kept, and between those that are joined; shares of the reach."""
MARGIN = 0.008
"""How far from the end of a straight way a wall has to be, share of the reach."""
IN_SIGHT = 8
"""Kept places near another place among which a way from there begins."""
UNSEEN = 10.0
"""By how much longer a way is taken to be that begins at a place out of sight."""


class Roadmap:
    """Lengths of ways between places, around the walls of a map.

    Args:
        walls: The map.
        eyes: Where the agent has been, [3, S].
    """

    def __init__(self, walls: WallMap, eyes: Float[np.ndarray, "3 S"]) -> None:
        cells = np.round(eyes[:2] / (SPACING * walls.reach)).astype(np.int64)
        self.walls = walls
        self.stops = eyes[:2, np.unique(cells, axis=1, return_index=True)[1]]
        self.tree = cKDTree(self.stops.T)
        first, second = self.tree.query_pairs(LINK * walls.reach, output_type="ndarray").T
        starts, ends = self.stops[:, first], self.stops[:, second]
        # A wall may show from one of its ends only.
        room = np.minimum(clearance(walls, starts, ends), clearance(walls, ends, starts))
        free = room > MARGIN * walls.reach
        length = np.hypot(*(ends - starts))[free]
        num = self.stops.shape[1]
        self.graph = sparse.csr_matrix((length, (first[free], second[free])), shape=(num, num))

    def lengths(self, goal: Float[np.ndarray, "2"]) -> Float[np.ndarray, " N"]:
        """How long the way is to a place, from each of the N kept ones; infinite without any."""
        near, gap = self._begun(goal[:, None])
        from_each = dijkstra(self.graph, directed=False, indices=near[0])
        return np.asarray((from_each + gap[0][:, None]).min(axis=0))

    def left(
        self, places: Float[np.ndarray, "2 P"], lengths: Float[np.ndarray, " N"]
    ) -> Float[np.ndarray, " P"]:
        """How long the way is from other places, by the `lengths` of those kept."""
        near, gap = self._begun(places)
        return np.asarray((gap + lengths[near]).min(axis=1))

    def roughly_left(
        self, places: Float[np.ndarray, "2 P"], lengths: Float[np.ndarray, " N"]
    ) -> Float[np.ndarray, " P"]:
        """The same by the nearest kept place, whether or not it is in sight."""
        gap, near = self.tree.query(places.T)
        return np.asarray(gap + lengths[near])

    def _begun(
        self, places: Float[np.ndarray, "2 P"]
    ) -> tuple[np.ndarray, Float[np.ndarray, "P k"]]:
        """Kept places near these, and how far they are."""
        gap, near = self.tree.query(places.T, k=range(1, min(IN_SIGHT, self.tree.n) + 1))
        ends = self.stops[:, near]
        starts = np.broadcast_to(places[:, :, None], ends.shape)
        seen = clearance(self.walls, starts, ends) > 0
        return near, gap + np.where(seen, 0.0, UNSEEN * self.walls.reach)
