"""A study that needs no JAX: jobs that count epochs in a file, which is their checkpoint."""

import hashlib
import json
import os
import time
from collections.abc import Mapping
from dataclasses import asdict, dataclass, replace
from pathlib import Path
from typing import Any

from motorspace._errors import UserError
from motorspace.running.jobs import Job, cell


@dataclass(frozen=True)
class ToyTraining:
    seed: int = 0
    epochs: int = 3
    learning_rate: float = 6e-3
    seconds: float = 0.0
    fails: str = ""


@dataclass(frozen=True)
class ToyConfig:
    agent: str = "forward"
    max_rotation: float = 0.8
    hidden_size: int = 100
    encoder: str = "lstm"
    preset: str = "paper"
    sense_head: bool = False
    training: ToyTraining = ToyTraining()

    def as_json(self) -> dict[str, Any]:
        return asdict(self)

    def hash(self) -> str:
        canonical = json.dumps(self.as_json(), sort_keys=True)
        return hashlib.sha256(canonical.encode()).hexdigest()[:12]

    def program(self) -> str:
        return f"{self.agent} {self.hidden_size} {self.encoder}"


def configured(agent: str, settings: Mapping[str, Any]) -> ToyConfig:
    """As `motorspace train` turns flags into a configuration."""
    if settings.get("max_rotation", 1) <= 0:
        raise UserError(f"max_rotation must be above 0, got {settings['max_rotation']}")
    names = ToyTraining.__dataclass_fields__
    training = ToyTraining(**{k: v for k, v in settings.items() if k in names})
    model = {k: v for k, v in settings.items() if k not in names}
    return ToyConfig(agent, training=training, **model)


def flags(agent: str) -> dict[str, Any]:
    if agent not in ("forward", "holonomic"):
        raise UserError(f"there is no agent named {agent!r}")
    return asdict(ToyTraining()) | {
        name: value
        for name, value in vars(ToyConfig()).items()
        if name not in ("training", "agent")
    }


def jobs(*rotations: float, seeds: int = 1, **training: Any) -> list[Job]:
    found = []
    for seed in range(seeds):
        for rotation in rotations:
            config = ToyConfig(max_rotation=rotation, training=ToyTraining(seed, **training))
            found.append(Job("toy", cell(agent="forward", rotation=rotation), config, "count"))
    return found


def execute(job: Job, folder: Path) -> dict[str, float]:
    """Count the epochs, from those that are in the folder."""
    folder.mkdir(parents=True, exist_ok=True)
    with (folder / "begun").open("a") as begun:
        begun.write(f"{os.getpid()}\n")
    config: Any = job.config
    if config.training.fails:
        raise {"user": UserError, "bug": ZeroDivisionError}[config.training.fails]("it is broken")
    with (folder / "epochs").open("a+") as epochs:
        epochs.seek(0)
        for epoch in range(len(epochs.readlines()), config.training.epochs):
            time.sleep(config.training.seconds)
            epochs.write(f"{epoch}\n")
            epochs.flush()
    counted = len((folder / "epochs").read_text().split())
    return {"value": config.max_rotation * 10 + job.seed / 3, "epochs": counted}


def other(job: Job, **changes: Any) -> Job:
    """The same place with another configuration."""
    return replace(job, config=replace(job.config, **changes))
