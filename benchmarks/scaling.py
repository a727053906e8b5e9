"""How our own time and memory grow: `python -m benchmarks.scaling`, on one thread but for cores."""

import json
import math
import os
import subprocess
import sys
from collections.abc import Iterator
from datetime import date
from pathlib import Path
from typing import Any

import jax
import jax.numpy as jnp
from matplotlib.figure import Figure
from matplotlib.ticker import LogLocator, NullFormatter

from benchmarks.__main__ import OUT, machine
from benchmarks.harness import best_seconds
from benchmarks.programs import ONE_EPOCH, of_many, of_one, sampler
from benchmarks.suites.whole_table import side_by_side
from motorspace._files import write_json
from motorspace._types import Pose
from motorspace.training.config import RunConfig
from motorspace.training.data import simulated
from motorspace.training.program import train_epochs, train_epochs_together
from motorspace.training.settings import changed
from motorspace.trajectories.sampling import CHUNK_SIZE, SamplingPlan, simulate
from motorspace.worlds.layouts import layout
from motorspace.worlds.rooms import random_rooms
from motorspace.worlds.scenario import Scenario
from motorspace.worlds.sensors.range_fan import RangeFan
from motorspace.worlds.world import WalledWorld

FORWARD = RunConfig()

ONE_THREAD = "--xla_cpu_multi_thread_eigen=false"
PICTURE = Path("docs/pictures/scaling.png")
NUM_POSES = 16_384
NUM_UPDATES = 4
SIDES = (40.0, 60.0, 80.0, 100.0, 140.0, 200.0, 300.0, 450.0, 640.0, 800.0)
"""World units; random rooms of 8 units in such squares have 30 to 11,000 walls."""

CURVES = {
    "walls": "scan",
    "rays": "scan",
    "agents": "scan",
    "horizon": "trajectory",
    "batch": "sample of training",
    "units": "sample of training",
    "cores": "scan, trajectory, sample",
    "seeds": "sample of training",
}
"""What grows, and what is measured for each of."""


def main() -> None:
    """Measure every curve, write the numbers, draw them."""
    if asked := sys.argv[1:]:
        print(json.dumps(list(IN_CHILDREN[asked[0]]())))
        return
    os.sched_setaffinity(0, {0})
    os.environ["XLA_FLAGS"] = ONE_THREAD
    rows = [*by_walls(), *by_rays(), *by_agents(), *by_horizon(), *by_batch(), *by_units()]
    rows += [*by_cores(), *by_seeds()]
    described = {"command": "python -m benchmarks.scaling", "date": date.today().isoformat()}
    write_json(OUT / "scaling.json", described | {"machine": machine(), "rows": rows})
    draw(rows).savefig(PICTURE, dpi=70)


def by_walls() -> Iterator[dict[str, Any]]:
    """Scans in larger and larger buildings, with the index and without it."""
    for side in SIDES:
        world = random_rooms(size=side, key=jax.random.key(0)).world()
        plain = WalledWorld(world.walls, world.solids, world.bounds)
        yield scans("walls", len(world.walls), world, RangeFan(), NUM_POSES)
        yield scans("walls, all visited", len(world.walls), plain, RangeFan(), NUM_POSES)


def by_rays() -> Iterator[dict[str, Any]]:
    for rays in (1, 4, 9, 32, 128, 512, 1024):
        yield scans("rays", rays, layout("paper"), RangeFan(rays), NUM_POSES // 16)


def by_agents() -> Iterator[dict[str, Any]]:
    for agents in (1, 10, 100, 1_000, 10_000, 100_000, 1_000_000):
        yield scans("agents", agents, layout("paper"), RangeFan(), agents)


def by_horizon() -> Iterator[dict[str, Any]]:
    for horizon in (1, 4, 16, 64, 256):
        yield trajectories(horizon, CHUNK_SIZE // 8)


def by_batch() -> Iterator[dict[str, Any]]:
    for batch in (1, 10, 100, 1_000, 10_000):
        yield updates("batch", batch, FORWARD, batch)


def by_units() -> Iterator[dict[str, Any]]:
    """Units of the recurrent layer; the code has half as many, a layer of the predictor twice."""
    for units in (25, 50, 100, 200, 400):
        sizes = {"hidden_size": units, "code_size": units // 2, "width_size": 2 * units}
        yield updates("units", units, changed(FORWARD, sizes), 100)


def by_cores() -> Iterator[dict[str, Any]]:
    """The same work with one thread for each of more and more cores."""
    for cores in range(1, CORES + 1):
        for measured in on_cores("work", cores):
            yield measured | {"value": cores}


def by_seeds() -> Iterator[dict[str, Any]]:
    """Several seeds on all cores: as one program, and as processes of one thread each."""
    yield from on_cores("seeds", CORES)
    for num in range(1, CORES + 1):
        rate = sum(side_by_side(["forward"] * num))
        yield row("seeds, processes", num, 1 / rate, None)


def on_cores(what: str, cores: int) -> list[dict[str, Any]]:
    """What a process measures that may use so many cores."""
    chosen = ",".join(map(str, range(cores)))
    flags = ONE_THREAD if cores == 1 else ""
    command = ["taskset", "-c", chosen, sys.executable, "-m", "benchmarks.scaling", what]
    environment = os.environ | {"XLA_FLAGS": flags, "OMP_NUM_THREADS": str(cores)}
    done = subprocess.run(command, env=environment, check=True, stdout=subprocess.PIPE)
    return list(json.loads(done.stdout))


def work() -> Iterator[dict[str, Any]]:
    yield scans("cores, scan", 0, layout("paper"), RangeFan(), NUM_POSES)
    yield trajectories(simulated(FORWARD.data).horizon, CHUNK_SIZE) | {"what": "cores, trajectory"}
    for batch in (100, 1_000):
        yield updates(f"cores, sample in batches of {batch:,}", 0, FORWARD, batch)


def seeds_together() -> Iterator[dict[str, Any]]:
    config = changed(FORWARD, {"curriculum": 0.0})
    for num in (1, 2, 4, 8):
        given = *of_many(config, num, fresh=True), ONE_EPOCH
        trained = train_epochs_together.lower(*given).compile()  # type: ignore[attr-defined]
        seconds = best_seconds(
            lambda: jax.block_until_ready(trained(*given)),  # noqa: B023
            seconds=5.0,
        )
        samples = num * config.training.trajectories_per_epoch
        yield row("seeds, one program", num, seconds / samples, memory(trained.compiled) / samples)


IN_CHILDREN = {"work": work, "seeds": seeds_together}
CORES = os.cpu_count() or 1


def updates(what: str, value: int, config: RunConfig, batch: int) -> dict[str, Any]:
    """A few updates on the same transitions, for each of them."""
    num = max(NUM_UPDATES, 200 // batch) * batch
    size = {"trajectories_per_epoch": num, "batch_size": batch, "curriculum": 0.0}
    config = changed(config, size)
    given = *of_one(config, sampler(config)(jax.random.key(0), jnp.array(0))), ONE_EPOCH
    trained = train_epochs.lower(*given).compile()  # type: ignore[attr-defined]
    seconds = best_seconds(lambda: jax.block_until_ready(trained(*given)), seconds=2.0)
    return row(what, value, seconds / num, memory(trained.compiled) / num)


def trajectories(horizon: int, num: int) -> dict[str, Any]:
    lengths = jnp.array(horizon), jnp.array(horizon)
    plan = SamplingPlan(num, horizon, "resample")
    given, key = (Scenario(), plan, lengths), jax.random.key(0)
    drawn = simulate.lower(*given, key=key).compile()  # type: ignore[attr-defined]
    seconds = best_seconds(lambda: jax.block_until_ready(drawn(*given, key=key)))
    return row("horizon", horizon, seconds / num, memory(drawn.compiled) / num)


def scans(what: str, value: int, world: WalledWorld, fan: RangeFan, num: int) -> dict[str, Any]:
    keys = jax.random.split(jax.random.key(1), num)
    poses: Pose = jax.jit(jax.vmap(lambda key: world.random_pose(key=key)))(keys)
    sense = jax.jit(lambda poses: fan.sense(world, poses)).lower(poses).compile()
    seconds = best_seconds(lambda: jax.block_until_ready(sense(poses)))
    return row(what, value, seconds / num, memory(sense) / num)


def row(what: str, value: int, seconds: float, size: float | None) -> dict[str, Any]:
    return {"what": what, "value": value, "seconds": seconds, "bytes": size}


def memory(program: Any) -> int:
    """Bytes that a compiled program needs beside its arguments."""
    analysis = program.memory_analysis()
    return analysis.temp_size_in_bytes + analysis.output_size_in_bytes


def draw(rows: list[dict[str, Any]]) -> Figure:
    """Microseconds and bytes for each piece of work, against what grows."""
    figure = Figure(figsize=(14, 11), layout="constrained")
    half = len(CURVES) // 2
    panels = figure.subplots(4, half)
    for place, (what, item) in enumerate(CURVES.items()):
        block, column = divmod(place, half)
        times, sizes = panels[2 * block : 2 * block + 2, column]
        for name in sorted({r["what"] for r in rows if r["what"].split(",")[0] == what}):
            curve = [r for r in rows if r["what"] == name]
            values = [r["value"] for r in curve]
            style = {"marker": "o", "label": name.partition(", ")[2] or "motorspace"}
            times.loglog(values, [1e6 * r["seconds"] for r in curve], **style)
            sizes.loglog(values, [r["bytes"] or math.nan for r in curve], **style)
        times.set_ylabel(f"microseconds a\n{item}")
        sizes.set_ylabel(f"bytes a\n{item}")
        sizes.set_xlabel(what)
        for axis in (times.xaxis, sizes.xaxis, times.yaxis, sizes.yaxis):
            low, high = axis.get_view_interval()
            axis.set_major_locator(LogLocator(subs=(1, 2, 5) if high < 50 * low else (1,)))
            axis.set_major_formatter("{x:,g}")
            axis.set_minor_formatter(NullFormatter())
        if len(times.lines) > 1:
            times.legend(fontsize="small")
    return figure


if __name__ == "__main__":
    main()
