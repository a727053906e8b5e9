"""Learning from recorded robots: splits by blocks of time, stopping on validation alone."""

import json
from collections.abc import Callable
from dataclasses import dataclass, replace
from pathlib import Path
from statistics import fmean
from typing import Any

import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np

from motorspace._files import locked, write_json
from motorspace.analysis.baselines import (
    mean_error,
    mean_squared_error,
    persistence_error,
)
from motorspace.analysis.coordinates import COMPONENTS
from motorspace.analysis.probes import displacement_targets, linear_probe
from motorspace.models.config import ModelConfig
from motorspace.models.model import Scaling
from motorspace.recordings.readers.base import read_log
from motorspace.recordings.recording import Recording
from motorspace.recordings.windows import split_blocks, windows
from motorspace.training.config import RunConfig, SimulationConfig, TrainingConfig
from motorspace.training.runs import Run, load_run, train
from motorspace.trajectories.derived import displacement_as_motors
from motorspace.trajectories.transitions import Trajectories

NUM_BLOCKS = 20
SPLIT_SEED = 0


@dataclass(frozen=True)
class RobotData:
    """Transitions of one recording, in disjoint blocks of time."""

    train: Trajectories
    """Of every number of scans from the shortest to the longest."""
    validation: Trajectories
    test: Trajectories
    scaling: Scaling

    def told_displacements(self) -> "RobotData":
        """The oracle's data: one «command» each, the true displacement."""
        reach = float(np.abs(np.asarray(self.train.displacements.achieved[:, :2])).max())
        train, validation, test = (
            Trajectories(displacement_as_motors(part, reach), part.displacements)
            for part in (self.train, self.validation, self.test)
        )
        return RobotData(train, validation, test, Scaling(self.scaling.sensors, (1.0,) * 4))


@dataclass(frozen=True)
class RobotExperiment:
    """What of a recording is one transition: how many scans, and which commands."""

    horizon_scans: int
    shortest_scans: int
    """Training also sees transitions over fewer scans, down to these."""
    per_scan: bool
    """One composed command per scan interval, or every raw increment in it."""


EXPERIMENTS = {
    "freiburg-079-corrected.log.gz": RobotExperiment(6, 1, per_scan=True),
    "intel-corrected.log.gz": RobotExperiment(1, 1, per_scan=False),
}

MODELS: dict[str, dict[str, Any]] = {
    "model": {},
    "untrained": {"train_encoder": False},
    "no motors": {"encoder": "none"},
    "oracle": {"encoder": "identity"},
}
"""The paper's network and the reference rows that are trained."""

TRAINING = TrainingConfig(
    epochs=60,
    trajectories_per_epoch=2000,
    learning_rate=1e-3,
    schedule="constant",
    curriculum=0.0,
    average=0.99,
)


def robot_data(recording: Recording, experiment: RobotExperiment) -> RobotData:
    """The recording's transitions, split 60 / 20 / 20 by blocks of time."""
    longest = experiment.horizon_scans
    train, validation, test = _split(recording, experiment, longest)
    shorter = [
        _split(recording, experiment, scans)[0]
        for scans in range(experiment.shortest_scans, longest)
    ]
    padded = [_padded(part, train.experience.motors.shape[1]) for part in (*shorter, train)]
    together = jax.tree.map(lambda *parts: jnp.concatenate(parts), *padded)
    executed = np.arange(train.experience.motors.shape[1]) < train.experience.num_steps[:, None]
    spread = np.asarray(train.experience.motors)[np.asarray(executed)].std(axis=0)
    motors = tuple(float(s) if s > 0 else 1.0 for s in spread)
    return RobotData(together, validation, test, Scaling(recording.sensor_scale, motors))


def _split(
    recording: Recording, experiment: RobotExperiment, scans: int
) -> tuple[Trajectories, Trajectories, Trajectories]:
    everything = windows(recording, horizon=scans, per_scan=experiment.per_scan)
    train, validation, test = split_blocks(
        recording, horizon=scans, num_blocks=NUM_BLOCKS, key=jax.random.key(SPLIT_SEED)
    )
    return everything[train], everything[validation], everything[test]


def _padded(part: Trajectories, horizon: int) -> Trajectories:
    """The same trajectories, their motor sequences padded with zeros to one horizon."""
    motors = part.experience.motors
    padded = jnp.pad(motors, ((0, 0), (0, horizon - motors.shape[1]), (0, 0)))
    return eqx.tree_at(lambda t: t.experience.motors, part, padded)


def robot_results(
    log: Path,
    experiment: RobotExperiment,
    out: Path,
    *,
    seeds: int,
    report: Callable[[str], None] = lambda line: None,
) -> dict[str, Any]:
    """Errors on the test blocks beside every reference row, and probes of the codes.

    Every run keeps its folder below `out`; finished ones are read, never repeated.
    """
    recording = read_log(log)
    data = robot_data(recording, experiment)
    # Without motors a short transition cannot be told from a long one: such a model is the
    # stronger reference when it sees the tested length alone.
    one_length = replace(experiment, shortest_scans=experiment.horizon_scans)
    views = {
        "no motors": robot_data(recording, one_length),
        "oracle": data.told_displacements(),
    }
    test = data.test.experience
    results: dict[str, Any] = {
        "recording": log.name,
        "windows": [len(data.train), len(data.validation), len(data.test)],
        "seeds": seeds,
        "persistence": persistence_error(test),
        "mean": mean_error(test, data.train.experience.later_sensors.mean(axis=0)),
    }
    for name in MODELS:
        measured = []
        for seed in range(seeds):
            folder = run_folder(out, log, name, seed)
            measured.append(_run(views.get(name, data), name, experiment, seed, folder))
            report(f"{folder}: {measured[-1]['error']:.4g}")
        errors = [m["error"] for m in measured]
        results[name] = {"mean": fmean(errors), "low": min(errors), "high": max(errors)}
        results[f"probe_r2 of {name}"] = {
            component: fmean(m["probe_r2"][component] for m in measured) for component in COMPONENTS
        }
    return results


def run_folder(out: Path, log: Path, name: str, seed: int) -> Path:
    """Where a run on a recording stands."""
    return out / "robots" / log.name.partition(".")[0] / name.replace(" ", "-") / f"seed{seed}"


def _run(
    seen: RobotData, name: str, experiment: RobotExperiment, seed: int, folder: Path
) -> dict[str, Any]:
    results = folder / "results.json"
    if results.exists():
        return dict(json.loads(results.read_text()))
    simulation = SimulationConfig(horizon=experiment.horizon_scans)
    model = replace(ModelConfig(initial_weights="scaled"), **MODELS[name])
    config = RunConfig(simulation, model, replace(TRAINING, seed=seed))
    run = train(
        config,
        seen.train.experience,
        seen.scaling,
        folder,
        validation=seen.validation.experience,
        resume=True,
    )
    measured = measure_on(run, seen)
    with locked(folder):
        write_json(results, measured)
    return measured


def measure_on(run: Run, data: RobotData) -> dict[str, Any]:
    """Error on the test blocks, and R2 there of a linear probe fitted on the training blocks."""
    test = data.test.experience
    codes = [run.encode(e.motors, e.num_steps) for e in (data.train.experience, test)]
    targets = [displacement_targets(t.displacements.achieved) for t in (data.train, data.test)]
    r2 = linear_probe(codes[0], targets[0], codes[1], targets[1])
    return {
        "error": mean_squared_error(run.predict(test), test.later_sensors),
        "persistence": persistence_error(test),
        "probe_r2": dict(zip(COMPONENTS, (float(jnp.round(v, 4)) for v in r2), strict=True)),
    }


def codes_on_test(
    log: Path, experiment: RobotExperiment, out: Path
) -> tuple[np.ndarray, np.ndarray]:
    """Codes of the first seed's network on the test blocks, and the true displacements."""
    data = robot_data(read_log(log), experiment)
    run = load_run(run_folder(out, log, "model", 0))
    codes = run.encode(data.test.experience.motors, data.test.experience.num_steps)
    return np.asarray(codes), np.asarray(data.test.displacements.achieved)


def data_for(log: Path, simulation: SimulationConfig) -> RobotData:
    """What `--data` learns from and is measured on: one command per scan interval."""
    shortest = simulation.min_horizon or simulation.horizon
    experiment = RobotExperiment(simulation.horizon, shortest, per_scan=True)
    return robot_data(read_log(log), experiment)
