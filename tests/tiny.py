"""The run that many tests train: the same one, since compiling it takes longer than running it."""

from dataclasses import asdict

from motorspace import ModelConfig, RunConfig, SimulationConfig, TrainingConfig

TINY = RunConfig(
    SimulationConfig(layout="empty", horizon=2),
    ModelConfig(hidden_size=8, code_size=4, width_size=8, depth=1),
    TrainingConfig(epochs=120, trajectories_per_epoch=64, batch_size=32),
)


def flags() -> list[str]:
    """The run as the command line is told of it: what differs from the defaults."""
    told = []
    for part in (TINY.simulation, TINY.model, TINY.training):
        for name, value in asdict(part).items():
            if value != getattr(type(part)(), name):
                told += [f"--{name.replace('_', '-')}", str(value)]
    return told
