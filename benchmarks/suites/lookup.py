"""Range scans beside approximations: distances looked up in tables over a grid of 5 cm."""

import math
import os
from collections.abc import Callable
from typing import Any

import jax
import jax.numpy as jnp
import numba
import numpy as np
from scipy.ndimage import distance_transform_edt

from benchmarks.harness import Contender, Launch, report, take_turns
from benchmarks.suites.sensing import (
    FAN,
    LAYOUT,
    MAX_RANGE,
    NUM_POSES,
    NUM_RAYS,
    Answer,
    errors_of,
    exact_ranges,
    motorspace,
    scattered,
)
from motorspace._types import Pose
from motorspace.worlds.layouts import layout
from motorspace.worlds.sensors.range_fan import RangeFan
from motorspace.worlds.world import WalledWorld

CELL, NUM_ANGLES = 0.05, 108
"""World units of a cell, and directions in a turn, of the tables."""
HALF_TURN = math.pi * (1 - 1 / NUM_ANGLES)
"""From a heading to the first and to the last direction, radians."""


def main() -> None:
    """Both are our own writing of published methods, compiled by numba, on one thread."""
    threads = int(os.environ["BENCHMARK_THREADS"])
    world = layout(LAYOUT)
    poses, (x, y, heading) = scattered(world)
    exact = exact_ranges(np.asarray(world.walls, np.float64), x, y, FAN[:, None] + heading)
    answers = [make(world, poses, threads) for make in (motorspace, marching, table)]
    rates, first, foreign = take_turns([contender for contender, _ in answers])
    errors = {contender.name: errors_of(ranges(), exact) for contender, ranges in answers}
    report(Launch("scans beside tables", "rays", threads, rates, first, errors, foreign))


def marching(world: WalledWorld, poses: Pose, threads: int) -> Answer:
    """A map of distances to the nearest wall: a ray goes on by as much until it is at one.

    So do the simulators of F1TENTH and, as "ray marching", range_libc (Walsh and Karaman, 2018).
    """
    del threads
    size = round(40 / CELL)
    free = np.ones((size, size), bool)
    for (ax, ay), (bx, by) in np.asarray(world.walls, np.float64):
        steps = np.linspace(0, 1, 4 * size)
        column = ((ax + steps * (bx - ax)) / CELL).astype(int).clip(0, size - 1)
        free[column, ((ay + steps * (by - ay)) / CELL).astype(int).clip(0, size - 1)] = False
    distances = distance_transform_edt(free) * CELL
    return _numba("marching in a map of distances", distances, march, poses)


def table(world: WalledWorld, poses: Pose, threads: int) -> Answer:
    """Every range there is from every cell: range_libc's "giant lookup table"."""
    del threads
    size, fan = round(40 / CELL), RangeFan(NUM_ANGLES, MAX_RANGE, 2 * HALF_TURN)
    middles = (np.arange(size) + 0.5) * CELL
    sense = jax.jit(lambda pose: fan.sense(world, pose).T)
    ranges = np.empty((size, size, NUM_ANGLES), np.float32)
    for column, x in enumerate(middles):
        zero = jnp.zeros(size)
        ranges[column] = sense(Pose(zero + x, jnp.asarray(middles, jnp.float32), zero, zero))
    return _numba("giant table", ranges, look_up, poses)


def _numba(name: str, array: np.ndarray, scan: Callable[..., None], poses: Pose) -> Answer:
    given = [np.asarray(v, np.float32) for v in (poses.x, poses.y, poses.heading)]
    array, fan = array.astype(np.float32), FAN.astype(np.float32)
    out = np.empty((NUM_RAYS, NUM_POSES), np.float32)
    return (
        Contender(name, lambda: scan(array, *given, fan, out), NUM_POSES * NUM_RAYS),
        lambda: out.astype(float),
    )


@numba.njit(fastmath=True)
def march(distances: Any, xs: Any, ys: Any, headings: Any, fan: Any, out: Any) -> None:
    for pose in range(len(xs)):
        for ray in range(len(fan)):
            angle = headings[pose] + fan[ray]
            cos, sin, gone = math.cos(angle), math.sin(angle), np.float32(0.0)
            while gone < MAX_RANGE:
                column = min(max(int((xs[pose] + gone * cos) / CELL), 0), len(distances) - 1)
                row = min(max(int((ys[pose] + gone * sin) / CELL), 0), len(distances) - 1)
                if distances[column, row] < CELL / 2:
                    break
                gone += distances[column, row]
            out[ray, pose] = min(gone, MAX_RANGE)


@numba.njit(fastmath=True)
def look_up(ranges: Any, xs: Any, ys: Any, headings: Any, fan: Any, out: Any) -> None:
    for pose in range(len(xs)):
        column, row = int(xs[pose] / CELL), int(ys[pose] / CELL)
        for ray in range(len(fan)):
            angle = headings[pose] + fan[ray] + HALF_TURN
            direction = math.floor(angle * NUM_ANGLES / (2 * math.pi) + 0.5) % NUM_ANGLES
            out[ray, pose] = ranges[column, row, direction]


if __name__ == "__main__":
    main()
