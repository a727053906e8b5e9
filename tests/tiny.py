"""The run that many tests train: the same one, since compiling it takes longer than running it."""

from motorspace import ModelConfig, RunConfig, SimulationConfig, TrainingConfig

TINY = RunConfig(
    SimulationConfig(layout="empty", horizon=2),
    ModelConfig(hidden_size=8, code_size=4, width_size=8, depth=1),
    TrainingConfig(epochs=120, trajectories_per_epoch=64, batch_size=32),
)


def flags(config: RunConfig = TINY) -> list[str]:
    """The run as the command line is told of it."""
    simulation, model, training = config.simulation, config.model, config.training
    told = {
        "layout": simulation.layout,
        "horizon": simulation.horizon,
        "hidden-size": model.hidden_size,
        "code-size": model.code_size,
        "width-size": model.width_size,
        "depth": model.depth,
        "epochs": training.epochs,
        "trajectories-per-epoch": training.trajectories_per_epoch,
        "batch-size": training.batch_size,
    }
    return [word for name, value in told.items() for word in (f"--{name}", str(value))]
