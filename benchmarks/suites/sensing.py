"""Range scans: the same poses in the same world, nine rays each."""

import math
import os
import sys
from collections.abc import Callable
from typing import Any

import jax
import numpy as np

from benchmarks.harness import Contender, Launch, report, take_turns
from motorspace._types import Pose
from motorspace.worlds.layouts import layout
from motorspace.worlds.sensors.range_fan import RangeFan
from motorspace.worlds.world import WalledWorld

LAYOUT = "benchmarks/w12.layout"
NUM_POSES, NUM_RAYS, MAX_RANGE = 16_384, 9, 10.0
FAN = np.linspace(-math.pi / 2, math.pi / 2, NUM_RAYS)
Ranges = np.ndarray
"""Shape [rays, poses], float64."""


Answer = tuple[Contender, Callable[[], Ranges]]
"""Who scans, and what it finds."""


def main() -> None:
    """Time everybody, and check that the answers are right."""
    threads = int(os.environ["BENCHMARK_THREADS"])
    world = layout(LAYOUT)
    poses, (x, y, heading) = scattered(world)
    walls = np.asarray(world.walls, np.float64)
    exact = exact_ranges(walls, x, y, FAN[:, None] + heading)
    answers = [make(world, poses, threads) for make in (motorspace, open3d, vmas, pymunk)]
    rates, first, foreign = take_turns([contender for contender, _ in answers])
    errors = {}
    for contender, ranges in answers:
        errors[contender.name] = errors_of(ranges(), exact)
        if errors[contender.name]["median"] > 1e-3 or errors[contender.name]["99 %"] > 1e-2:
            sys.exit(f"benchmarks: {contender.name} does not answer the same question")
    report(Launch("scans", "rays", threads, rates, first, errors, foreign))


def scattered(world: WalledWorld) -> tuple[Pose, list[np.ndarray]]:
    """The poses that everybody scans from, and their x, y and heading in float64."""
    keys = jax.random.split(jax.random.key(12), NUM_POSES)
    poses = jax.jit(jax.vmap(lambda key: world.place(key=key)))(keys)
    return poses, [np.asarray(v, np.float64) for v in (poses.x, poses.y, poses.heading)]


def errors_of(ranges: Ranges, exact: Ranges) -> dict[str, float]:
    """How far the ranges of the first few poses, or of all, are from the exact ones."""
    error = np.abs(ranges - exact[:, : ranges.shape[1]])
    return {
        "median": float(np.median(error)),
        "99 %": float(np.quantile(error, 0.99)),
        "largest": float(error.max()),
    }


def exact_ranges(walls: np.ndarray, x: np.ndarray, y: np.ndarray, angles: np.ndarray) -> Ranges:
    """The textbook intersection of rays and segments in float64."""
    cos, sin = np.cos(angles), np.sin(angles)
    nearest = np.full(angles.shape, MAX_RANGE)
    for (ax, ay), (bx, by) in walls:
        across = cos * (by - ay) - sin * (bx - ax)
        with np.errstate(divide="ignore", invalid="ignore"):
            distance = ((ax - x) * (by - ay) - (ay - y) * (bx - ax)) / across
            share = ((ax - x) * sin - (ay - y) * cos) / across
        met = (distance >= 0) & (share >= 0) & (share <= 1)
        nearest = np.where(met, np.minimum(nearest, distance), nearest)
    return nearest


def motorspace(world: WalledWorld, poses: Pose, threads: int) -> Answer:
    del threads
    fan = RangeFan(NUM_RAYS, MAX_RANGE)
    sense = jax.jit(lambda poses: fan.sense(world, poses))
    run = lambda: jax.block_until_ready(sense(poses))  # noqa: E731
    return Contender("motorspace", run, NUM_POSES * NUM_RAYS), lambda: np.asarray(run(), float)


def open3d(world: WalledWorld, poses: Pose, threads: int) -> Answer:
    """Open3D's ray casting (Embree 4): every wall an upright rectangle of two triangles."""
    import open3d.core as o3c
    from open3d.t.geometry import RaycastingScene

    walls = np.asarray(world.walls, np.float32)
    low, high = (
        np.concatenate([walls.reshape(-1, 2), np.full((2 * len(walls), 1), z)], 1) for z in (-1, 1)
    )
    vertices = np.concatenate([low, high]).astype(np.float32)
    a, above = np.arange(len(walls)) * 2, 2 * len(walls)
    triangles = np.concatenate(
        [np.stack([a, a + 1, a + above], 1), np.stack([a + 1, a + above + 1, a + above], 1)]
    )
    scene = RaycastingScene(nthreads=threads)
    scene.add_triangles(
        o3c.Tensor.from_numpy(vertices), o3c.Tensor.from_numpy(triangles.astype(np.uint32))
    )
    angles = FAN[:, None] + np.asarray(poses.heading, np.float64)
    rays = np.zeros((NUM_RAYS, NUM_POSES, 6), np.float32)
    rays[..., 0], rays[..., 1] = poses.x, poses.y
    rays[..., 3], rays[..., 4] = np.cos(angles), np.sin(angles)
    given = o3c.Tensor.from_numpy(rays)

    def run() -> Any:
        return scene.cast_rays(given, nthreads=threads)["t_hit"]

    return (
        Contender("Open3D", run, NUM_POSES * NUM_RAYS),
        lambda: np.minimum(run().numpy().astype(float), MAX_RANGE),
    )


def vmas(world: WalledWorld, poses: Pose, threads: int) -> Answer:
    """VMAS's lidar: one world per pose in its batch, every wall a line."""
    import torch

    torch.set_num_threads(threads)
    num = 4096  # the only batch tried
    places, agent = vmas_world(world, num)
    at = np.stack([poses.x, poses.y], 1)[:num]
    agent.set_pos(torch.tensor(at), batch_index=None)
    angles = torch.tensor(np.asarray(FAN[:, None] + poses.heading)[:, :num].T.copy()).float()

    def run() -> Any:
        with torch.no_grad():
            return places.cast_rays(
                agent, angles, max_range=MAX_RANGE, entity_filter=lambda e: e is not agent
            )

    return Contender("VMAS", run, num * NUM_RAYS), lambda: run().numpy().astype(float).T


def vmas_world(world: WalledWorld, num: int) -> tuple[Any, Any]:
    """VMAS's world with these walls, and its one agent."""
    import torch
    from vmas.simulator.core import Agent, Landmark, Line, World

    places = World(batch_dim=num, device="cpu")
    for index, ((ax, ay), (bx, by)) in enumerate(np.asarray(world.walls, np.float64)):
        line = Line(math.hypot(bx - ax, by - ay))
        wall = Landmark(f"wall {index}", shape=line)
        places.add_landmark(wall)
        wall.set_pos(torch.tensor([[(ax + bx) / 2, (ay + by) / 2]]).float(), batch_index=None)
        turn = torch.full((num, 1), math.atan2(by - ay, bx - ax))
        wall.set_rot(turn, batch_index=None)
    agent = Agent("agent")
    places.add_agent(agent)
    return places, agent


def pymunk(world: WalledWorld, poses: Pose, threads: int) -> Answer:
    """pymunk: a query of its index of segments per ray."""
    del threads
    import pymunk as library

    space, num = library.Space(), 256
    for a, b in np.asarray(world.walls, float):
        space.add(library.Segment(space.static_body, tuple(a), tuple(b), 0.0))
    x, y, heading = (np.asarray(v, float)[:num] for v in (poses.x, poses.y, poses.heading))
    angles = FAN[:, None] + heading
    ends = np.stack([x + MAX_RANGE * np.cos(angles), y + MAX_RANGE * np.sin(angles)], -1)
    starts, ends = list(zip(x.tolist(), y.tolist(), strict=True)), ends.tolist()
    anything = library.ShapeFilter()

    def run() -> list[float]:
        ranges = []
        for row in ends:
            for start, end in zip(starts, row, strict=True):
                hit = space.segment_query_first(start, end, 0.0, anything)
                ranges.append(MAX_RANGE if hit is None else hit.alpha * MAX_RANGE)
        return ranges

    return (
        Contender("pymunk", run, num * NUM_RAYS),
        lambda: np.array(run()).reshape(NUM_RAYS, num),
    )


if __name__ == "__main__":
    main()
