"""Odometry and rays made exact: along every stretch of a walk walls have to be thin.

An encoder's matrices are off by some thousandths with every command, which adds up to rooms that
do not meet after a few hundred. Where the rays of a walk end is where walls are; seen from other
places the same walls have to be there again. Gauss-Newton steps on how far the ends are off the
lines that they form lead to corrections of the odometry, a function of the command alone, and to
the directions of the rays (bundle adjustment without poses as unknowns).
"""

from typing import NamedTuple

import numpy as np
from jaxtyping import Float, Int

from motorspace.mapping.lines import Lines, fit_lines
from motorspace.mapping.mounting import SATURATED, Mounting
from motorspace.mapping.odometry import Odometry, features
from motorspace.mapping.walks import Walk
from motorspace.se2 import adjoint, compose, relative


class Level(NamedTuple):
    """Steps on windows of one length, in shares of the sensors' reach."""

    length: int
    most: int
    """Windows."""
    cell: float
    tolerances: tuple[float, ...]
    """How far off a point is that counts a quarter, one for each step."""


LEVELS = (
    Level(12, 1000, 0.1, (0.04, 0.03, 0.02, 0.02, 0.01, 0.01, 0.01, 0.005, 0.005)),
    Level(40, 400, 0.07, (0.02, 0.02, 0.01, 0.01, 0.005, 0.005)),
    Level(120, 200, 0.06, (0.02, 0.01, 0.005, 0.005)),
    *(
        Level(length, 48_000 // length, cell, tolerances)
        for length in (500, 2_900)
        for cell, tolerances in (
            (0.12, (0.03, 0.02)),
            (0.06, (0.015, 0.01)),
            (0.04, (0.005, 0.003)),
        )
    ),
)
"""From short windows, where little has added up, to long ones, which show the least bias."""
THIN = 4.0
MOST_ENDS = 60_000
"""Ends of rays that a step is solved for: many unknowns make more of them slow."""
STIFFNESS = 1.0
"""Weight of the squared corrections; what sensors tell outweighs it by far."""


class Calibrated(NamedTuple):
    """Odometry and rays that belong together."""

    odometry: Odometry
    mounting: Mounting

    def frames(self, walk: Walk) -> Float[np.ndarray, "3 S n"]:
        """The sensors' frames along walks, which begin at rest."""
        bodies = self.odometry.bodies(walk.motors)
        rest = np.zeros_like(walk.motors[:1])
        gazes = self.odometry.gazes(np.concatenate([rest, walk.motors]))
        return np.asarray(compose(bodies, gazes))

    def eyes(self, walk: Walk) -> Float[np.ndarray, "3 S n"]:
        """Where the rays begin along walks, from the first frame of the sensors."""
        return self.mounting.eyes(self.frames(walk))

    def moved(self, motors: Float[np.ndarray, "T n M"]) -> Float[np.ndarray, "3 n"]:
        """How the rays' origin and direction are displaced by sequences that begin at rest."""
        return self.mounting.seen(self.odometry.displacements(motors))

    def at_rest(
        self, eyes: Float[np.ndarray, "3 n"], motor: Float[np.ndarray, " M"]
    ) -> Float[np.ndarray, "3 n"]:
        """Where the rays would begin at rest, when they begin here after this command."""
        gazes = self.odometry.gazes(np.stack([motor, np.zeros_like(motor)]))
        moved = self.mounting.seen(relative(gazes[:, :1], gazes[:, 1:]))
        return np.asarray(compose(eyes, np.repeat(moved, eyes.shape[1], axis=1)))


def calibrate_on(walk: Walk, rough: Calibrated, levels: tuple[Level, ...] = LEVELS) -> Calibrated:
    """The odometry and the rays that make the walls thin which walks have seen."""
    for level in levels:
        # A window begins amid a walk: the command before it has set the gaze.
        pieces = walk.windows(level.length + 1, level.most)
        for tolerance in level.tolerances:
            reach = rough.mounting.reach
            rough = _step(pieces, rough, level.cell * reach, tolerance * reach)
    return rough


class _Ends(NamedTuple):
    """Ends of rays that met something: their place, and which window, time and ray they are of."""

    points: Float[np.ndarray, "2 P"]
    time: Int[np.ndarray, " P"]
    window: Int[np.ndarray, " P"]
    ray: Int[np.ndarray, " P"]


def _step(walk: Walk, now: Calibrated, cell: float, tolerance: float) -> Calibrated:
    """One Gauss-Newton step; every column of the walk is a window of its own."""
    odometry, mounting = now
    gazes = odometry.gazes(walk.motors)
    bodies = odometry.bodies(walk.motors[1:])
    frames = np.asarray(compose(bodies, gazes))
    sensors = walk.sensors[1:]
    met = sensors < SATURATED * mounting.reach
    ends = _Ends(mounting.ends(mounting.eyes(frames), sensors)[:, met], *np.nonzero(met))
    lines = fit_lines(ends.points, ends.window, cell=cell, tolerance=tolerance)
    used = np.flatnonzero(lines.usable(THIN))
    cells = lines.cells[used]
    # Whole cells: what counts is how the ends in one of them differ.
    used = used[cells % -(-len(used) // MOST_ENDS) == 0]
    used = used[np.argsort(lines.cells[used], kind="stable")]
    ends = _Ends(ends.points[:, used], *(part[used] for part in ends[1:]))
    moved = _moved_by(walk.motors, bodies, frames, has_gaze=odometry.has_gaze)
    normal = lines.normal[:, lines.cells[used]]
    jacobian = _jacobian(ends, normal, moved, frames, sensors[met][used], mounting)
    unknowns = _solved(jacobian, lines, used, _present(odometry, jacobian.shape[1]))
    return _corrected(now, unknowns)


def _moved_by(
    motors: Float[np.ndarray, "S n M"],
    bodies: Float[np.ndarray, "3 S n"],
    frames: Float[np.ndarray, "3 S n"],
    *,
    has_gaze: bool,
) -> Float[np.ndarray, "S n 3 Q"]:
    """How the frames move, as twists about the window's origin, with each correction.

    A correction turns all that follows it: the sum of Ad(B_t) over the commands so far.
    """
    known = features(motors)
    steps = np.einsum("tnij,tnf->tnifj", adjoint(bodies[:, 1:]), known[1:])
    steps = np.concatenate([np.zeros_like(steps[:1]), np.cumsum(steps, axis=0)])
    shape = (*steps.shape[:3], -1)
    if not has_gaze:
        return steps.reshape(shape)
    gazes = np.einsum("tnij,tnf->tnifj", adjoint(frames), known)
    return np.concatenate([steps.reshape(shape), gazes.reshape(shape)], axis=-1)


def _jacobian(
    ends: _Ends,
    normal: Float[np.ndarray, "2 P"],
    moved: Float[np.ndarray, "S n 3 Q"],
    frames: Float[np.ndarray, "3 S n"],
    readings: Float[np.ndarray, " P"],
    mounting: Mounting,
) -> Float[np.ndarray, "P U"]:
    """How far each end moves across its line with each unknown: corrections, origin, angles."""
    (x, y), (across_x, across_y) = ends.points, normal
    twist = np.stack([across_x, across_y, across_y * x - across_x * y], axis=-1)
    of_corrections = np.einsum("pi,piq->pq", twist, moved[ends.time, ends.window])
    angle = frames[2, ends.time, ends.window]
    cos, sin = np.cos(angle), np.sin(angle)
    of_origin = [across_x * cos + across_y * sin, across_y * cos - across_x * sin]
    ray = angle + mounting.angles[ends.ray]
    of_angles = np.zeros((len(x), len(mounting.angles)))
    sideways = readings * (across_y * np.cos(ray) - across_x * np.sin(ray))
    of_angles[np.arange(len(x)), ends.ray] = sideways
    return np.concatenate([of_corrections, np.stack(of_origin, axis=-1), of_angles], axis=-1)


def _present(odometry: Odometry, num: int) -> Float[np.ndarray, " U"]:
    """The unknowns' present values, as far as they are held small."""
    twists = [odometry.step_twist, *[odometry.gaze_twist] * odometry.has_gaze]
    held = np.concatenate([twist.reshape(-1) for twist in twists])
    return np.concatenate([held, np.full(num - len(held), np.nan)])


def _solved(
    jacobian: Float[np.ndarray, "P U"],
    lines: Lines,
    used: Int[np.ndarray, " P"],
    present: Float[np.ndarray, " U"],
) -> Float[np.ndarray, " U"]:
    """The step. The lines move with their points: only what differs within a cell counts."""
    cells, weight, off = lines.cells[used], lines.weight[used], lines.off[used]
    firsts = np.flatnonzero(np.append(True, cells[1:] != cells[:-1]))
    rows = np.repeat(np.arange(len(firsts)), np.diff(np.append(firsts, len(cells))))
    total = np.add.reduceat(weight, firsts)

    def centred(values: np.ndarray) -> np.ndarray:
        summed = np.add.reduceat((values.T * weight).T, firsts, axis=0)
        return np.asarray(values - (summed.T / total).T[rows])

    jacobian, off = centred(jacobian), centred(off)
    normal = jacobian.T @ (jacobian * weight[:, None])
    downhill = jacobian.T @ (off * weight)
    held = np.isfinite(present)
    # Turning all rays and the body's frame against them changes nothing: their mean stays.
    angles = np.zeros(len(present))
    angles[np.count_nonzero(held) + 2 :] = 1.0
    normal += 1e3 * np.outer(angles, angles) + np.diag(np.where(held, STIFFNESS, 1e-3))
    return -np.linalg.solve(normal, downhill + STIFFNESS * np.where(held, present, 0.0))


def _corrected(now: Calibrated, unknowns: Float[np.ndarray, " U"]) -> Calibrated:
    odometry, mounting = now
    size = odometry.step_twist.size
    step, rest = unknowns[:size].reshape(-1, 3), unknowns[size:]
    odometry = odometry._replace(step_twist=odometry.step_twist + step)
    if odometry.has_gaze:
        gaze, rest = rest[:size].reshape(-1, 3), rest[size:]
        odometry = odometry._replace(gaze_twist=odometry.gaze_twist + gaze)
    mounting = mounting._replace(
        origin=mounting.origin + rest[:2], angles=mounting.angles + rest[2:]
    )
    return Calibrated(odometry, mounting)
