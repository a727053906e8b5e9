"""The judge: what an agent will sense after sequences with these codes, where it is now."""

from dataclasses import dataclass

import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Bool, Float

from motorspace._errors import UserError
from motorspace._types import Key
from motorspace.judge.codes import CodeBook, learn_codes
from motorspace.judge.places import Hypotheses, Places
from motorspace.mapping.calibration import Calibrated, calibrate_on
from motorspace.mapping.mounting import SATURATED, Mounting, find_mounting
from motorspace.mapping.odometry import distilled, random_commands
from motorspace.mapping.smoothing import smoothed
from motorspace.mapping.walks import Manner, Walk, joined, walk
from motorspace.mapping.walls import WallMap, map_walls
from motorspace.se2 import compose, relative
from motorspace.training.data import simulated
from motorspace.training.run import Run

NUM_WALKS, NUM_STEPS = 8, 3_000
"""Walks of each kind that a body is calibrated on."""
NUM_EXPLORED = 15_000
"""Steps of the walk that a layout is learned from."""
OUTLIER = 0.01
"""Of the likelihood: what is off by more counts less, share of the reach."""
CHUNK_SIZE, FEW = 4_096, 256
"""Pairs of a code and a hypothesis that are judged at once: of many, of few."""
HIDDEN = 0.2
"""How likely a sequence that was possible ends where a wall hides from view, relatively."""
BEHIND, APART = 0.01, 0.002
"""Ends that are at most this far behind a wall are put before it; shares of the reach."""


@dataclass(frozen=True)
class Calibration:
    """What an agent has learned of its own body; it holds in every layout.

    Attributes:
        body: Odometry of its commands, and where its rays point.
        codes: From codes to displacements.
    """

    body: Calibrated
    codes: CodeBook


def calibrate(run: Run, *, key: Key) -> Calibration:
    """Learn how a run's codes move its sensors, from walks without a pose or a displacement.

    Args:
        run: A run whose codes are products of 3 x 3 matrices (preset best), in a world of walls
            seen by distances.
        key: Randomness of the walks.

    Returns:
        What holds for this encoder and body in every layout.

    Raises:
        UserError: For another encoder, and readings that are no distances.
    """
    scenario = simulated(run.config.data).scenario()
    *keys, command_key, code_key = jax.random.split(key, 5)
    manners: tuple[Manner, ...] = ("slow", "random", "straight")
    slow, *walks = (
        walk(scenario, num_steps=NUM_STEPS, num_walks=NUM_WALKS, manner=manner, key=walk_key)
        for manner, walk_key in zip(manners, keys, strict=True)
    )
    learned = distilled(run, random_commands(run, key=command_key))
    nowhere = Mounting(np.zeros(0), np.zeros(2), 0.0)
    frames = Calibrated(learned.odometry, nowhere).frames(slow)
    reach = float(max(run.model.scaling.sensors))
    mounting, unit = find_mounting(frames, slow.sensors, point=learned.point, reach=reach)
    # Random commands show what each does; long straight ways show the least bias.
    rough = Calibrated(learned.odometry.in_unit(unit), mounting)
    body = calibrate_on(joined(*walks), rough)
    return Calibration(body, learn_codes(run, body, key=code_key))


Readings = Float[Array | np.ndarray, " K"]
"""What is sensed at one moment, raw units."""


class Judge:
    """Knows a layout from one walk, and what codes do from the body's calibration.

    Args:
        calibration: Of the body.
        walked: One walk through the layout; a longer one replaces it.

    Example:
        >>> judge = Judge(calibrate(run, key=key), walk(scenario, num_steps=2000, key=key))
        ... # doctest: +SKIP
        >>> judge.predict(sensors, run.encode(motors))  # doctest: +SKIP
    """

    def __init__(self, calibration: Calibration, walked: Walk) -> None:
        if not _met(calibration.body.mounting, walked.sensors[:, 0]).any():
            raise UserError(
                "no ray has met a wall on this walk", remedy="walk farther, or sense farther"
            )
        eyes = calibration.body.eyes(walked)[..., 0]
        eyes = smoothed(eyes, walked.sensors[:, 0], calibration.body.mounting)
        self._remember(calibration, eyes, walked.sensors[:, 0])

    @classmethod
    def remembering(
        cls,
        calibration: Calibration,
        eyes: Float[np.ndarray, "3 S"],
        sensors: Float[np.ndarray, "S K"],
    ) -> "Judge":
        """The judge that knows what was sensed where: `eyes` are where the rays began."""
        judge = cls.__new__(cls)
        judge._remember(calibration, eyes, sensors)
        return judge

    def _remember(
        self,
        calibration: Calibration,
        eyes: Float[np.ndarray, "3 S"],
        sensors: Float[np.ndarray, "S K"],
    ) -> None:
        self.calibration, self.eyes, self.sensors = calibration, eyes, sensors
        mounting = calibration.body.mounting
        met = _met(mounting, sensors)
        self.walls = map_walls(mounting.ends(eyes, sensors)[:, met], reach=mounting.reach)
        self.places = Places(self.walls, mounting.angles, eyes)

    def where(self, sensors: Readings) -> Hypotheses:
        """Where the agent may be that senses this [K]."""
        return self.places.where(np.asarray(sensors, np.float64)[None])[0]

    def predict(
        self, sensors: Readings, codes: Float[Array | np.ndarray, "N C"]
    ) -> Float[np.ndarray, "N K"]:
        """The readings expected after sequences with these codes.

        Args:
            sensors: What is sensed now, [K], raw units.
            codes: Codes of the sequences that might follow, [N, C].

        Returns:
            The mean over the places where the agent may be, [N, K], raw units.
        """
        return self.predict_displaced(self.where(sensors), self.calibration.codes.read(codes))

    def predict_displaced(
        self, places: Hypotheses, displacements: Float[np.ndarray, "3 N"]
    ) -> Float[np.ndarray, "N K"]:
        """The readings expected at displacements from where the agent may be.

        Args:
            places: Where the agent may be.
            displacements: Of the sensors' frame, in the judge's frame and unit, as
                `calibration.codes.read` and `calibration.body.odometry.displacements` give them.
        """
        seen, weight = self._seen(places, displacements)
        total = weight.sum(axis=1, keepdims=True)
        return np.einsum("nh,nhk->nk", weight / total, seen)

    def log_likelihood(
        self,
        sensors: Readings,
        codes: Float[Array | np.ndarray, "N C"],
        goal: Readings,
    ) -> Float[np.ndarray, " N"]:
        """How likely each code leads to the readings `goal`, up to a constant.

        The log of a mixture over the places where the agent may be of Cauchy densities: unlike
        the mean of `predict` it does not blend what places that look alike would show.
        """
        seen, weight = self._seen(self.where(sensors), self.calibration.codes.read(codes))
        off = (seen - np.asarray(goal)) / (OUTLIER * self.walls.reach)
        each = np.log(weight) - np.log1p(off**2).sum(axis=-1)
        return np.asarray(np.logaddexp.reduce(each, axis=1))

    def ways(
        self, sensors: Readings, goal: Readings
    ) -> tuple[Float[np.ndarray, "3 P"], Float[np.ndarray, " P"]]:
        """The displacements that may lead from where this is sensed to where the goal is.

        Returns:
            For each pair of places that sense the two: the displacement of the sensors' frame
            (x, y, angle; the judge's frame and unit), and how likely the pair is. Which of them
            commands can reach, the judge does not know.
        """
        rows = np.stack([np.asarray(sensors, np.float64), np.asarray(goal, np.float64)])
        here, there = self.places.where(rows)
        starts = np.repeat(here.eyes, len(there.weight), axis=1)
        seen = relative(starts, np.tile(there.eyes, len(here.weight)))
        weight = np.outer(here.weight, there.weight).reshape(-1)
        return self.calibration.body.mounting.unseen(seen), weight

    def _seen(
        self, places: Hypotheses, displacements: Float[np.ndarray, "3 N"]
    ) -> tuple[Float[np.ndarray, "N H K"], Float[np.ndarray, "N H"]]:
        """What each displacement leads to from each place, and how likely it started there."""
        moved = self.calibration.body.mounting.seen(displacements)[:, :, None]
        shape = (3, moved.shape[1], len(places.weight))
        starts = np.broadcast_to(places.eyes[:, None], shape)
        ends = np.asarray(compose(starts, np.broadcast_to(moved, shape)))
        seen, hidden = self._views(starts.reshape(3, -1), ends.reshape(3, -1))
        weight = places.weight * np.where(hidden.reshape(shape[1:]), HIDDEN, 1.0)
        return seen.reshape(*shape[1:], -1), weight

    def _views(
        self, starts: Float[np.ndarray, "3 P"], ends: Float[np.ndarray, "3 P"]
    ) -> tuple[Float[np.ndarray, "P K"], np.ndarray]:
        num = starts.shape[1]
        # Chunks of one size share one compiled program.
        size = CHUNK_SIZE if num > FEW else FEW
        pairs = np.pad(np.stack([starts, ends]), ((0, 0), (0, 0), (0, -num % size)), mode="edge")
        angles = jnp.asarray(self.calibration.body.mounting.angles, jnp.float32)
        chunks = np.split(pairs.astype(np.float32), pairs.shape[-1] // size, axis=-1)
        viewed = [_view(self.walls, jnp.asarray(chunk), angles) for chunk in chunks]
        seen, hidden = (
            np.concatenate([np.asarray(v) for v in part]) for part in zip(*viewed, strict=True)
        )
        return seen[:num].astype(np.float64), hidden[:num]


def _met(mounting: Mounting, sensors: Float[np.ndarray, "S K"]) -> Bool[np.ndarray, "S K"]:
    """Which rays have met a wall."""
    return sensors < SATURATED * mounting.reach


@eqx.filter_jit
def _view(
    walls: WallMap, pairs: Float[Array, "2 3 P"], angles: Float[Array, " K"]
) -> tuple[Float[Array, "P K"], Bool[Array, " P"]]:
    """What is seen at the ends, and whether a wall hides them from where the agent starts.

    `pairs` holds the starts and the ends. An end that lies just behind a wall cannot be right: it
    is taken to be just before it.
    """
    (x, y, _), ends = pairs
    dx, dy = ends[0] - x, ends[1] - y
    bearing, distance = jnp.arctan2(dy, dx), jnp.hypot(dx, dy)
    free = walls.ranges(jnp.stack([x, y, bearing]), jnp.zeros(1))[:, 0]
    behind = distance - free
    hidden = behind > BEHIND * walls.reach
    before = jnp.maximum(free - APART * walls.reach, 0.0) / jnp.maximum(distance, 1e-6)
    share = jnp.where((behind > -APART * walls.reach) & ~hidden, before, 1.0)
    share = jnp.minimum(share, 1.0)
    seen = walls.ranges(jnp.stack([x + share * dx, y + share * dy, ends[2]]), angles)
    return seen, hidden
