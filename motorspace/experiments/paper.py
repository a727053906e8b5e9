"""The paper's experiments as data: names -> configurations; what each run is measured at."""

import json
from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace
from datetime import date
from pathlib import Path
from typing import Any, Literal

from motorspace._errors import UserError
from motorspace._files import locked, write_json
from motorspace._types import Watch
from motorspace.experiments import references
from motorspace.experiments.measurement import measure
from motorspace.training.config import RunConfig, SimulationConfig, TrainingConfig
from motorspace.training.runs import Run, initial_run, train

Budget = Literal["quick", "fifth", "half", "paper"]
Part = Literal["model", "oracle", "untrained", "shuffled", "supervised", "initial"]
Experiment = Literal["lattice", "table", "floor", "points", "topology", "figures", "robots", "all"]

ROTATIONS = (0.2, 0.4, 0.6, 0.8, 1.0, 1.2)
PAPER_ERRORS = {
    "forward": (2.32, 2.41, 2.34, 2.33, 2.35, 2.32),
    "holonomic": (1.54, 2.21, 2.30, 2.32, 2.63, 2.67),
}
"""The paper's table I: mean squared error for each of `ROTATIONS`."""

LATTICE = RunConfig(
    SimulationConfig(agent="lattice", horizon=5, min_horizon=1),
    training=TrainingConfig(
        epochs=500, trajectories_per_epoch=50_000, learning_rate=2e-3, curriculum=0.0
    ),
)
FORWARD = RunConfig(SimulationConfig(agent="forward"))
HOLONOMIC = RunConfig(SimulationConfig(agent="holonomic"))
PRESETS = {"lattice": LATTICE, "forward": FORWARD, "holonomic": HOLONOMIC}
"""The paper's systems, with the default of every point it leaves open."""

PLAIN: dict[str, Any] = {
    "model": {"initial_weights": "uniform", "motor_scaling": "maximum"},
    "training": {"learning_rate": 1e-3, "schedule": "constant", "curriculum": 0.0},
}
"""The paper's own recipe as far as it is told: nothing that helps to leave the plateau."""

LATTICE_KINDS: dict[str, dict[str, Any]] = {
    "without-inverse": {},
    "with-inverse": {"inverse_weight": 0.04},
    "with-slowness": {"inverse_weight": 0.04, "slowness_weight": 0.04},
}
"""The paper's two lattice systems, and one whose codes also have to be slow."""

EPOCHS_SHARE: dict[Budget, float] = {"quick": 0.05, "fifth": 0.2, "half": 0.5, "paper": 1.0}
"""The share of the paper's epochs that each budget trains for."""
TEST_TRAJECTORIES: dict[Budget, int] = {
    "quick": 100_000,
    "fifth": 200_000,
    "half": 1_000_000,
    "paper": 1_000_000,
}

SOURCES: dict[Part, references.Lesson] = {
    "oracle": references.oracle,
    "shuffled": references.shuffled,
    "supervised": references.supervised,
}
"""What the reference rows learn from that do not learn from experience as it is."""

MEASURED = frozenset({"name", "part", "date", "seed", "epochs", "recipe", "errors", "probe_r2"})
"""What every run's results tell."""


@dataclass(frozen=True)
class Job:
    """One run of an experiment: where it stands, what it is, what it is measured at."""

    name: str
    config: RunConfig
    part: Part = "model"
    measure: Callable[[Run, int], dict[str, Any]] = measure
    learns_from: references.Lesson | None = None
    """Where that is not what its part learns from."""

    @property
    def lesson(self) -> references.Lesson:
        """What makes the run's experience."""
        return self.learns_from or SOURCES.get(self.part, references.learned)

    @property
    def folder(self) -> str:
        return f"{self.name}/{self.part}/seed{self.config.training.seed}"


def table_jobs(budget: Budget, *, seeds: int, parts: tuple[Part, ...]) -> list[Job]:
    """The runs behind the paper's table I, one seed of every cell before the next seed."""
    return [
        Job(
            f"table/{agent}-{rotation}",
            variant(cell(agent, rotation, budget, seed), part),
            part,
        )
        for seed in range(seeds)
        for rotation in ROTATIONS
        for agent in ("forward", "holonomic")
        for part in parts
    ]


def lattices(budget: Budget, seed: int) -> dict[str, RunConfig]:
    """The lattice systems by what they are called."""
    base = _budgeted(LATTICE, budget, seed)
    return {
        kind: replace(base, model=replace(base.model, **weights))
        for kind, weights in LATTICE_KINDS.items()
    }


def lattice_jobs(budget: Budget, *, seeds: int) -> list[Job]:
    """The runs of every kind, and an untrained encoder."""
    jobs = []
    for seed in range(seeds):
        kinds = lattices(budget, seed)
        jobs += [Job(f"lattice/{kind}", config) for kind, config in kinds.items()]
        untrained = variant(kinds["without-inverse"], "untrained")
        jobs.append(Job("lattice/without-inverse", untrained, "untrained"))
    return jobs


POINTS: dict[str, dict[str, dict[str, Any]]] = {
    "every default": {},
    "collision block": {"simulation": {"collision": "block"}},
    "head-rule turn": {"simulation": {"head_rule": "turn"}},
    "head-start random": {"simulation": {"head_start": "random"}},
    "head-start random, sensed": {"simulation": {"head_start": "random", "sense_head": True}},
    "layout four_rooms": {"simulation": {"layout": "four_rooms"}},
    "layout rooms-1": {"simulation": {"layout": "rooms:1"}},
    "2,000 trajectories for all epochs": {"training": {"fresh": False}},
    "motor-scaling maximum": {"model": {"motor_scaling": "maximum"}},
    "initial-weights scaled": {"model": {"initial_weights": "scaled"}},
    "initial-weights uniform": {"model": {"initial_weights": "uniform"}},
    "schedule constant": {"training": {"schedule": "constant", "learning_rate": 1e-3}},
    "curriculum 0": {"training": {"curriculum": 0.0}},
    "plain recipe": PLAIN,
}
"""The paper's open points: what a cell is changed in, one at a time."""

POINTS_CELL = ("holonomic", 0.8)
"""The cell in which they are compared: large rotations, where the recipe matters."""


def point_jobs(budget: Budget, *, seeds: int) -> list[Job]:
    """The runs behind the table of open points."""
    return [
        Job(f"points/{name}", changed(cell(*POINTS_CELL, budget, seed), change))
        for seed in range(seeds)
        for name, change in POINTS.items()
    ]


def changed(config: RunConfig, change: dict[str, dict[str, Any]]) -> RunConfig:
    """The configuration with other fields in some of its parts."""
    parts = {part: replace(getattr(config, part), **fields) for part, fields in change.items()}
    return replace(config, **parts)


def changed_where_default(config: RunConfig, change: dict[str, dict[str, Any]]) -> RunConfig:
    """The same, but for fields that already differ from the agent's preset."""
    preset = PRESETS[config.simulation.agent]
    open_fields = {
        part: {
            name: value
            for name, value in fields.items()
            if getattr(getattr(config, part), name) == getattr(getattr(preset, part), name)
        }
        for part, fields in change.items()
    }
    return changed(config, open_fields)


def cell(agent: str, rotation: float, budget: Budget, seed: int) -> RunConfig:
    """One cell of the paper's table I: an agent and its largest rotation, in units of pi."""
    base = _budgeted(PRESETS[agent], budget, seed)
    return replace(base, simulation=replace(base.simulation, max_rotation=rotation))


def _budgeted(config: RunConfig, budget: Budget, seed: int) -> RunConfig:
    epochs = max(1, round(config.training.epochs * EPOCHS_SHARE[budget]))
    return replace(config, training=replace(config.training, epochs=epochs, seed=seed))


def variant(config: RunConfig, part: Part) -> RunConfig:
    """The configuration of a reference row under the same budget."""
    if part == "oracle":
        model = replace(config.model, encoder="identity")
    elif part == "untrained":
        model = replace(config.model, train_encoder=False)
    else:
        return config
    return replace(config, model=model, training=replace(config.training, curriculum=0.0))


def run_job(
    job: Job,
    out: Path,
    *,
    num_test: int,
    watch: Watch = lambda record: None,
) -> dict[str, Any]:
    """Train and measure one job in its folder; finished work is read, never repeated."""
    folder = out / job.folder
    results = folder / "results.json"
    if results.exists():
        return _read_results(results)
    if job.part == "initial":
        run = initial_run(job.config)
    else:
        source, scaling = job.lesson(job.config)
        run = train(job.config, source, scaling, folder, resume=True, watch=watch)
    made = {"name": job.name, "part": job.part, "date": date.today().isoformat()}
    measured = made | job.measure(run, num_test)
    with locked(folder):
        write_json(results, measured)
    return measured


def finished(out: Path) -> Iterator[dict[str, Any]]:
    """The results of every finished run below a folder. Raises `UserError` for broken ones."""
    for path in sorted(out.glob("*/*/*/seed*/results.json")):
        yield _read_results(path)


def _read_results(path: Path) -> dict[str, Any]:
    """What a run was measured at. Raises `UserError` when that is broken or of another version."""
    try:
        results = dict(json.loads(path.read_bytes()))
        missing = MEASURED - results.keys()
    except (ValueError, TypeError):
        missing = MEASURED
    if missing:
        raise UserError(
            f"the results lack {', '.join(sorted(missing))}",
            where=path,
            remedy="delete this file: the run is then measured again, and not trained again",
        )
    return results
