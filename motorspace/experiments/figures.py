"""The paper's figures, drawn from finished runs."""

from collections.abc import Mapping
from pathlib import Path

import jax
import numpy as np
from matplotlib.figure import Figure

from motorspace._files import write_atomically
from motorspace.analysis.errors import CHUNK_SIZE
from motorspace.analysis.projections import ica, pca
from motorspace.experiments import paper, robots
from motorspace.experiments.measurement import draw_test
from motorspace.reports import figures
from motorspace.training.config import AgentName, SimulationConfig
from motorspace.training.runs import Run, load_run
from motorspace.worlds.layouts import layout, layout_names
from motorspace.worlds.sensors.range_fan import RangeFan
from motorspace.worlds.simulation import rollout
from motorspace.worlds.world import WalledWorld

AGENTS: tuple[AgentName, ...] = ("forward", "holonomic")
SHOWN_ROTATIONS = (0.2, 0.4, 0.8)
FIGURE_SEED = 2_000_003

Row = tuple[str, np.ndarray, np.ndarray]


def write_all(folder: Path) -> list[Path]:
    """Every figure that the finished runs below `folder` allow, as PNG files."""
    pictures = {"layouts": figures.layouts_figure({n: layout(n) for n in layout_names()})}
    for agent in AGENTS:
        environment, trajectories = world_figures(SimulationConfig(agent=agent))
        pictures |= {"environment": environment, f"trajectories-{agent}": trajectories}
        cells = {
            f"{agent}, r = {rotation} pi": folder / f"table/{agent}-{rotation}/model"
            for rotation in SHOWN_ROTATIONS
        }
        rows = _rows(cells)
        if rows:
            pictures[f"codes-{agent}"] = figures.codes_figure(rows)
            pictures[f"codes-{agent}-uniform"] = figures.codes_figure(
                rows, colours=figures.UNIFORM_COLOURS
            )
        run = _first_finished(folder / f"table/{agent}-0.8/model")
        if run is not None:
            codes, displacements = codes_of(run)
            row = (f"{agent}, r = 0.8 pi", ica(codes), displacements)
            pictures[f"ica-{agent}"] = figures.codes_figure([row], axis_name="IC")
    lattice = _rows(
        {kind.replace("-", " "): folder / f"lattice/{kind}/model" for kind in paper.LATTICE_KINDS}
    )
    if lattice:
        pictures["lattice"] = figures.lattice_figure(lattice)
    written = []
    for name, figure in pictures.items():
        written.append(folder / f"{name}.png")
        write_atomically(written[-1], figures.png(figure, dots_per_inch=70))
    return written


def world_figures(simulation: SimulationConfig) -> tuple[Figure, Figure]:
    """The walled world with two sensing agents, and eight trajectories of twelve steps in it."""
    world, agent, fan = simulation.build()
    assert isinstance(world, WalledWorld) and isinstance(fan, RangeFan)
    place_key, motor_key = jax.random.split(jax.random.key(3))
    starts = [world.place(key=key) for key in jax.random.split(place_key, 8)]
    paths = []
    for start, key in zip(starts, jax.random.split(motor_key, 8), strict=True):
        motors = jax.vmap(lambda k: agent.commands.sample(key=k))(jax.random.split(key, 12))
        paths.append(rollout(world, agent, start, motors))
    seen = figures.environment_figure(world, starts[:2], fan)
    return seen, figures.trajectories_figure(world, paths)


def write_robots(out: Path, logs: Path) -> None:
    """Codes of both robots' commands, coloured by the displacement that really happened."""
    rows = []
    for name, experiment in robots.EXPERIMENTS.items():
        codes, displacements = robots.codes_on_test(logs / name, experiment, out)
        rows.append((name.partition("-corrected")[0], pca(codes).coordinates, displacements))
    write_atomically(out / "robots.png", figures.png(figures.codes_figure(rows), dots_per_inch=70))


def codes_of(run: Run) -> tuple[np.ndarray, np.ndarray]:
    """Codes of fresh trajectories, and the displacements that these caused."""
    fresh = draw_test(run.config, CHUNK_SIZE, key=jax.random.key(FIGURE_SEED))
    experience = fresh.experience
    codes = run.encode(experience.motors, experience.num_steps)
    return np.asarray(codes), np.asarray(fresh.displacements.achieved)


def _rows(runs: Mapping[str, Path]) -> list[Row]:
    """Title, principal components and displacements, where a seed's run is finished."""
    rows = []
    for title, folder in runs.items():
        run = _first_finished(folder)
        if run is not None:
            codes, displacements = codes_of(run)
            rows.append((title, pca(codes).coordinates, displacements))
    return rows


def _first_finished(folder: Path) -> Run | None:
    """The finished run of the lowest seed."""
    finished = sorted(folder.glob("seed*/weights.safetensors"))
    return load_run(finished[0].parent) if finished else None
