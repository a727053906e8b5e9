"""Learning from recorded robots: splits by blocks of time, stopping on validation alone."""

import dataclasses
from collections.abc import Callable
from dataclasses import dataclass, replace
from pathlib import Path
from statistics import fmean
from typing import Any

import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np

from motorspace.analysis.baselines import mean_error, mean_squared_error, persistence_error
from motorspace.analysis.probes import COMPONENTS, displacement_targets, linear_probe
from motorspace.models import ModelConfig, Scaling
from motorspace.training import Run, RunConfig, SimulationConfig, TrainingConfig, fit, init
from motorspace.trajectories import Experience, Trajectories
from motorspace.trajectories.logs import Recording, read_log, split_blocks, windows

NUM_BLOCKS = 20
SPLIT_SEED = 0


@dataclass(frozen=True)
class RobotData:
    """Transitions of one recording, in disjoint blocks of time."""

    train: Trajectories
    validation: Trajectories
    test: Trajectories
    scaling: Scaling


@dataclass(frozen=True)
class RobotExperiment:
    """What of a recording is one transition: how many scans, and which commands."""

    horizon_scans: int
    per_scan: bool
    """One composed command per scan interval, or every raw increment in it."""


EXPERIMENTS = {
    "freiburg-079-corrected.log.gz": RobotExperiment(horizon_scans=6, per_scan=True),
    "intel-corrected.log.gz": RobotExperiment(horizon_scans=1, per_scan=False),
}

MODELS: dict[str, dict[str, Any]] = {
    "model": {},
    "untrained": {"train_encoder": False},
    "no motors": {"encoder": "none"},
}
"""The paper's network and the reference rows that are trained."""

TRAINING = TrainingConfig(
    epochs=60,
    trajectories_per_epoch=2000,
    learning_rate=1e-3,
    schedule="constant",
    curriculum=0.0,
)


def robot_data(recording: Recording, experiment: RobotExperiment) -> RobotData:
    """The recording's transitions, split 60 / 20 / 20 by blocks of time."""
    everything = windows(
        recording, horizon_scans=experiment.horizon_scans, per_scan=experiment.per_scan
    )
    train, validation, test = (
        everything[np.asarray(rows)]
        for rows in split_blocks(
            recording,
            horizon=experiment.horizon_scans,
            num_blocks=NUM_BLOCKS,
            key=jax.random.key(SPLIT_SEED),
        )
    )
    executed = np.arange(train.experience.motors.shape[1]) < train.experience.num_steps[:, None]
    spread = np.asarray(train.experience.motors)[np.asarray(executed)].std(axis=0)
    motors = tuple(float(s) if s > 0 else 1.0 for s in spread)
    return RobotData(train, validation, test, Scaling(recording.sensor_scale, motors))


def fit_until_validation_worsens(
    data: RobotData, model: ModelConfig, training: TrainingConfig
) -> Run:
    """The network with the lowest error on the validation blocks over all epochs."""
    best: list[Any] = [float("inf"), None]
    log: list[dict[str, float]] = []

    def watch(state: Any, record: dict[str, float]) -> None:
        validation = data.validation.experience
        error = mean_squared_error(_predict(state.model, validation), validation.later_sensors)
        log.append({**record, "validation_error": error})
        if error < best[0]:
            best[:] = [error, state.model]

    horizon = data.train.experience.motors.shape[1]
    state = init(training, model, data.scaling, horizon=horizon)
    fit(training, model, state, data.train.experience, watch=watch)
    config = RunConfig(SimulationConfig(), model, training)
    return Run(config, best[1], tuple(log))


@eqx.filter_jit
def _predict(model: Any, experience: Experience) -> jax.Array:
    codes = jax.vmap(model.encode)(experience.motors, experience.num_steps)
    return jax.vmap(model.predict)(experience.sensors, codes)


def robot_results(
    path: Path,
    experiment: RobotExperiment,
    *,
    seeds: int,
    report: Callable[[str], None] = lambda line: None,
) -> dict[str, Any]:
    """Errors on the test blocks beside every reference row, and probes of the codes."""
    data = robot_data(read_log(path), experiment)
    test = data.test.experience
    results: dict[str, Any] = {
        "recording": path.name,
        **dataclasses.asdict(experiment),
        "windows": [len(data.train), len(data.validation), len(data.test)],
        "persistence": persistence_error(test),
        "mean": mean_error(test, data.train.experience.later_sensors.mean(axis=0)),
    }
    for name, change in MODELS.items():
        errors, probes = [], []
        for seed in range(seeds):
            model, training = replace(ModelConfig(), **change), replace(TRAINING, seed=seed)
            run = fit_until_validation_worsens(data, model, training)
            errors.append(mean_squared_error(run.predict(test), test.later_sensors))
            probes.append(probe(run, data))
            report(f"{path.name}, {name}, seed {seed}: {errors[-1]:.4g}")
        results[name] = {"mean": fmean(errors), "low": min(errors), "high": max(errors)}
        results[f"probe_r2 of {name}"] = {
            component: fmean(p[component] for p in probes) for component in COMPONENTS
        }
    best_blind = min(results["persistence"], results["mean"])
    results["to better of persistence and mean"] = results["model"]["mean"] / best_blind
    results["to no motors"] = results["model"]["mean"] / results["no motors"]["mean"]
    return results


def probe(run: Run, data: RobotData) -> dict[str, float]:
    """R2 on the test blocks of a linear probe fitted on the training blocks."""
    train, test = data.train, data.test
    codes = [run.encode(t.experience.motors, t.experience.num_steps) for t in (train, test)]
    targets = [displacement_targets(t.displacements.achieved) for t in (train, test)]
    r2 = linear_probe(codes[0], targets[0], codes[1], targets[1])
    return dict(zip(COMPONENTS, (float(jnp.round(v, 4)) for v in r2), strict=True))


def training_data(path: Path, config: RunConfig) -> tuple[RunConfig, Experience, Scaling]:
    """What `train --data` learns from: the training blocks of a recording."""
    experiment = RobotExperiment(config.simulation.horizon, per_scan=True)
    data = robot_data(read_log(path), experiment)
    per_epoch = min(config.training.trajectories_per_epoch, len(data.train))
    training = replace(config.training, trajectories_per_epoch=per_epoch, curriculum=0.0)
    return replace(config, training=training), data.train.experience, data.scaling
