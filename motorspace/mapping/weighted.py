"""Linear equations of known uncertainty, many of them wrong, and what most of them agree on.

Least squares with Cauchy weights, if need be from the least median of squares (Rousseeuw 1984).
"""

from typing import NamedTuple

import numpy as np
from jaxtyping import Float, Int

REWEIGHTED = 20
TRIES = 300
"""First fits, to as few groups of equations each as determine one."""
CUT = 2.0
"""Squared errors that count half, in medians."""


class Equations(NamedTuple):
    """Linear equations in groups, each with an inverse covariance.

    Args:
        known: [E, A, U].
        wanted: [E, A].
        information: Of each group, [E, A, A].
    """

    known: Float[np.ndarray, "E A U"]
    wanted: Float[np.ndarray, "E A"]
    information: Float[np.ndarray, "E A A"]

    def fitted(self, start: Float[np.ndarray, " U"] | None = None) -> Float[np.ndarray, " U"]:
        """The unknowns by reweighted least squares, from a start or from equal weights."""
        every, num = np.arange(len(self.wanted)), len(self.wanted)
        found = self._solved(every, np.ones(num)) if start is None else start
        for _ in range(REWEIGHTED):
            found = self._solved(every, self.weights(found))
        return found

    def by_few(self) -> Float[np.ndarray, " U"]:
        """Of fits to a few groups each, the one that most groups agree with: many may be wrong.

        Groups that say little agree with any: they must not be most of all.
        """
        num, size, unknown = self.known.shape
        few = min(num, -(-unknown // size) + 1)
        random = np.random.default_rng(0)
        tried = [random.choice(num, few, replace=False) for _ in range(TRIES)]
        return min((self._solved(rows, np.ones(few)) for rows in tried), key=self._typical)

    def weights(self, found: Float[np.ndarray, " U"]) -> Float[np.ndarray, " E"]:
        """How far each group is believed, from 0 to 1."""
        errors = self._errors(found)
        return np.asarray(1 / (1 + errors / (CUT * np.median(errors) + 1e-12)))

    def _solved(
        self, rows: Int[np.ndarray, " R"], weight: Float[np.ndarray, " R"]
    ) -> Float[np.ndarray, " U"]:
        known = self.known[rows]
        weighted = np.swapaxes(known, 1, 2) @ (self.information[rows] * weight[:, None, None])
        normal = np.tensordot(weighted, known, axes=((0, 2), (0, 1)))
        aim = np.tensordot(weighted, self.wanted[rows], axes=((0, 2), (0, 1)))
        return np.asarray(np.linalg.lstsq(normal, aim, rcond=None)[0])

    def _errors(self, found: Float[np.ndarray, " U"]) -> Float[np.ndarray, " E"]:
        """Squared, in standard deviations."""
        off = self.wanted - self.known @ found
        return np.asarray(np.einsum("ea,eab,eb->e", off, self.information, off))

    def _typical(self, found: Float[np.ndarray, " U"]) -> float:
        return float(np.median(self._errors(found)))
