"""One agent, one command, one scan: what a step costs that cannot be shared with others."""

import json
import math
import os
import tempfile

import gymnasium
import irsim
import numpy as np
import pymunk
from ratinabox.Agent import Agent
from ratinabox.Environment import Environment

import motorspace.environments  # noqa: F401, which registers the environments
from benchmarks.harness import Contender, Launch, report, take_turns
from benchmarks.suites.sensing import FAN, LAYOUT, MAX_RANGE, NUM_RAYS
from motorspace.worlds.layouts import layout
from motorspace.worlds.world import WalledWorld

STEPS, FEW_STEPS = 200, 50


def main() -> None:
    """Ours through Gymnasium, and one Python loop around each peer."""
    threads, world = int(os.environ["BENCHMARK_THREADS"]), layout(LAYOUT)
    contenders = [
        through_gymnasium(),
        with_pymunk(world),
        with_ir_sim(world),
        with_ratinabox(world),
        with_simple_playgrounds(),
    ]
    rates, first, foreign = take_turns(contenders)
    report(Launch("one agent's sensed steps", "steps", threads, rates, first, {}, foreign))


def through_gymnasium() -> Contender:
    env = gymnasium.make("motorspace/Forward-v0", layout=LAYOUT, max_episode_steps=10 * STEPS)
    actions = np.random.default_rng(0).uniform(-1, 1, (STEPS, 2)).astype(np.float32)

    def run() -> None:
        env.reset(seed=0)
        for action in actions:
            env.step(action)

    return Contender("motorspace", run, STEPS)


def with_pymunk(world: WalledWorld) -> Contender:
    """The same rules by pymunk's segment queries: a move that meets a wall does not happen."""
    space, anything = pymunk.Space(), pymunk.ShapeFilter()
    for a, b in np.asarray(world.walls, float):
        space.add(pymunk.Segment(space.static_body, tuple(a), tuple(b), 1e-3))
    commands = np.random.default_rng(0).uniform([-2.5, 0], [2.5, 1], (STEPS, 2)).tolist()
    fan = FAN.tolist()

    def run() -> None:
        x, y, heading = 5.0, 5.0, 0.0
        for turn, move in commands:
            heading += turn
            then = x + move * math.cos(heading), y + move * math.sin(heading)
            if space.segment_query_first((x, y), then, 1e-3, anything) is None:
                x, y = then
            ranges = []
            for angle in fan:
                gaze = heading + angle
                end = x + MAX_RANGE * math.cos(gaze), y + MAX_RANGE * math.sin(gaze)
                hit = space.segment_query_first((x, y), end, 0.0, anything)
                ranges.append(MAX_RANGE if hit is None else hit.alpha * MAX_RANGE)
            np.array(ranges, np.float32)

    return Contender("pymunk", run, STEPS)


def with_ir_sim(world: WalledWorld) -> Contender:
    """ir-sim: a robot with a lidar among the same walls, stopped by what it runs into."""
    robot = {
        "kinematics": {"name": "diff"},
        "shape": {"name": "circle", "radius": 0.01},
        "state": [5, 5, 0],
        "sensors": [
            {"name": "lidar2d", "range_max": MAX_RANGE, "angle_range": math.pi, "number": NUM_RAYS}
        ],
    }
    walls = [
        {"shape": {"name": "linestring", "vertices": wall}}
        for wall in np.asarray(world.walls, float).tolist()
    ]
    place = {"width": 40, "height": 40, "step_time": 1.0, "collision_mode": "stop"}
    with tempfile.NamedTemporaryFile("w", suffix=".yaml") as file:
        # JSON is YAML, too.
        json.dump({"world": place, "robot": [robot], "obstacle": walls}, file)
        file.flush()
        env = irsim.make(file.name, display=False, log_level="ERROR")
    commands = np.random.default_rng(0).uniform([0, -1], [1, 1], (FEW_STEPS, 2))[..., None]

    def run() -> None:
        for command in commands:
            env.step(command)
            env.get_lidar_scan()

    return Contender("ir-sim", run, FEW_STEPS)


def with_ratinabox(world: WalledWorld) -> Contender:
    """RatInABox: a rat that drifts between the same walls, and senses nothing."""
    box = Environment({"boundary": [[0, 0], [40, 0], [40, 40], [0, 40]]})
    for wall in np.asarray(world.walls, float)[4:]:
        box.add_wall(wall)
    rat = Agent(box)

    def run() -> None:
        for _ in range(FEW_STEPS):
            rat.update()

    return Contender("RatInABox, no sensors", run, FEW_STEPS)


def with_simple_playgrounds() -> Contender:
    """simple-playgrounds: a disc with a lidar in four rooms of its own."""
    from simple_playgrounds.agents.agents import BaseAgent
    from simple_playgrounds.agents.parts.controllers import External
    from simple_playgrounds.agents.sensors import Lidar
    from simple_playgrounds.engine import Engine
    from simple_playgrounds.playgrounds.layouts import GridRooms

    rooms = GridRooms((400, 400), (2, 2), doorstep_size=60)
    agent = BaseAgent(controller=External(), interactive=False, rotate=True, lateral=False)
    lidar = Lidar(
        agent.base_platform,
        invisible_elements=agent.parts,
        fov=180,
        resolution=NUM_RAYS,
        max_range=100,
    )
    agent.add_sensor(lidar)
    rooms.add_agent(agent)
    engine, still = Engine(rooms, time_limit=10**9), agent.controller.generate_null_actions()

    def run() -> None:
        for _ in range(FEW_STEPS):
            engine.step({agent: still})
            engine.update_observations()

    run()
    assert np.ptp(lidar.sensor_values) > 0, "the lidar sees walls"
    return Contender("simple-playgrounds", run, FEW_STEPS)


if __name__ == "__main__":
    main()
