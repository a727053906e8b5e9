"""Two real trainings, small enough to be interrupted a few times within a minute."""

import os
from pathlib import Path

from motorspace.running import trainer
from motorspace.running.jobs import Job
from motorspace.running.sweep import jobs_of
from motorspace.running.sweep_spec import sweep_of_flags

EPOCHS = 1000
TINY = ("layout=empty", "horizon=2", "hidden-size=8", "code-size=4", "width-size=8", "depth=1")
BUDGET = (f"epochs={EPOCHS}", "trajectories-per-epoch=64", "batch-size=32")


def jobs() -> list[Job]:
    sweep = sweep_of_flags(
        "real", agent=["forward"], seeds=1, grid=["max-rotation=0.2,0.6"], fixed=[*TINY, *BUDGET]
    )
    return jobs_of(sweep, trainer.trainer())


def execute(job: Job, folder: Path) -> dict[str, float]:
    """What `motorspace sweep` does, measured on less, with a checkpoint five times a second."""
    from motorspace.training import run

    with (folder / "begun").open("a") as begun:
        begun.write(f"{os.getpid()}\n")
    run.CHECKPOINT_SECONDS, trainer.NUM_TEST = 0.2, 5_000
    return dict(trainer.train_and_measure(job, folder))
