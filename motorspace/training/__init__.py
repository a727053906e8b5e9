"""Learning: configuration, the compiled loop, and the folder of a run."""

from motorspace.training.config import RunConfig as RunConfig
from motorspace.training.config import SimulationConfig as SimulationConfig
from motorspace.training.config import TrainingConfig as TrainingConfig
from motorspace.training.config import fresh_experience as fresh_experience
from motorspace.training.config import simulation_scaling as simulation_scaling
from motorspace.training.config import simulator as simulator
from motorspace.training.fit import TrainState as TrainState
from motorspace.training.fit import fit as fit
from motorspace.training.fit import init as init
from motorspace.training.runs import Run as Run
from motorspace.training.runs import initial_run as initial_run
from motorspace.training.runs import load_run as load_run
from motorspace.training.runs import train as train
from motorspace.training.runs import train_together as train_together
