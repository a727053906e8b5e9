"""Towards readings: a judge that knows the place says where they are sensed, codes lead there."""

from typing import NamedTuple

import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Float
from scipy.spatial import cKDTree

from motorspace._types import Code, Key, Motors
from motorspace.control.controller import Controller
from motorspace.control.planning import USUAL, Effort, code_target, reach
from motorspace.judge.judge import Judge, Readings
from motorspace.mapping.walls import clearance
from motorspace.se2 import compose, relative

ANSWERS = 16
"""Motor sequences among which one is sought that no wall stands in the way of."""
NEIGHBOURS = 64
"""Sequences of the bank that lead nearly there, and determine the code."""
TURN_WEIGHT = 1.5
"""World units that a unit of (cos, sin) counts for."""
FAR = 0.5
"""World units beyond which the bank does not reach."""
BLOCKED = 100.0
"""World units that a sequence is taken to miss by which a wall stands in the way of."""


class Course(NamedTuple):
    """Where to go, in the judge's own frame."""

    here: Float[np.ndarray, "3"]
    """Where the agent most likely is."""
    moved: Float[np.ndarray, "3"]
    """The displacement of its rays' origin to where the readings are sensed."""


class Answer(NamedTuple):
    """Motor commands, and how far they miss."""

    motors: Float[np.ndarray, "T M"]
    miss: float
    """World units, by the judge's odometry; above `BLOCKED` where its map shows a wall."""


class Guide:
    """Plans towards readings, in a layout that a judge has learned.

    No pose, displacement or wall is given: the judge's odometry, map and places are its own.

    Args:
        controller: From codes to motor commands.
        judge: Of the layout, for the same run.

    Example:
        >>> guide = Guide(controller, judge)  # doctest: +SKIP
        >>> guide.plan(sensors, goal, key=jax.random.key(0)).shape  # doctest: +SKIP
        (6, 2)
    """

    def __init__(self, controller: Controller, judge: Judge) -> None:
        self.controller, self.judge = controller, judge
        self.codes = np.asarray(controller.bank.codes, np.float64)
        self.motors = np.asarray(controller.bank.motors, np.float64)
        self.moved = self._moved(self.motors)
        self.tree = cKDTree(features(self.moved).T)

    def plan(
        self,
        sensors: Readings,
        goal: Readings,
        *,
        effort: Effort = USUAL,
        key: Key,
    ) -> Float[np.ndarray, "T M"]:
        """Motor commands [T, M] that should lead to where `goal` is sensed, around walls.

        Args:
            sensors: The readings now, at rest, [K], raw units.
            goal: The readings wanted, one sequence away, [K], raw units.
            effort: How hard each answer is refined.
            key: Source of randomness.
        """
        return self.answer(self.course(sensors, goal), effort=effort, key=key).motors

    def course(self, sensors: Readings, goal: Readings) -> Course:
        """The likeliest pair, within reach, of a place where the agent may be and one that looks
        like the goal."""
        here, there = self.judge.where(sensors), self.judge.where(goal)
        first, second = np.meshgrid(*map(np.arange, (len(here.weight), len(there.weight))))
        pairs = first.ravel(), second.ravel()
        moved = relative(here.eyes[:, pairs[0]], there.eyes[:, pairs[1]])
        with np.errstate(divide="ignore"):
            likely = np.log(here.weight[pairs[0]]) + np.log(there.weight[pairs[1]])
        best = int(np.argmax(likely - (self.beyond(moved) / FAR) ** 2))
        return Course(here.eyes[:, pairs[0][best]], moved[:, best])

    def beyond(self, moved: Float[np.ndarray, "3 N"]) -> Float[np.ndarray, " N"]:
        """How far displacements are from the nearest of the bank, world units."""
        gap, _ = self.tree.query(features(moved).T)
        return np.asarray(gap)

    def answer(self, course: Course, *, effort: Effort = USUAL, key: Key) -> Answer:
        """Of several motor sequences with the code of a course the one that misses least.

        Args:
            course: From a place of the agent at rest.
            effort: How hard each sequence is refined.
            key: Source of randomness.
        """
        code = jnp.asarray(self.code_of(course.moved), jnp.float32)
        answers = _answers(self.controller, code, effort, jax.random.split(key, ANSWERS))
        motors = np.asarray(answers, np.float64)
        off = features(self._moved(motors)) - features(course.moved[:, None])
        misses = np.linalg.norm(off, axis=0) + BLOCKED * (self.room(course.here, motors) <= 0)
        best = int(np.argmin(misses))
        return Answer(motors[best], float(misses[best]))

    def code_of(self, moved: Float[np.ndarray, "3"]) -> Float[np.ndarray, " C"]:
        """The code of a displacement, by the affine map that fits the bank around it."""
        _, near = self.tree.query(features(moved[:, None])[:, 0], k=NEIGHBOURS)
        known = features(self.moved[:, near])
        centre, level = known.mean(axis=1), self.codes[near].mean(axis=0)
        known = (known - centre[:, None]).T
        gram = known.T @ known + 1e-3 * len(near) * np.eye(known.shape[1])
        slopes = np.linalg.solve(gram, known.T @ (self.codes[near] - level))
        off = features(moved[:, None])[:, 0] - centre
        return np.asarray(level + off @ slopes)

    def room(
        self, here: Float[np.ndarray, "3"], motors: Float[np.ndarray, "N T M"]
    ) -> Float[np.ndarray, " N"]:
        """How far ahead of each sequence's steps the map's walls stand; below zero in their way."""
        steps = range(1, motors.shape[1] + 1)
        starts = np.repeat(here[:, None], len(motors), axis=1)
        after = [compose(starts, self._moved(motors[:, :num]))[:2] for num in steps]
        places = np.stack([starts[:2], *after], axis=-1)
        return clearance(self.judge.walls, places[..., :-1], places[..., 1:]).min(axis=-1)

    def _moved(self, motors: Float[np.ndarray, "N T M"]) -> Float[np.ndarray, "3 N"]:
        done = np.moveaxis(motors.astype(np.float64), 0, 1)
        return self.judge.calibration.body.moved(done)


def features(moved: Float[np.ndarray, "3 *batch"]) -> Float[np.ndarray, "4 *batch"]:
    """Displacements as points whose distances are in world units."""
    x, y, turn = moved
    return np.stack([x, y, TURN_WEIGHT * np.cos(turn), TURN_WEIGHT * np.sin(turn)])


@eqx.filter_jit
def _answers(
    controller: Controller, code: Code, effort: Effort, keys: Array
) -> Float[Array, "N T M"]:
    """Different sequences with this code."""
    target = code_target(controller, code)

    def one(key: Key) -> Motors:
        return reach(controller, target, "hybrid", effort, key=key)

    return jax.vmap(one)(keys)
