"""How motorspace trains several runs at once: the only place here that knows of its interface."""

from collections.abc import Callable
from typing import Any

import jax.numpy as jnp

from benchmarks.programs import ONE_EPOCH, of_many
from motorspace.training.config import RunConfig
from motorspace.training.program import train_epochs_together
from motorspace.training.settings import changed


def ours(config: RunConfig, num_runs: int, epochs: int, *, fresh: bool) -> Callable[[], Any]:
    """What trains so many runs for so many epochs, and returns the last loss of each.

    Args:
        config: Of all runs, but for their seeds.
        num_runs: Runs that one program trains.
        epochs: Epochs from the initial weights; the schedule is that of the configuration.
        fresh: Sample anew in each epoch; otherwise all runs learn from the same transitions.
    """
    given = of_many(config, num_runs, fresh=fresh)
    num = jnp.int32(epochs)

    def run() -> Any:
        return train_epochs_together(*given, num)[1].prediction_loss[:, epochs - 1]

    return run


def compiled_update(config: RunConfig, num_runs: int) -> Any:
    """The compiled program of one update of so many runs on given transitions."""
    once = changed(config, {"trajectories_per_epoch": config.training.batch_size})
    given = of_many(once, num_runs, fresh=False)
    lowered = train_epochs_together.lower(*given, ONE_EPOCH)  # type: ignore[attr-defined]
    return lowered.compile().compiled
