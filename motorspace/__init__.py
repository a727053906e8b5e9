"""Learn the space of displacements of an agent from its motor commands and its sensors.

The names stand in the order of the data: worlds -> trajectories -> models -> training ->
analysis -> reports. Nothing on the left imports anything on its right.
"""

from motorspace._errors import UserError as UserError
from motorspace._types import Pose as Pose
from motorspace.analysis.topology import Topology as Topology
from motorspace.analysis.topology import topology as topology
from motorspace.models import ModelConfig as ModelConfig
from motorspace.training import Run as Run
from motorspace.training import RunConfig as RunConfig
from motorspace.training import SimulationConfig as SimulationConfig
from motorspace.training import TrainingConfig as TrainingConfig
from motorspace.training import fresh_experience as fresh_experience
from motorspace.training import load_run as load_run
from motorspace.training import simulation_scaling as simulation_scaling
from motorspace.training import train as train
from motorspace.trajectories import Displacements as Displacements
from motorspace.trajectories import Experience as Experience
from motorspace.trajectories import Trajectories as Trajectories
from motorspace.trajectories import sample as sample
from motorspace.worlds import ForwardAgent as ForwardAgent
from motorspace.worlds import HolonomicAgent as HolonomicAgent
from motorspace.worlds import LatticeAgent as LatticeAgent
from motorspace.worlds import LatticeWorld as LatticeWorld
from motorspace.worlds import NodeIndex as NodeIndex
from motorspace.worlds import RangeFan as RangeFan
from motorspace.worlds import WalledWorld as WalledWorld
from motorspace.worlds import layout as layout
from motorspace.worlds import layout_names as layout_names
from motorspace.worlds import random_rooms as random_rooms
from motorspace.worlds import rollout as rollout
