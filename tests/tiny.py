"""The run that many tests train: the same one, since compiling it takes longer than running it."""

from dataclasses import fields

from motorspace.models.config import ModelConfig
from motorspace.training.config import RunConfig, TrainingConfig
from motorspace.training.data import Simulated

TINY = RunConfig(
    Simulated(layout="empty", horizon=2),
    ModelConfig(hidden_size=8, code_size=4, width_size=8, depth=1),
    TrainingConfig(epochs=120, trajectories_per_epoch=64, batch_size=32),
)


def flags() -> list[str]:
    """The run as flags of the command line: what differs from the defaults."""
    written = []
    default = RunConfig(Simulated())
    for part in ("data", "model", "training"):
        ours, usual = getattr(TINY, part), getattr(default, part)
        for field in fields(ours):
            value = getattr(ours, field.name)
            if value != getattr(usual, field.name):
                written += [f"--{field.name.replace('_', '-')}", str(value)]
    return written
