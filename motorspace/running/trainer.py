"""Sweeps of `motorspace train`: which flags there are, what a run of one does."""

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from motorspace.running.jobs import Job
from motorspace.running.sweep import Trainer
from motorspace.training.config import RunConfig
from motorspace.training.settings import configured, simulated_groups

MEASURES = {"prediction": "prediction", "structure": "structure"}
"""prediction: errors beside baselines, and probes; structure: also the report on the codes."""

NUM_TEST = 100_000


def trainer() -> Trainer:
    """What a sweep has to know about `motorspace train`."""
    return Trainer(configured=_configured, flags=_flags, measures=MEASURES)


def train_and_measure(job: Job, folder: Path) -> dict[str, float]:
    """Train a job's run in a folder, from its checkpoint if there is one, and measure it."""
    from motorspace.evaluation.evaluate import evaluate
    from motorspace.evaluation.structure import evaluate_with_structure
    from motorspace.training.run import train

    assert isinstance(job.config, RunConfig)
    run = train(job.config, folder=folder, resume=True)
    if job.measure == "structure":
        return evaluate_with_structure(run, num=NUM_TEST)
    return dict(evaluate(run, num=NUM_TEST))


def _configured(agent: str, settings: Mapping[str, Any]) -> RunConfig:
    own = {name: settings[name] for name in ("preset", "sensor") if name in settings}
    rest = {name: value for name, value in settings.items() if name not in own}
    return configured(agent, rest, **own)


def _flags(agent: str) -> dict[str, Any]:
    groups = simulated_groups(agent)
    known = {p.name: p.default for group in groups for p in group.parameters}
    return {"preset": "paper", "sensor": None, **known}


def train_team(jobs: Sequence[Job], folders: Sequence[Path]) -> None:
    """Train jobs that differ by their seeds and by numbers as one program, from checkpoints."""
    from motorspace.training.run import train_together

    configs = [job.config for job in jobs if isinstance(job.config, RunConfig)]
    train_together(configs, folders, resume=True)
