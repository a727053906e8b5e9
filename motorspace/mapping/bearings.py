"""Where each ray points, by votes: where the agent turns on the spot, a ray reads what another one
has read before. Nothing is assumed of the rays' order.
"""

import numpy as np
from jaxtyping import Float, Int

from motorspace._errors import UserError
from motorspace.mapping.mounting import SATURATED
from motorspace.se2 import relative

LONGEST = 60
"""Steps between two moments that are compared, at most."""
ON_THE_SPOT = 1.0
"""Moments nearer than so many median steps count as the same spot."""
WIDEST_TURN = np.pi / 2
NUM_TURNS = 181
TOLERANCE = 0.03
"""By which ratio two readings may differ that vote for one another."""
MOST_VOTES = 40
"""Votes of one turn beyond which there is nothing more to learn."""
WIDTH = np.deg2rad(3.0)
"""How wide votes are spread around the right turn."""
NUM_ANGLES = 720
ROUNDS = 40
FEWEST_PAIRS = 100
CHUNK_SIZE = 50

Votes = Float[np.ndarray, "A K K"]


def find_bearings(
    frames: Float[np.ndarray, "3 N"], sensors: Float[np.ndarray, "N K"], *, reach: float
) -> Float[np.ndarray, " K"]:
    """The rays' directions, up to one that all of them share.

    Args:
        frames: Frames of the sensors along a walk by odometry, in any unit.
        sensors: The readings there.
        reach: The largest reading.

    Returns:
        Radians, [K].

    Raises:
        UserError: Where the walk hardly turns on the spot.
    """
    first, second, turns = _turning_pairs(frames)
    if len(first) < FEWEST_PAIRS:
        raise UserError(
            f"the walk turns on the spot only {len(first)} times, which does not show where the"
            " rays point",
            remedy="give a longer walk that turns more, or the directions of another log",
        )
    agreeing, count = _votes(sensors, first, second, turns, reach)
    return _assigned(_evidence(agreeing, count))


def _turning_pairs(
    frames: Float[np.ndarray, "3 N"],
) -> tuple[Int[np.ndarray, " P"], Int[np.ndarray, " P"], Float[np.ndarray, " P"]]:
    """Moments that are at nearly the same place, and the turn between them."""
    near = ON_THE_SPOT * np.median(np.hypot(*np.diff(frames[:2], axis=1)))
    first, second, turns = [], [], []
    for gap in range(1, min(LONGEST + 1, frames.shape[1])):
        x, y, turn = relative(frames[:, :-gap], frames[:, gap:])
        rows = np.flatnonzero((np.hypot(x, y) < near) & (np.abs(turn) < WIDEST_TURN))
        first.append(rows)
        second.append(rows + gap)
        turns.append(turn[rows])
    return np.concatenate(first), np.concatenate(second), np.concatenate(turns)


def _votes(
    sensors: Float[np.ndarray, "N K"],
    first: Int[np.ndarray, " P"],
    second: Int[np.ndarray, " P"],
    turns: Float[np.ndarray, " P"],
    reach: float,
) -> tuple[Float[np.ndarray, "B K K"], Float[np.ndarray, "B K K"]]:
    """For every turn: how well each ray then reads what each other has read, and how often."""
    size = sensors.shape[1]
    met = sensors < SATURATED * reach
    size_of = np.log(np.maximum(sensors, 1e-3 * reach)).astype(np.float32)
    bins = np.floor((turns / WIDEST_TURN + 1) / 2 * NUM_TURNS).astype(int)
    agreeing, count = np.zeros((2, NUM_TURNS, size, size))
    for turn in range(NUM_TURNS):
        rows = np.flatnonzero(bins == turn)
        for part in np.array_split(rows, len(rows) // CHUNK_SIZE + 1):
            ratio = size_of[first[part]][:, :, None] - size_of[second[part]][:, None]
            both = met[first[part]][:, :, None] & met[second[part]][:, None]
            agreeing[turn] += np.sum(both / (1 + (ratio / TOLERANCE) ** 2), axis=0)
            count[turn] += both.sum(axis=0)
    # Turning back, the rays change roles.
    agreeing += np.swapaxes(agreeing[::-1], 1, 2)
    count += np.swapaxes(count[::-1], 1, 2)
    return agreeing, count


def _evidence(
    agreeing: Float[np.ndarray, "B K K"], count: Float[np.ndarray, "B K K"]
) -> Float[np.ndarray, "A K K"]:
    """For each angle that one ray may lie ahead of another: how well the votes fit.

    Each pair of rays agrees by chance, and more so near the right turn, within some degrees: the
    share of the variance over turns that such a peak explains, where turns were seen at all.
    """
    turns = (np.arange(NUM_TURNS) + 0.5) / NUM_TURNS * 2 * WIDEST_TURN - WIDEST_TURN
    weight = np.minimum(count, MOST_VOTES)
    rate = agreeing / np.maximum(count, 1)
    total = np.maximum(weight.sum(axis=0), 1)
    mean = (weight * rate).sum(axis=0) / total
    variance = (weight * (rate - mean) ** 2).sum(axis=0) / total
    angles = 2 * np.pi * np.arange(NUM_ANGLES) / NUM_ANGLES
    angles = np.where(angles > np.pi, angles - 2 * np.pi, angles)
    evidence = np.zeros((NUM_ANGLES, *mean.shape), np.float32)
    for row in map(int, np.flatnonzero(np.abs(angles) < WIDEST_TURN + 2 * WIDTH)):
        peak = 1 / (1 + ((turns - angles[row]) / WIDTH) ** 2)
        centre = np.einsum("b,bij->ij", peak, weight) / total
        size = np.einsum("b,bij->ij", peak**2, weight) - total * centre**2
        product = np.einsum("b,bij->ij", peak, weight * rate) - total * centre * mean
        explained = np.maximum(product, 0.0) ** 2 / (size + MOST_VOTES / 2)
        evidence[row] = explained / (variance + 0.01)
    evidence[:, np.arange(len(mean)), np.arange(len(mean))] = 0.0
    return evidence


def _assigned(evidence: Float[np.ndarray, "A K K"]) -> Float[np.ndarray, " K"]:
    """The angles that all evidence together supports best, ray by ray.

    Rays join one another beginning with the one that is known best; then each is moved to where
    the others want it until none moves.
    """
    num_angles, size = evidence.shape[:2]
    angles, rays = np.arange(num_angles)[:, None], np.arange(size)
    places = np.zeros(size, int)

    def wanted_by(ray: int) -> Float[np.ndarray, "K A"]:
        """What one ray, where it is, says for each place of each other one."""
        return evidence[(angles - places[ray]) % num_angles, rays, ray].T

    start = int(evidence.max(axis=0).sum(axis=1).argmax())
    scores, joined = wanted_by(start).copy(), rays == start
    while not joined.all():
        ray = int(np.where(joined, -1.0, scores.max(axis=1)).argmax())
        places[ray], joined[ray] = scores[ray].argmax(), True
        scores += wanted_by(ray)
    for _ in range(ROUNDS):
        before = places.copy()
        for ray in rays.tolist():
            scores -= wanted_by(ray)
            places[ray] = scores[ray].argmax()
            scores += wanted_by(ray)
        if (places == before).all():
            break
    return unwrapped(2 * np.pi * places / num_angles)


def unwrapped(angles: Float[np.ndarray, " K"]) -> Float[np.ndarray, " K"]:
    """The same directions, counted so that no two neighbours in view are a full turn apart."""
    ordered = np.sort(np.mod(angles, 2 * np.pi))
    gaps = np.diff(np.append(ordered, ordered[0] + 2 * np.pi))
    start = ordered[(int(np.argmax(gaps)) + 1) % len(ordered)]
    return np.asarray(start + np.mod(angles - start, 2 * np.pi))


def find_unit(
    frames: Float[np.ndarray, "3 N"],
    sensors: Float[np.ndarray, "N K"],
    bearings: Float[np.ndarray, " K"],
    *,
    reach: float,
) -> tuple[float, float]:
    """How many of the readings' units one unit of odometry is, and which way bearings begin.

    Moving towards a wall by d shortens a reading by d, whatever way the wall stands: on average
    over walls readings change by the motion against their rays.

    Args:
        frames: Frames of the sensors along a walk by odometry, in any unit.
        sensors: The readings there.
        bearings: The rays' directions, up to one that all of them share.
        reach: The largest reading.

    Returns:
        The unit, and the direction among the bearings that is straight ahead, radians.
    """
    order = np.argsort(unwrapped(bearings))
    angles, read = unwrapped(bearings)[order], sensors[:, order]
    x, y, turn = relative(frames[:, :-1], frames[:, 1:])
    before, after = read[:-1], np.empty_like(read[1:])
    # What the second scan reads into the first one's directions.
    for row, angle in enumerate(turn):
        after[row] = np.interp(angles - angle, angles, read[row + 1], period=2 * np.pi)
    change = after - before
    usable = np.maximum(before, after) < SATURATED * reach
    source = angles[0] + np.mod(angles - angles[0] - turn[:, None], 2 * np.pi)
    usable &= source <= angles[-1]
    towards = np.exp(-1j * angles)[None] * (x + 1j * y)[:, None]
    known = -np.stack([towards.real[usable], -towards.imag[usable]], axis=-1)
    change, weight = change[usable], np.ones(int(usable.sum()))
    for _ in range(ROUNDS):
        weighted = known * weight[:, None]
        along, across = np.linalg.solve(weighted.T @ known, weighted.T @ change)
        off = change - known @ np.array([along, across])
        weight = 1 / (1 + (off / (0.01 * reach)) ** 2)
    return float(np.hypot(along, across)), float(np.arctan2(across, along))
