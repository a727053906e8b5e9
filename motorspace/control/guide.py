"""Towards readings: a judge that knows the place says where they are sensed, codes lead there."""

from typing import NamedTuple

import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Bool, Float
from scipy.spatial import cKDTree

from motorspace._types import Code, Key, Motors
from motorspace.control.controller import Controller
from motorspace.control.planning import USUAL, Effort, code_target, reach
from motorspace.judge.judge import Judge
from motorspace.se2 import compose, relative

ANSWERS = 16
"""Motor sequences among which one is sought that no wall stands in the way of."""
NEIGHBOURS = 64
"""Sequences of the bank that lead nearly there, and determine the code."""
TURN_WEIGHT = 1.5
"""World units that a unit of (cos, sin) counts for."""
FAR = 0.5
"""World units beyond which the bank does not reach."""


class Course(NamedTuple):
    """Where to go, in the judge's own frame."""

    here: Float[np.ndarray, "3"]
    """Where the agent most likely is."""
    moved: Float[np.ndarray, "3"]
    """The displacement of its rays' origin to where the readings are sensed."""


class Guide:
    """Plans towards readings, in a layout that a judge has learned.

    No pose, displacement or wall is given: the judge's odometry, map and places are its own.

    Args:
        controller: From codes to motor commands.
        judge: Of the layout, for the same run.
    """

    def __init__(self, controller: Controller, judge: Judge) -> None:
        self.controller, self.judge = controller, judge
        codes = np.asarray(controller.bank.codes, np.float64)
        self.moved = self._seen(judge.calibration.codes.read(codes))
        self.codes, self.tree = codes, cKDTree(_features(self.moved).T)

    def plan(
        self,
        sensors: Float[np.ndarray, " K"],
        goal: Float[np.ndarray, " K"],
        *,
        effort: Effort = USUAL,
        key: Key,
    ) -> Float[np.ndarray, "T M"]:
        """Motor commands [T, M] that should lead to where `goal` is sensed, around walls.

        Args:
            sensors: The readings now, [K], raw units.
            goal: The readings wanted, [K], raw units.
            effort: How hard each answer is refined.
            key: Source of randomness.
        """
        course = self.course(sensors, goal)
        code = jnp.asarray(self.code_of(course.moved), jnp.float32)
        keys = jax.random.split(key, ANSWERS)
        motors, misses = map(np.asarray, _answers(self.controller, code, effort, keys))
        costs = np.where(self.free(course.here, motors), misses, misses + np.ptp(misses) + 1.0)
        return np.asarray(motors[np.argmin(costs)])

    def course(self, sensors: Float[np.ndarray, " K"], goal: Float[np.ndarray, " K"]) -> Course:
        """The likeliest pair, within reach, of a place where the agent may be and one that looks
        like the goal."""
        here, there = self.judge.where(sensors), self.judge.where(goal)
        first, second = np.meshgrid(*map(np.arange, (len(here.weight), len(there.weight))))
        pairs = first.ravel(), second.ravel()
        moved = relative(here.eyes[:, pairs[0]], there.eyes[:, pairs[1]])
        gap, _ = self.tree.query(_features(moved).T)
        with np.errstate(divide="ignore"):
            likely = np.log(here.weight[pairs[0]]) + np.log(there.weight[pairs[1]])
        best = int(np.argmax(likely - (gap / FAR) ** 2))
        return Course(here.eyes[:, pairs[0][best]], moved[:, best])

    def code_of(self, moved: Float[np.ndarray, "3"]) -> Float[np.ndarray, " C"]:
        """The code of a displacement, by the affine map that fits the bank around it."""
        _, near = self.tree.query(_features(moved[:, None])[:, 0], k=NEIGHBOURS)
        known = _features(self.moved[:, near])
        centre, level = known.mean(axis=1), self.codes[near].mean(axis=0)
        known = (known - centre[:, None]).T
        gram = known.T @ known + 1e-3 * len(near) * np.eye(known.shape[1])
        slopes = np.linalg.solve(gram, known.T @ (self.codes[near] - level))
        off = _features(moved[:, None])[:, 0] - centre
        return np.asarray(level + off @ slopes)

    def free(
        self, here: Float[np.ndarray, "3"], motors: Float[np.ndarray, "N T M"]
    ) -> Bool[np.ndarray, " N"]:
        """Whether no wall of the judge's map stands in the way of each sequence."""
        odometry = self.judge.calibration.body.odometry
        done = np.moveaxis(motors.astype(np.float64), 0, 1)
        before = np.repeat(here[:, None], len(motors), axis=1)
        free = np.ones(len(motors), bool)
        for num in range(1, len(done) + 1):
            moved = self._seen(odometry.displacements(done[:num]))
            after = compose(np.repeat(here[:, None], len(motors), axis=1), moved)
            step = after[:2] - before[:2]
            bearing = np.arctan2(step[1], step[0])
            ahead = jnp.asarray(np.stack([before[0], before[1], bearing]), jnp.float32)
            clear = np.asarray(self.judge.walls.ranges(ahead, jnp.zeros(1)))[:, 0]
            free &= np.hypot(*step) < clear
            before = after
        return free

    def _seen(self, moved: Float[np.ndarray, "3 N"]) -> Float[np.ndarray, "3 N"]:
        return self.judge.calibration.body.mounting.seen(moved)


def _features(moved: Float[np.ndarray, "3 N"]) -> Float[np.ndarray, "4 N"]:
    """Displacements as points whose distances are in world units."""
    x, y, turn = moved
    return np.stack([x, y, TURN_WEIGHT * np.cos(turn), TURN_WEIGHT * np.sin(turn)])


@eqx.filter_jit
def _answers(
    controller: Controller, code: Code, effort: Effort, keys: Array
) -> tuple[Float[Array, "N T M"], Float[Array, " N"]]:
    """Different sequences with this code, and how far their codes are from it."""
    target = code_target(controller, code)

    def one(key: Key) -> Motors:
        return reach(controller, target, "hybrid", effort, key=key)

    motors = jax.vmap(one)(keys)
    return motors, jax.vmap(target.cost)(motors)
