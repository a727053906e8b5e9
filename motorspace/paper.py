"""The paper's experiments as data: names -> configurations; what each run is measured at."""

import dataclasses
import json
from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any, Literal

import jax
import jax.numpy as jnp
import numpy as np

from motorspace._types import Count, Key
from motorspace.analysis.baselines import with_displacement_as_motors
from motorspace.analysis.errors import prediction_errors
from motorspace.analysis.probes import (
    COMPONENTS,
    displacement_targets,
    linear_probe,
    within_to_total_variance,
)
from motorspace.analysis.projections import pca
from motorspace.models import ModelConfig, Scaling
from motorspace.training.config import (
    RunConfig,
    SimulationConfig,
    TrainingConfig,
    fresh_experience,
    simulation_scaling,
    simulator,
)
from motorspace.training.runs import Run, locked, train, write_json
from motorspace.trajectories import Experience, ExperienceSource, Trajectories, sample

Budget = Literal["quick", "fifth", "paper"]
Part = Literal["model", "oracle", "untrained"]

ROTATIONS = (0.2, 0.4, 0.6, 0.8, 1.0, 1.2)
PAPER_ERRORS = {
    "forward": (2.32, 2.41, 2.34, 2.33, 2.35, 2.32),
    "holonomic": (1.54, 2.21, 2.30, 2.32, 2.63, 2.67),
}
"""The paper's table I: mean squared error for each of `ROTATIONS`."""

LATTICE = RunConfig(
    SimulationConfig(agent="lattice", horizon=5, min_horizon=1),
    ModelConfig(),
    TrainingConfig(epochs=500, trajectories_per_epoch=50_000, batch_size=1000),
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

LATTICE_INVERSE_WEIGHT = 0.05
EPOCHS_SHARE: dict[Budget, float] = {"quick": 0.05, "fifth": 0.2, "paper": 1.0}
"""The share of the paper's epochs that each budget trains for."""
TEST_TRAJECTORIES: dict[Budget, int] = {
    "quick": 100_000,
    "fifth": 200_000,
    "paper": 1_000_000,
}
TEST_SEED = 1_000_003
"""Evaluation draws from its own stream: training seeds stay far below it."""


@dataclass(frozen=True)
class Job:
    """One run of an experiment: where it stands, what it is, what it is measured at."""

    name: str
    config: RunConfig
    part: Part = "model"

    @property
    def folder(self) -> str:
        return f"{self.name}/{self.part}/seed{self.config.training.seed}"


def table_jobs(budget: Budget, *, seeds: int, parts: tuple[Part, ...]) -> list[Job]:
    """The runs behind the paper's table I, one seed of every cell before the next seed."""
    return [
        Job(
            f"table/{agent}-{rotation}",
            _variant(_table_config(agent, rotation, budget, seed), part),
            part,
        )
        for seed in range(seeds)
        for part in parts
        for rotation in ROTATIONS
        for agent in ("forward", "holonomic")
    ]


def lattice_jobs(budget: Budget, *, seeds: int) -> list[Job]:
    """The lattice runs: without and with the inverse model, and an untrained encoder."""
    jobs = []
    for seed in range(seeds):
        base = _budgeted(LATTICE, budget, seed)
        with_inverse = replace(base.model, inverse_weight=LATTICE_INVERSE_WEIGHT)
        jobs += [
            Job("lattice/without-inverse", base),
            Job("lattice/with-inverse", replace(base, model=with_inverse)),
            Job("lattice/without-inverse", _variant(base, "untrained"), "untrained"),
        ]
    return jobs


def _table_config(agent: str, rotation: float, budget: Budget, seed: int) -> RunConfig:
    base = _budgeted(PRESETS[agent], budget, seed)
    return replace(base, simulation=replace(base.simulation, max_rotation=rotation))


def _budgeted(config: RunConfig, budget: Budget, seed: int) -> RunConfig:
    epochs = max(1, round(config.training.epochs * EPOCHS_SHARE[budget]))
    return replace(config, training=replace(config.training, epochs=epochs, seed=seed))


def _variant(config: RunConfig, part: Part) -> RunConfig:
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
    watch: Callable[[dict[str, float]], None] = lambda record: None,
) -> dict[str, Any]:
    """Train and measure one job in its folder; finished work is read, never repeated."""
    folder = out / job.folder
    results = folder / "results.json"
    if results.exists():
        return dict(json.loads(results.read_text()))
    source: ExperienceSource
    if job.part == "oracle":
        source, scaling = oracle_source(job.config)
    else:
        source, scaling = fresh_experience(job.config), simulation_scaling(job.config)
    run = train(job.config, source, scaling, folder, resume=True, watch=watch)
    measured = {"name": job.name, "part": job.part, **measure(run, num=num_test)}
    with locked(folder):
        write_json(results, measured)
    return measured


def oracle_source(
    config: RunConfig,
) -> tuple[Callable[[Key, Count], Experience], Scaling]:
    """Fresh experience whose command is the true displacement itself, and its scaling."""
    draw, reach = simulator(config), float(config.simulation.horizon)
    sensors = simulation_scaling(config).sensors
    return (
        lambda key, epoch: with_displacement_as_motors(draw(key, epoch), reach),
        Scaling(sensors, (1.0,) * 4),
    )


def draw_test(config: RunConfig, num: int, *, key: Key) -> Trajectories:
    """Fresh trajectories of the run's own kind, at its full horizons."""
    world, agent, sensor = config.simulation.build()
    simulation = config.simulation
    return sample(
        world,
        agent,
        sensor,
        num=num,
        horizon=simulation.horizon,
        min_horizon=simulation.min_horizon,
        collision=simulation.collision,
        key=key,
    )


def as_seen_by(config: RunConfig, trajectories: Trajectories) -> Experience:
    """What the run's network is given: the oracle sees displacements for commands."""
    if config.model.encoder == "identity":
        return with_displacement_as_motors(trajectories, float(config.simulation.horizon))
    return trajectories.experience


def measure(run: Run, *, num: int) -> dict[str, Any]:
    """Errors on `num` fresh trajectories, the codes' variance, and linear probes of them."""
    config = run.config
    errors_key, probe_key = jax.random.split(jax.random.key(TEST_SEED + config.training.seed))

    def draw(key: Key, count: int) -> Experience:
        return as_seen_by(config, draw_test(config, count, key=key))

    errors = prediction_errors(run.predict, draw, num=num, key=errors_key)
    probed = draw_test(config, 8000, key=probe_key)
    seen = as_seen_by(config, probed)
    codes = run.encode(seen.motors, seen.num_steps)
    targets = displacement_targets(probed.displacements.achieved)
    half = len(codes) // 2
    r2 = linear_probe(codes[:half], targets[:half], codes[half:], targets[half:])
    variance = float(jnp.mean(jnp.var(codes, axis=0)))
    measured = {
        "seed": config.training.seed,
        "epochs": config.training.epochs,
        "errors": dataclasses.asdict(errors),
        "code_variance": variance,
        "probe_r2": dict(zip(COMPONENTS, (round(float(v), 4) for v in r2), strict=True)),
    }
    return measured | (_lattice_measures(run, num) if config.simulation.agent == "lattice" else {})


def _lattice_measures(run: Run, num: int) -> dict[str, Any]:
    """Share of exactly predicted nodes and orientations, and how the codes are organised."""
    config = run.config
    trajectories = draw_test(config, min(num, 50_000), key=jax.random.key(TEST_SEED - 1))
    experience = trajectories.experience
    codes = run.encode(experience.motors, experience.num_steps)
    displacements = np.asarray(trajectories.displacements.achieved)
    targets = displacement_targets(trajectories.displacements.achieved)
    half = len(codes) // 2
    r2 = {}
    for count in (2, 3):
        first = pca(codes, count).coordinates
        fit = linear_probe(first[:half], targets[:half], first[half:], targets[half:])
        r2[str(count)] = dict(zip(COMPONENTS, (round(float(v), 4) for v in fit), strict=True))
    return {
        "accuracy": lattice_accuracy(run, experience),
        "within_to_total": within_to_total_variance(codes, jnp.asarray(displacements[:, :2])),
        "within_to_total_pose": within_to_total_variance(codes, targets),
        "r2_from_components": r2,
    }


def lattice_accuracy(run: Run, experience: Experience) -> float:
    """Share of transitions whose node and orientation are both predicted exactly."""
    predicted = run.predict(experience)
    later = experience.later_sensors
    node = jnp.argmax(predicted[:, :-4], axis=1) == jnp.argmax(later[:, :-4], axis=1)
    turn = jnp.argmax(predicted[:, -4:], axis=1) == jnp.argmax(later[:, -4:], axis=1)
    return float(jnp.mean(node & turn))


def finished(out: Path) -> Iterator[dict[str, Any]]:
    """The results of every finished run below a folder."""
    for path in sorted(out.glob("*/*/*/seed*/results.json")):
        yield json.loads(path.read_text())
