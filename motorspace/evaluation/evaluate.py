"""Measure a run on what it learned from: fresh trajectories, or the test blocks of its log."""

from collections.abc import Iterator, Mapping
from dataclasses import dataclass

import jax
import jax.numpy as jnp
from jaxtyping import Array, Float

from motorspace._errors import UserError
from motorspace._types import Key
from motorspace.analysis.probes import displacement_targets, linear_probe
from motorspace.evaluation.lattice import measure_lattice
from motorspace.evaluation.prediction import (
    CHUNK_SIZE,
    Metrics,
    mean_error,
    mean_squared_error,
    persistence_error,
    prediction_errors,
    with_skill,
)
from motorspace.evaluation.sampling import draw_test, named_r2, present_data, probe_halves, test_key
from motorspace.training.data import Data, Derived, Logged, Simulated
from motorspace.training.run import Run
from motorspace.training.sources import derive, logged_data
from motorspace.trajectories.transitions import Experience, Trajectories
from motorspace.worlds.world import LatticeWorld


@dataclass(frozen=True)
class Evaluation(Mapping[str, float]):
    """What a run was measured at: {key of a measure: number}; printed as a table.

    The keys are those of `motorspace.analysis.measures`.
    """

    metrics: Metrics
    """The same as a plain dictionary."""

    def __getitem__(self, key: str) -> float:
        return self.metrics[key]

    def __iter__(self) -> Iterator[str]:
        return iter(self.metrics)

    def __len__(self) -> int:
        return len(self.metrics)

    def __str__(self) -> str:
        return "\n".join(f"{key:<32} {value:.6g}" for key, value in self.metrics.items())


def evaluate(
    run: Run,
    *,
    num: int = 100_000,
    data: Data | None = None,
    test: Trajectories | None = None,
) -> Evaluation:
    """Errors of a run's predictions beside baselines, and linear probes of its codes.

    A run that learned in simulation is measured on fresh trajectories, one that learned from a
    log on the blocks of it that training never saw.

    Args:
        run: The run.
        num: Fresh trajectories to measure on.
        data: Where the data are now, if not where the run's configuration says: the same log at
            another place (`Logged.at`).
        test: Trajectories to measure on, for a run that learned from data of one's own.

    Returns:
        The measures by their keys: `prediction.error` (mean squared error, raw units squared),
        `prediction.persistence`, `prediction.mean`, `probe_r2.longitudinal`, ...

    Raises:
        UserError: When there is nothing to measure on: data of one's own that were not given, a
            log that is gone or has changed.
    """
    if num < 1:
        raise UserError(f"num must be at least 1, got {num}")
    data = present_data(run, data)
    if test is not None:
        return Evaluation(_measured_on_given(run, test))
    match data:
        case Simulated() | Derived(base=Simulated()):
            return Evaluation(_measured_in_simulation(run, data, num))
        case Logged() | Derived(base=Logged()):
            logged = logged_data(data)
            return Evaluation(_measured_on(run, logged.train, logged.test))
    raise UserError(
        "the run has learned from data that only you have",
        remedy="pass trajectories to measure on: evaluate(run, test=trajectories)",
    )


def _measured_in_simulation(run: Run, data: Simulated | Derived, num: int) -> Metrics:
    seed = run.config.training.seed
    errors_key, probe_key = jax.random.split(test_key(seed))

    def draw(key: Key, count: int) -> Experience:
        return _seen(data, draw_test(data, count, key=key), key=key)

    metrics = prediction_errors(run.predict, draw, num=num, key=errors_key)
    probed = draw_test(data, CHUNK_SIZE, key=probe_key)
    seen = _seen(data, probed, key=probe_key)
    codes = run.encode(seen.motors, seen.num_steps)
    metrics["code_variance"] = float(jnp.mean(jnp.var(codes, axis=0)))
    probes = probe_halves(codes, displacement_targets(probed.displacements.achieved))
    metrics |= {f"probe_r2.{name}": r2 for name, r2 in probes.items()}
    if isinstance(data, Simulated) and isinstance(data.scenario().world, LatticeWorld):
        metrics |= measure_lattice(run)
    return metrics


def _seen(data: Simulated | Derived, drawn: Trajectories, *, key: Key) -> Experience:
    """What the run's network is given: the oracle sees displacements for commands."""
    if isinstance(data, Derived):
        return derive(data, drawn, key=key)
    return drawn.experience


def _measured_on(run: Run, fitted: Trajectories, tested: Trajectories) -> Metrics:
    """Errors on some trajectories, and R2 there of a linear probe fitted on others."""
    mean = fitted.experience.later_sensors.mean(axis=0)
    metrics, codes = _errors_and_codes(run, tested, mean)
    known = _known(fitted, tested)
    if not known:
        return metrics
    r2 = linear_probe(_codes(run, fitted), _targets(fitted), codes, _targets(tested))
    return metrics | {f"probe_r2.{name}": value for name, value in named_r2(r2).items()}


def _measured_on_given(run: Run, test: Trajectories) -> Metrics:
    """Errors on some trajectories, and R2 on one half of them of a probe fitted on the other."""
    metrics, codes = _errors_and_codes(run, test, test.experience.later_sensors.mean(axis=0))
    if not _known(test):
        return metrics
    probes = probe_halves(codes, _targets(test))
    return metrics | {f"probe_r2.{name}": r2 for name, r2 in probes.items()}


def _errors_and_codes(
    run: Run, tested: Trajectories, mean: Float[Array, " K"]
) -> tuple[Metrics, Float[Array, "N C"]]:
    test, codes = tested.experience, _codes(run, tested)
    errors = {
        "prediction.error": mean_squared_error(run.predict(test), test.later_sensors),
        "prediction.persistence": persistence_error(test),
        "prediction.mean": mean_error(test, mean),
        "prediction.num": float(len(test)),
    }
    return with_skill(errors) | {"code_variance": float(jnp.mean(jnp.var(codes, axis=0)))}, codes


def _codes(run: Run, trajectories: Trajectories) -> Float[Array, "N C"]:
    return run.encode(trajectories.experience.motors, trajectories.experience.num_steps)


def _targets(trajectories: Trajectories) -> Float[Array, "N 4"]:
    return jnp.asarray(displacement_targets(trajectories.displacements.achieved))


def _known(*parts: Trajectories) -> bool:
    """Whether the displacements are: a robot's log may hold no poses."""
    return all(bool(jnp.isfinite(part.displacements.achieved).all()) for part in parts)
