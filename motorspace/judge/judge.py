"""The judge: what an agent will sense after sequences with these codes, where it is now."""

from dataclasses import dataclass

import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Float

from motorspace._errors import UserError
from motorspace._types import Key
from motorspace.judge.calibration import Calibrated, calibrate_on
from motorspace.judge.codes import CodeBook, learn_codes
from motorspace.judge.mounting import SATURATED, Mounting, find_mounting
from motorspace.judge.odometry import distilled
from motorspace.judge.places import Hypotheses, Places
from motorspace.judge.smoothing import smoothed
from motorspace.judge.walks import Walk, joined, walk
from motorspace.judge.walls import WallMap, map_walls
from motorspace.se2 import compose
from motorspace.training.data import simulated
from motorspace.training.run import Run

NUM_WALKS, NUM_STEPS = 8, 3_000
"""Walks of each kind that a body is calibrated on."""
NUM_EXPLORED = 15_000
"""Steps of the walk that a layout is learned from."""
FORMAT_VERSION = 1
DESCRIPTION, ARRAYS = "judge.json", "judge.safetensors"
OUTLIER = 0.01
"""Of the likelihood: what is off by more counts less, share of the reach."""
CHUNK_SIZE = 4_096
"""Pairs of a code and a hypothesis that are judged at once."""


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
    random_key, straight_key, command_key, code_key = jax.random.split(key, 4)
    sizes = {"num_steps": NUM_STEPS, "num_walks": NUM_WALKS}
    # Random commands show what each does; long straight ways show the least bias.
    walked = joined(
        walk(scenario, **sizes, straight=False, key=random_key),
        walk(scenario, **sizes, key=straight_key),
    )
    learned = distilled(run, key=command_key)
    nowhere = Mounting(np.zeros(0), np.zeros(2), 0.0)
    frames = Calibrated(learned.odometry, nowhere).frames(walked)
    reach = float(max(run.model.scaling.sensors))
    mounting, unit = find_mounting(frames, walked.sensors, point=learned.point, reach=reach)
    body = calibrate_on(walked, Calibrated(learned.odometry.in_unit(unit), mounting))
    return Calibration(body, learn_codes(run, body, key=code_key))


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
        eyes = calibration.body.eyes(walked)[..., 0]
        eyes = smoothed(eyes, walked.sensors[:, 0], calibration.body.mounting)
        self._remember(calibration, eyes, walked.sensors[:, 0])

    def _remember(
        self,
        calibration: Calibration,
        eyes: Float[np.ndarray, "3 S"],
        sensors: Float[np.ndarray, "S K"],
    ) -> None:
        self.calibration, self.eyes, self.sensors = calibration, eyes, sensors
        mounting = calibration.body.mounting
        met = sensors < SATURATED * mounting.reach
        if not met.any():
            raise UserError(
                "no ray has met a wall on this walk", remedy="walk farther, or sense farther"
            )
        self.walls = map_walls(mounting.ends(eyes, sensors)[:, met], reach=mounting.reach)
        self.places = Places(self.walls, mounting.angles, eyes)

    def where(self, sensors: Float[np.ndarray, " K"]) -> Hypotheses:
        """Where the agent may be that senses this [K]."""
        return self.places.where(np.asarray(sensors, np.float64)[None])[0]

    def predict(
        self, sensors: Float[np.ndarray, " K"], codes: Float[Array | np.ndarray, "N C"]
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
        seen = self._seen(places, displacements)
        return np.einsum("h,nhk->nk", places.weight, seen)

    def log_likelihood(
        self,
        sensors: Float[np.ndarray, " K"],
        codes: Float[Array | np.ndarray, "N C"],
        goal: Float[np.ndarray, " K"],
    ) -> Float[np.ndarray, " N"]:
        """How likely each code leads to the readings `goal`, up to a constant.

        The log of a mixture over the places where the agent may be of Cauchy densities: unlike
        the mean of `predict` it does not blend what places that look alike would show.
        """
        places = self.where(sensors)
        seen = self._seen(places, self.calibration.codes.read(codes))
        off = (seen - np.asarray(goal)) / (OUTLIER * self.walls.reach)
        with np.errstate(divide="ignore"):
            each = np.log(places.weight) - np.log1p(off**2).sum(axis=-1)
        return np.asarray(np.logaddexp.reduce(each, axis=1))

    def _seen(
        self, places: Hypotheses, displacements: Float[np.ndarray, "3 N"]
    ) -> Float[np.ndarray, "N H K"]:
        """What each displacement leads to from each place."""
        likely = places.weight > 0
        mounting = self.calibration.body.mounting
        moved = mounting.seen(displacements)[:, :, None]
        starts = np.broadcast_to(places.eyes[:, None, likely], (3, moved.shape[1], likely.sum()))
        ends = np.asarray(compose(starts, np.broadcast_to(moved, starts.shape)))
        flat = ends.reshape(3, -1)
        # Chunks of one size share one compiled program.
        size = CHUNK_SIZE if flat.shape[1] > 256 else 256
        padded = np.pad(flat, ((0, 0), (0, -flat.shape[1] % size)), mode="edge")
        angles = jnp.asarray(mounting.angles, jnp.float32)
        chunks = np.split(padded, padded.shape[1] // size, axis=1)
        seen = [_ranges(self.walls, jnp.asarray(c, jnp.float32), angles) for c in chunks]
        ranges = np.concatenate([np.asarray(part) for part in seen])[: flat.shape[1]]
        found = np.zeros((*ends.shape[1:2], len(likely), ranges.shape[-1]))
        found[:, likely] = ranges.reshape(*ends.shape[1:], -1)
        return found


@eqx.filter_jit
def _ranges(walls: WallMap, eyes: Array, angles: Array) -> Array:
    return walls.ranges(eyes, angles)
