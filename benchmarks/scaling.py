"""How our own time and memory grow: `python -m benchmarks.scaling`, on one thread."""

from collections.abc import Iterator
from dataclasses import replace
from datetime import date
from pathlib import Path
from typing import Any

import jax
import jax.numpy as jnp
from matplotlib.figure import Figure
from matplotlib.ticker import LogLocator, NullFormatter

from benchmarks.__main__ import OUT, machine
from benchmarks.harness import best_seconds
from motorspace import (
    ForwardAgent,
    Pose,
    RangeFan,
    RunConfig,
    WalledWorld,
    fresh_experience,
    layout,
    simulation_scaling,
)
from motorspace._files import write_json
from motorspace.experiments.paper import FORWARD
from motorspace.training import init
from motorspace.training.fit import train_epoch
from motorspace.trajectories.sampling import CHUNK_SIZE, SamplingPlan, simulate
from motorspace.worlds.layouts import random_rooms

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
}
"""What grows, and what is measured for each of."""


def main() -> None:
    """Measure every curve, write the numbers, draw them."""
    rows = [*by_walls(), *by_rays(), *by_agents(), *by_horizon(), *by_batch(), *by_units()]
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
        model = replace(
            FORWARD.model, hidden_size=units, code_size=units // 2, width_size=2 * units
        )
        yield updates("units", units, replace(FORWARD, model=model), 100)


def updates(what: str, value: int, config: RunConfig, batch: int) -> dict[str, Any]:
    """A few updates on the same transitions, for each of them."""
    num = max(NUM_UPDATES, 200 // batch) * batch
    size = replace(config.training, trajectories_per_epoch=num, batch_size=batch, curriculum=0.0)
    config = replace(config, training=size)
    data = jax.jit(fresh_experience(config))(jax.random.key(0), jnp.array(0))
    horizon = config.simulation.horizon
    state = init(config.training, config.model, simulation_scaling(config), horizon=horizon)
    given, key = (state, data, config.training, config.model), jax.random.key(0)
    trained = train_epoch.lower(*given, key=key).compile()
    seconds = best_seconds(lambda: jax.block_until_ready(trained(*given, key=key)), seconds=2.0)
    return row(what, value, seconds / num, memory(trained.compiled) / num)


def trajectories(horizon: int, num: int) -> dict[str, Any]:
    lengths = jnp.array(horizon), jnp.array(horizon)
    plan = SamplingPlan(num, horizon, "resample")
    given, key = (layout("paper"), ForwardAgent(), RangeFan(), plan, lengths), jax.random.key(0)
    drawn = simulate.lower(*given, key=key).compile()
    seconds = best_seconds(lambda: jax.block_until_ready(drawn(*given, key=key)))
    return row("horizon", horizon, seconds / num, memory(drawn.compiled) / num)


def scans(what: str, value: int, world: WalledWorld, fan: RangeFan, num: int) -> dict[str, Any]:
    keys = jax.random.split(jax.random.key(1), num)
    poses: Pose = jax.jit(jax.vmap(lambda key: world.draw(key=key)))(keys)
    sense = jax.jit(lambda poses: fan.sense(world, poses)).lower(poses).compile()
    seconds = best_seconds(lambda: jax.block_until_ready(sense(poses)))
    return row(what, value, seconds / num, memory(sense) / num)


def row(what: str, value: int, seconds: float, size: float) -> dict[str, Any]:
    return {"what": what, "value": value, "seconds": seconds, "bytes": size}


def memory(program: Any) -> int:
    """Bytes that a compiled program needs beside its arguments."""
    analysis = program.memory_analysis()
    return analysis.temp_size_in_bytes + analysis.output_size_in_bytes


def draw(rows: list[dict[str, Any]]) -> Figure:
    """Microseconds and bytes for each piece of work, against what grows."""
    figure = Figure(figsize=(18, 5.4), layout="constrained")
    panels = figure.subplots(2, len(CURVES), sharex="col")
    for column, (what, item) in enumerate(CURVES.items()):
        for name in sorted({r["what"] for r in rows if r["what"].split(",")[0] == what}):
            curve = [r for r in rows if r["what"] == name]
            values = [r["value"] for r in curve]
            style = {"marker": "o", "label": name.partition(", ")[2] or "motorspace"}
            panels[0, column].loglog(values, [1e6 * r["seconds"] for r in curve], **style)
            panels[1, column].loglog(values, [r["bytes"] for r in curve], **style)
        panels[0, column].set_ylabel(f"microseconds a\n{item}")
        panels[1, column].set_ylabel(f"bytes a\n{item}")
        panels[1, column].set_xlabel(what)
        for axis in (panels[1, column].xaxis, panels[0, column].yaxis, panels[1, column].yaxis):
            low, high = axis.get_view_interval()
            axis.set_major_locator(LogLocator(subs=(1, 2, 5) if high < 50 * low else (1,)))
            axis.set_major_formatter("{x:,g}")
            axis.set_minor_formatter(NullFormatter())
    panels[0, 0].legend()
    return figure


if __name__ == "__main__":
    main()
