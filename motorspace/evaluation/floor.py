"""How low a prediction's error can get that knows s_t and the true displacement, not the place.

Of many remembered poses those that sense nearly s_t are corrected until they sense it exactly, and
moved by the displacement; the mean of what they sense there is the prediction. It uses only what
every such predictor knows: its error estimates the floor from above, the closer the more poses.
"""

from collections.abc import Sequence
from typing import Any, NamedTuple

import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Float
from scipy.spatial import cKDTree

from motorspace._types import Count, Displacement, Key, Pose, Sensors
from motorspace.evaluation.prediction import Metrics
from motorspace.evaluation.sampling import draw_test
from motorspace.se2 import advance, wrap
from motorspace.training.data import Data, simulated
from motorspace.trajectories.transitions import Trajectories
from motorspace.worlds.sensors.base import AbstractSensor
from motorspace.worlds.world import AbstractWorld

FLOOR_SEED = 2_000_003
NUM_SETS, NUM_TEST = 5, 800
NEIGHBOURS = (50, 100, 200)
CHUNK_SIZE = 64
CORRECTIONS = 6
BANDWIDTH = 3e-3
"""Root mean square by which the sensors of a pose that matches may be off; raw units."""
DIFFERENCE = 1e-3
"""Step of the finite differences, world units and radians: far above the rounding of float32."""
OUTLIER = 0.1
"""What is off by more counts less: a ray beside a corner is off by a jump, not by a slope."""


class Memory(NamedTuple):
    """Poses drawn as trajectories begin; `tree` holds them by what they sense."""

    world: AbstractWorld
    sensor: AbstractSensor[Any]
    poses: Pose
    tree: cKDTree


class Prediction(NamedTuple):
    """Mean and variance of what the matching poses sense later."""

    mean: Float[Array, "*N K"]
    variance: Float[Array, "*N K"]


class Floor(NamedTuple):
    """An upper estimate, raw units squared: of each test set, and the standard error over all.

    `disagreement` is the mean variance of the predictions: the floor itself if the matching poses
    were exactly the possible ones.
    """

    errors: tuple[float, ...]
    standard_error: float
    disagreement: float
    neighbours: int


def remember(world: AbstractWorld, sensor: AbstractSensor[Any], num: int, *, key: Key) -> Memory:
    """A memory of `num` poses, for every agent whose sensors know only place and gaze."""
    poses = eqx.filter_jit(jax.vmap(lambda k: world.place(key=k)))(jax.random.split(key, num))
    sensors = eqx.filter_jit(sensor.sense)(world, poses)
    return Memory(world, sensor, poses, cKDTree(np.asarray(sensors, np.float64).T))


def predict(memory: Memory, trajectories: Trajectories, k: int) -> Prediction:
    """What the k poses that sense most like s_t predict from it and the true displacement."""
    sensors = trajectories.experience.sensors
    ranks = range(1, min(k, memory.tree.n) + 1)
    _, nearest = memory.tree.query(np.asarray(sensors, np.float64), k=ranks)
    poses = jax.tree.map(lambda field: field[nearest], memory.poses)
    cases = poses, sensors, trajectories.displacements.achieved
    return _predict_each(memory.world, memory.sensor, cases)


@eqx.filter_jit
def _predict_each(
    world: AbstractWorld,
    sensor: AbstractSensor[Any],
    cases: tuple[Pose, Float[Array, "N K"], Float[Array, "N 3"]],
) -> Prediction:
    def one(case: tuple[Pose, Sensors, Displacement]) -> Prediction:
        pose, sensors, (longitudinal, lateral, turn) = case
        pose = corrected(world, sensor, pose, sensors)
        end = advance(pose, longitudinal, lateral)
        end = Pose(end.x, end.y, wrap(end.heading + turn), end.head)
        # The trajectory was possible; if none of the poses allows it, all are kept.
        possible = world.free(end)
        possible |= ~possible.any()
        off = jnp.mean((sensor.sense(world, pose) - sensors[:, None]) ** 2, axis=0)
        weights = jax.nn.softmax(-off / (2 * BANDWIDTH**2), where=possible)
        later = sensor.sense(world, end)
        mean = later @ weights
        return Prediction(mean, (later - mean[:, None]) ** 2 @ weights)

    return jax.lax.map(one, cases, batch_size=CHUNK_SIZE)


def corrected(
    world: AbstractWorld, sensor: AbstractSensor[Any], pose: Pose, sensors: Float[Array, " K"]
) -> Pose:
    """k poses led to where they sense `sensors`, as nearly as they get there.

    Gauss-Newton steps on the sum of log(1 + (off / OUTLIER)^2), damped until they help.
    """

    def at(place: Float[Array, "3 k"]) -> Pose:
        return Pose(place[0], place[1], place[2], pose.head)

    def off(place: Float[Array, "3 k"]) -> Float[Array, "K k"]:
        return (sensor.sense(world, at(place)) - sensors[:, None]) / OUTLIER

    def correct(_: Count, now: tuple[Array, Array]) -> tuple[Array, Array]:
        place, damping = now
        here = off(place)
        aside = [off(place + DIFFERENCE * axis[:, None]) for axis in jnp.eye(3)]
        slopes = (jnp.stack(aside) - here[None]) / DIFFERENCE
        weighted = slopes / (1 + here[None] ** 2)
        normal = jnp.einsum("isk,jsk->kij", weighted, slopes)
        # Above zero also where nothing that is sensed depends on the pose.
        size = jnp.trace(normal, axis1=1, axis2=2) + DIFFERENCE
        normal += (damping * size)[:, None, None] * jnp.eye(3)[None]
        downhill = jnp.einsum("isk,sk->ki", weighted, here)[..., None]
        there = place - jnp.linalg.solve(normal, downhill)[..., 0].T
        less = jnp.log1p(off(there) ** 2).sum(axis=0) < jnp.log1p(here**2).sum(axis=0)
        better = less & world.free(at(there))
        damping = jnp.where(better, damping / 10, damping * 10).clip(1e-5, 1e3)
        return jnp.where(better[None], there, place), damping

    start = jnp.stack([pose.x, pose.y, pose.heading]), jnp.full(pose.x.shape, 1e-3)
    return at(jax.lax.fori_loop(0, CORRECTIONS, correct, start)[0])


def prediction_floor(data: Data, memory: Memory, *, num_test: int, key: Key) -> Floor:
    """The floor on `NUM_SETS` sets of `num_test` fresh trajectories of a run in simulation.

    As many neighbours are asked as do best on one set more.
    """
    sampled = draw_test(data, (1 + NUM_SETS) * num_test, key=key)
    held_out, tested = sampled[:num_test], sampled[num_test:]
    tried = [float(_errors(predict(memory, held_out, k), held_out).mean()) for k in NEIGHBOURS]
    neighbours = NEIGHBOURS[int(np.argmin(tried))]
    prediction = predict(memory, tested, neighbours)
    errors = _errors(prediction, tested)
    of_sets = tuple(float(error) for error in errors.reshape(NUM_SETS, -1).mean(axis=1))
    standard_error = float(errors.std() / len(errors) ** 0.5)
    return Floor(of_sets, standard_error, float(prediction.variance.mean()), neighbours)


def _errors(prediction: Prediction, true: Trajectories) -> Float[Array, " N"]:
    return jnp.mean((prediction.mean - true.experience.later_sensors) ** 2, axis=1)


def measure_floor(data: Data, *, num_poses: Sequence[int], num_test: int = NUM_TEST) -> Metrics:
    """The floor of a run in simulation, from each number of remembered poses.

    Returns:
        `floor.error.N` for N poses; of the most poses `floor.error`, raw units squared,
        `floor.lowest` and `.highest` of the sets, `.standard_error`, `.disagreement`,
        `.neighbours` and `.num`, the trajectories that are tested on.
    """
    memory_key, test_key = jax.random.split(jax.random.key(FLOOR_SEED))
    scenario = simulated(data).scenario()
    metrics: Metrics = {}
    for num in num_poses:
        memory = remember(scenario.world, scenario.sensor, num, key=memory_key)
        floor = prediction_floor(data, memory, num_test=num_test, key=test_key)
        metrics[f"floor.error.{num}"] = float(np.mean(floor.errors))
    return metrics | {
        "floor.error": float(np.mean(floor.errors)),
        "floor.lowest": min(floor.errors),
        "floor.highest": max(floor.errors),
        "floor.standard_error": floor.standard_error,
        "floor.disagreement": floor.disagreement,
        "floor.neighbours": floor.neighbours,
        "floor.num": NUM_SETS * num_test,
    }
