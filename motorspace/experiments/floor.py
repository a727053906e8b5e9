"""How low a prediction's error can get that knows s_t and the true displacement, not the place.

The floor is estimated by memory. Of many poses in a world those that sense nearly s_t are corrected
until they sense it exactly and moved by the displacement; the mean of what they sense there is the
prediction. It uses nothing but what any such predictor knows, so its error is an upper estimate
of the floor, and comes down to it with the number of poses.
"""

import itertools
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any, NamedTuple

import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Bool, Float
from scipy.spatial import cKDTree

from motorspace._types import Displacement, Key, Pose, Sensors
from motorspace.experiments import paper
from motorspace.experiments.measurement import draw_test
from motorspace.experiments.summary import spread
from motorspace.training import RunConfig
from motorspace.trajectories import Trajectories
from motorspace.worlds import AbstractSensor, AbstractWorld
from motorspace.worlds.geometry import advance, wrap

CELLS = tuple(itertools.product(paper.PAPER_ERRORS, paper.ROTATIONS))
FLOOR_SEED = 2_000_003
NUM_POSES = (10_000, 100_000, 1_000_000)
NUM_TEST, NUM_SETS = 800, 5
NEIGHBOURS = (25, 50, 100, 200)
BANDWIDTHS = (0.001, 0.01, 0.1, 1.0)
"""Root mean squares, per sensor, by which a corrected pose may still be off; raw units."""

CORRECTIONS = 8
DIFFERENCE = 1e-3
"""World units and radians: rounding of float32 and curvature cost a finite difference as much."""
OUTLIER = 0.1
"""A sensor that is off by more counts less: a ray beside a corner is off by a jump, whose size
says nothing about how far off the pose is."""
CHUNK_SIZE = 64


@dataclass(frozen=True)
class Memory:
    """P poses of a world, drawn as trajectories begin, and what is sensed there."""

    world: AbstractWorld
    sensor: AbstractSensor[Any]
    poses: Pose
    tree: cKDTree
    """The poses by what they sense."""


class Recall(NamedTuple):
    """What k poses foretell of each of N trajectories, those first that sense most like it."""

    mismatch: Float[Array, "N k"]
    """Mean squared difference between s_t and what the corrected pose senses."""
    possible: Bool[Array, "N k"]
    """Whether the displacement ends at a free place."""
    later: Float[Array, "N k K"]


class Floor(NamedTuple):
    """An upper estimate of the floor, raw units squared, and how it came about."""

    errors: tuple[float, ...]
    """Mean squared error on each test set."""
    standard_error: float
    """Of the mean over all test trajectories."""
    disagreement: float
    """Variance among the poses that match: the floor itself, were they just the possible ones."""
    neighbours: int
    bandwidth: float


def remember(world: AbstractWorld, sensor: AbstractSensor[Any], num: int, *, key: Key) -> Memory:
    """A memory of `num` poses; it serves every agent whose senses know only place and gaze."""
    poses = eqx.filter_jit(jax.vmap(lambda k: world.place(key=k)))(jax.random.split(key, num))
    sensors = eqx.filter_jit(sensor.sense)(world, poses)
    return Memory(world, sensor, poses, cKDTree(np.asarray(sensors, np.float64).T))


def recall(memory: Memory, trajectories: Trajectories, k: int) -> Recall:
    """What the k poses nearest in sensor space foretell."""
    sensors = trajectories.experience.sensors
    nearest = memory.tree.query(np.asarray(sensors, np.float64), k=range(1, k + 1))[1]
    poses = jax.tree.map(lambda field: field[nearest], memory.poses)
    achieved = trajectories.displacements.achieved
    return _foretold(memory.world, memory.sensor, poses, sensors, achieved)


@eqx.filter_jit
def _foretold(
    world: AbstractWorld,
    sensor: AbstractSensor[Any],
    poses: Pose,
    sensors: Float[Array, "N K"],
    displacements: Float[Array, "N 3"],
) -> Recall:
    def one(case: tuple[Pose, Sensors, Displacement]) -> Recall:
        pose, sensed, (longitudinal, lateral, turn) = case
        pose = _corrected(world, sensor, pose, sensed)
        end = advance(pose, longitudinal, lateral)
        end = Pose(end.x, end.y, wrap(end.heading + turn), end.head)
        off = sensor.sense(world, pose) - sensed[:, None]
        return Recall(jnp.mean(off**2, axis=0), world.free(end), sensor.sense(world, end).T)

    return jax.lax.map(one, (poses, sensors, displacements), batch_size=CHUNK_SIZE)


def _corrected(
    world: AbstractWorld, sensor: AbstractSensor[Any], pose: Pose, sensed: Float[Array, " K"]
) -> Pose:
    """Poses led to where they sense `sensed`, as near as they come.

    Gauss-Newton steps, damped until they help (Marquardt, 1963), that minimise the sum of
    log(1 + (off / OUTLIER)^2).
    """
    head = pose.head

    def off(place: Float[Array, "3 k"]) -> Float[Array, "K k"]:
        return sensor.sense(world, Pose(*place, head)) - sensed[:, None]

    def cost(off: Float[Array, "K k"]) -> Float[Array, " k"]:
        return jnp.log1p((off / OUTLIER) ** 2).sum(axis=0)

    def correct(now: tuple[Array, Array, Array], _: None) -> tuple[tuple[Array, ...], None]:
        place, missed, damping = now
        aside = place + DIFFERENCE * jnp.eye(3)[:, :, None]
        slopes = (jnp.stack([off(moved) for moved in aside]) - missed) / DIFFERENCE
        weighted = slopes / (1 + (missed / OUTLIER) ** 2)
        normal = jnp.einsum("isk,jsk->kij", weighted, slopes)
        trace = jnp.trace(normal, axis1=1, axis2=2) + DIFFERENCE**2
        normal += (damping * trace)[:, None, None] * jnp.eye(3)
        towards = jnp.einsum("isk,sk->ki", weighted, missed)[..., None]
        there = place - jnp.linalg.solve(normal, towards)[..., 0].T
        missed_there = off(there)
        better = world.free(Pose(*there, head)) & (cost(missed_there) < cost(missed))
        place, missed = jnp.where(better, there, place), jnp.where(better, missed_there, missed)
        damping = jnp.where(better, damping / 10, damping * 10).clip(1e-5, 1e3)
        return (place, missed, damping), None

    place = jnp.stack([pose.x, pose.y, pose.heading])
    start = place, off(place), jnp.full(pose.x.shape, 1e-3)
    (place, _, _), _ = jax.lax.scan(correct, start, length=CORRECTIONS)
    return Pose(*place, head)


def predicted(
    recalled: Recall, k: int, bandwidth: float
) -> tuple[Float[Array, "N K"], Float[Array, "N K"]]:
    """Mean and variance of what the first k poses foretell, weighted by how well they match.

    Poses whose displacement ends in a wall are left out, unless all of them do.
    """
    mismatch, possible, later = jax.tree.map(lambda leaf: leaf[:, :k], recalled)
    possible |= ~possible.any(axis=1, keepdims=True)
    weights = jax.nn.softmax(-mismatch / (2 * bandwidth**2), axis=1, where=possible)[..., None]
    mean = (weights * later).sum(axis=1)
    return mean, (weights * (later - mean[:, None]) ** 2).sum(axis=1)


def prediction_floor(
    config: RunConfig, memory: Memory, *, num_test: int, num_sets: int = NUM_SETS, key: Key
) -> Floor:
    """The floor of a run, on `num_sets` sets of `num_test` fresh trajectories.

    How many poses are asked, and how exactly they have to match, is what does best on one set more.
    """
    drawn = draw_test(config, (1 + num_sets) * num_test, key=key)
    held_out, tested = drawn[:num_test], drawn[num_test:]
    recalled = recall(memory, held_out, NEIGHBOURS[-1])
    settings = itertools.product(NEIGHBOURS, BANDWIDTHS)
    best = min(settings, key=lambda s: float(_errors(predicted(recalled, *s)[0], held_out).mean()))
    mean, variance = predicted(recall(memory, tested, best[0]), *best)
    errors = _errors(mean, tested)
    of_sets = tuple(float(e) for e in errors.reshape(num_sets, -1).mean(axis=1))
    return Floor(of_sets, float(errors.std() / len(errors) ** 0.5), float(variance.mean()), *best)


def _errors(predicted: Float[Array, "N K"], true: Trajectories) -> Float[Array, " N"]:
    return jnp.mean((predicted - true.experience.later_sensors) ** 2, axis=1)


def floor_rows(
    *,
    cells: Sequence[tuple[str, float]] = CELLS,
    num_poses: Sequence[int] = NUM_POSES,
    num_test: int = NUM_TEST,
    report: Callable[[str], None] = lambda line: None,
) -> list[dict[str, Any]]:
    """One row per cell of the paper's table; `num_poses` from few to many, the last one counts."""
    memory_key, test_key = jax.random.split(jax.random.key(FLOOR_SEED))
    configs = [paper.cell(*cell, "paper", 0) for cell in cells]
    world, _, sensor = configs[0].simulation.build()
    memories = [remember(world, sensor, num, key=memory_key) for num in num_poses]
    rows = []
    for (agent, rotation), config in zip(cells, configs, strict=True):
        floors = [prediction_floor(config, m, num_test=num_test, key=test_key) for m in memories]
        means = [float(np.mean(floor.errors)) for floor in floors]
        row = {
            "agent": agent,
            "rotation": rotation,
            "floor": spread(floors[-1].errors),
            "standard_error": floors[-1].standard_error,
            "disagreement": floors[-1].disagreement,
            "by_poses": dict(zip(map(str, num_poses), means, strict=True)),
            "neighbours": floors[-1].neighbours,
            "bandwidth": floors[-1].bandwidth,
            "num_test": NUM_SETS * num_test,
        }
        rows.append(row)
        report(f"{agent}, r = {rotation} pi: {row['by_poses']}")
    return rows
