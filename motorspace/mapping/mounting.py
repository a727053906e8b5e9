"""Where each sensor points: how its reading changes with the agent's motion."""

from typing import NamedTuple

import numpy as np
from jaxtyping import Float

from motorspace._errors import UserError
from motorspace.se2 import Frame, compose, inverse, relative

GAPS = (2, 3, 4, 5, 6, 7, 8)
"""Steps between two readings that are compared: one alone leads a body ahead only."""
REACH, TURN = 0.8, 0.2
"""Displacements that count as small, encoder units and radians."""
OUTLIER = 0.15
"""What a reading is off by, world units, when the ray meets another wall than before."""
ROUNDS = 30
UNEVEN = 0.3
"""How much the readings' units may differ, relative to their median."""
SATURATED = 0.999
"""Share of the range from which on a reading says that nothing was met."""


class Mounting(NamedTuple):
    """The sensors as rays from one point of the body: learned, not given.

    Args:
        angles: Direction of each ray in the frame of the sensors, [K], radians.
        origin: Where the rays begin in that frame, [2], in the readings' unit.
        reach: The reading that says that nothing was met.
    """

    angles: Float[np.ndarray, " K"]
    origin: Float[np.ndarray, "2"]
    reach: float

    def eyes(self, frames: Frame) -> Float[np.ndarray, "3 *batch"]:
        """The rays' origin and direction of reference at these frames of the sensors."""
        return np.asarray(compose(frames, self._offset(frames)))

    def seen(self, displacements: Frame) -> Float[np.ndarray, "3 *batch"]:
        """How the rays' origin is displaced where the frame of the sensors is."""
        offset = self._offset(displacements)
        return np.asarray(compose(compose(inverse(offset), displacements), offset))

    def unseen(self, displacements: Frame) -> Float[np.ndarray, "3 *batch"]:
        """How the frame of the sensors is displaced where the rays' origin is."""
        offset = self._offset(displacements)
        return np.asarray(compose(compose(offset, displacements), inverse(offset)))

    def ends(
        self, eyes: Frame, sensors: Float[np.ndarray, "*batch K"]
    ) -> Float[np.ndarray, "2 *batch K"]:
        """Where the rays end."""
        x, y, angle = (np.asarray(part)[..., None] for part in eyes)
        turned = angle + self.angles
        return np.stack([x + sensors * np.cos(turned), y + sensors * np.sin(turned)])

    def _offset(self, frames: Frame) -> Float[np.ndarray, "3 *batch"]:
        offset = np.append(self.origin, 0.0)
        return np.multiply.outer(offset, np.ones_like(frames[0]))


def find_mounting(
    frames: Float[np.ndarray, "3 S n"],
    sensors: Float[np.ndarray, "S n K"],
    *,
    point: Float[np.ndarray, "2"],
    reach: float,
) -> tuple[Mounting, float]:
    """The rays' directions, and how many of the readings' units are one unit of the frames.

    Moving towards a wall by d shortens a reading by d, whatever way the wall stands: on average
    over walls the gradient of each reading points against its ray. The moves have to be as wide
    in all directions: who keeps his direction hardly ever moves sideways.

    Args:
        frames: Frames of the sensors along slow walks.
        sensors: The readings there, raw units.
        point: Where the rays begin in those frames, approximately.
        reach: The largest reading.

    Raises:
        UserError: For readings that do not behave as distances along rays.
    """
    moved, before, after = _small_moves(frames, sensors)
    x, y, turn = moved
    known = np.stack([x, y, np.cos(turn) - 1, np.sin(turn), np.ones_like(x)], axis=-1)
    gradients = np.array(
        [_robust(known, *pair, reach) for pair in zip(before.T, after.T, strict=True)]
    )
    sizes = np.linalg.norm(gradients, axis=1)
    unit = max(float(np.median(sizes)), 1e-9)
    uneven = ~(np.abs(sizes / unit - 1) < UNEVEN)
    if uneven.any():
        odd = ", ".join(str(ray) for ray in np.flatnonzero(uneven))
        raise UserError(
            f"the readings {odd} do not shorten as distances do when the agent approaches a wall",
            remedy="use the sensor range_fan without the head's angle, and a run that is trained",
        )
    angles = np.unwrap(np.arctan2(-gradients[:, 1], -gradients[:, 0]))
    return Mounting(angles, point * unit, reach), unit


def _small_moves(
    frames: Float[np.ndarray, "3 S n"], sensors: Float[np.ndarray, "S n K"]
) -> tuple[Float[np.ndarray, "3 P"], Float[np.ndarray, "P K"], Float[np.ndarray, "P K"]]:
    moves, before, after = [], [], []
    for gap in GAPS:
        moved = relative(frames[:, :-gap], frames[:, gap:])
        small = (np.hypot(moved[0], moved[1]) < REACH) & (np.abs(moved[2]) < TURN)
        moves.append(moved[:, small])
        before.append(sensors[:-gap][small])
        after.append(sensors[gap:][small])
    return np.concatenate(moves, axis=1), np.concatenate(before), np.concatenate(after)


def _robust(
    known: Float[np.ndarray, "P 5"],
    before: Float[np.ndarray, " P"],
    after: Float[np.ndarray, " P"],
    reach: float,
) -> Float[np.ndarray, "2"]:
    """The gradient of one reading, by least squares that are reweighted (Cauchy)."""
    met = np.maximum(before, after) < SATURATED * reach
    known, change = known[met], (after - before)[met]
    weight = np.ones(len(change))
    for _ in range(ROUNDS):
        weighted = known * weight[:, None]
        fitted = np.linalg.lstsq(weighted.T @ known, weighted.T @ change, rcond=None)[0]
        weight = 1 / (1 + ((change - known @ fitted) / OUTLIER) ** 2)
    return fitted[:2]


def unwrapped(angles: Float[np.ndarray, " K"]) -> Float[np.ndarray, " K"]:
    """The same directions, counted so that no two neighbours in view are a full turn apart."""
    ordered = np.sort(np.mod(angles, 2 * np.pi))
    gaps = np.diff(np.append(ordered, ordered[0] + 2 * np.pi))
    start = ordered[(int(np.argmax(gaps)) + 1) % len(ordered)]
    return np.asarray(start + np.mod(angles - start, 2 * np.pi))
