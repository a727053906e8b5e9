"""The paper's figures, drawn from finished runs."""

from collections.abc import Mapping
from pathlib import Path

import jax
import numpy as np

from motorspace._files import write_atomically
from motorspace._types import Pose
from motorspace.analysis.errors import CHUNK_SIZE
from motorspace.analysis.projections import ica, pca
from motorspace.experiments import paper, robots
from motorspace.experiments.measurement import draw_test
from motorspace.reports.figures import codes, style, worlds
from motorspace.training.config import AgentName, SimulationConfig
from motorspace.training.runs import Run, load_run
from motorspace.worlds.layouts import layout, layout_names
from motorspace.worlds.sensors import RangeFan
from motorspace.worlds.simulation import rollout
from motorspace.worlds.world import WalledWorld

AGENTS: tuple[AgentName, ...] = ("forward", "holonomic")
SHOWN_ROTATIONS = (0.2, 0.4, 0.8)
FIGURE_SEED = 2_000_003

Row = tuple[str, np.ndarray, np.ndarray]


def write_all(folder: Path) -> list[Path]:
    """Every figure that the finished runs below `folder` allow, as PNG files."""
    pictures = {"layouts": worlds.layouts_figure({n: layout(n) for n in layout_names()})}
    for agent in AGENTS:
        world, fan, starts, paths = example_walks(SimulationConfig(agent=agent))
        pictures |= {
            "environment": worlds.world_figure(world, starts[:2], fan),
            f"trajectories-{agent}": worlds.trajectories_figure(world, paths),
        }
        cells = {
            f"{agent}, r = {rotation} pi": folder / f"table/{agent}-{rotation}/model"
            for rotation in SHOWN_ROTATIONS
        }
        rows = _rows(cells)
        if rows:
            pictures[f"codes-{agent}"] = codes.codes_figure(rows, colours=style.JET)
            pictures[f"codes-{agent}-uniform"] = codes.codes_figure(rows)
        run = _first_finished(folder / f"table/{agent}-0.8/model")
        if run is not None:
            learned, displacements = codes_of(run)
            row = (f"{agent}, r = 0.8 pi", ica(learned), displacements)
            pictures[f"ica-{agent}"] = codes.codes_figure([row], colours=style.JET, axis_name="IC")
    lattice = _rows(
        {kind.replace("-", " "): folder / f"lattice/{kind}/model" for kind in paper.LATTICE_KINDS}
    )
    if lattice:
        pictures["lattice"] = codes.lattice_figure(lattice, colours="jet")
    written = []
    for name, figure in pictures.items():
        written.append(folder / f"{name}.png")
        write_atomically(written[-1], style.png(figure, dots_per_inch=70))
    return written


def example_walks(
    simulation: SimulationConfig,
) -> tuple[WalledWorld, RangeFan, list[Pose], list[Pose]]:
    """The walled world and its sensor, eight free poses, and twelve random steps from each."""
    world, agent, fan = simulation.build()
    assert isinstance(world, WalledWorld) and isinstance(fan, RangeFan)
    place_key, motor_key = jax.random.split(jax.random.key(3))
    starts = [world.place(key=key) for key in jax.random.split(place_key, 8)]
    paths = []
    for start, key in zip(starts, jax.random.split(motor_key, 8), strict=True):
        motors = jax.vmap(lambda k: agent.draw(key=k))(jax.random.split(key, 12))
        paths.append(rollout(world, agent, start, motors))
    return world, fan, starts, paths


def write_robots(out: Path, logs: Path) -> None:
    """Codes of both robots' commands, coloured by the displacement that really happened."""
    rows = []
    for name, experiment in robots.EXPERIMENTS.items():
        learned, displacements = robots.codes_on_test(logs / name, experiment, out)
        rows.append((name.partition("-corrected")[0], pca(learned).coordinates, displacements))
    write_atomically(
        out / "robots.png", style.png(codes.codes_figure(rows, colours=style.JET), dots_per_inch=70)
    )


def codes_of(run: Run) -> tuple[np.ndarray, np.ndarray]:
    """Codes of fresh trajectories, and the displacements that these caused."""
    fresh = draw_test(run.config, CHUNK_SIZE, key=jax.random.key(FIGURE_SEED))
    experience = fresh.experience
    learned = run.encode(experience.motors, experience.num_steps)
    return np.asarray(learned), np.asarray(fresh.displacements.achieved)


def _rows(runs: Mapping[str, Path]) -> list[Row]:
    """Title, principal components and displacements, where a seed's run is finished."""
    rows = []
    for title, folder in runs.items():
        run = _first_finished(folder)
        if run is not None:
            learned, displacements = codes_of(run)
            rows.append((title, pca(learned).coordinates, displacements))
    return rows


def _first_finished(folder: Path) -> Run | None:
    """The finished run of the lowest seed."""
    finished = sorted(folder.glob("seed*/weights.safetensors"))
    return load_run(finished[0].parent) if finished else None
