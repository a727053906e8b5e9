"""Views: what colours cost beside distances, at the same poses in the same world."""

import os

import equinox as eqx
import jax

from benchmarks.harness import Contender, Launch, report, take_turns
from benchmarks.suites.sensing import scattered
from motorspace.worlds.layouts import layout
from motorspace.worlds.scenario import Scenario
from motorspace.worlds.sensors.base import AbstractSensor
from motorspace.worlds.sensors.range_fan import RangeFan
from motorspace.worlds.sensors.retina import Retina

NUM_RAYS = 32


def main() -> None:
    """Time a retina and a fan of as many rays as it has pixels."""
    samples, paint = int(os.environ["SAMPLES"]), os.environ["PAINT"]
    world = layout("paper", paint=paint)
    poses, _ = scattered(world)

    def contender(name: str, sensor: AbstractSensor) -> Contender:
        scenario = Scenario(world, sensor=sensor)
        sense = eqx.filter_jit(lambda scenario, poses: scenario.sense(poses))
        run = lambda: jax.block_until_ready(sense(scenario, poses))  # noqa: E731
        return Contender(name, run, poses.x.size)

    contenders = [
        contender("motorspace", Retina(NUM_RAYS, samples=samples)),
        contender("RangeFan", RangeFan(NUM_RAYS)),
    ]
    rates, first, foreign = take_turns(contenders)
    work = f"views, {paint}, rays of each pixel: {samples}"
    threads = int(os.environ["BENCHMARK_THREADS"])
    report(Launch(work, "views", threads, rates, first, {}, foreign))


if __name__ == "__main__":
    main()
