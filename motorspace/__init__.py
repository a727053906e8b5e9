"""Learn the space of displacements of an agent from its motor commands and its sensors.

The names stand in the order of the data: worlds -> trajectories -> models -> training ->
analysis -> reports. Nothing on the left imports anything on its right.
"""

from motorspace._errors import UserError as UserError
from motorspace._types import Pose as Pose
from motorspace.analysis.topology import Topology as Topology
from motorspace.analysis.topology import topology as topology
from motorspace.models.config import ModelConfig as ModelConfig
from motorspace.training.config import RunConfig as RunConfig
from motorspace.training.config import SimulationConfig as SimulationConfig
from motorspace.training.config import TrainingConfig as TrainingConfig
from motorspace.training.config import fresh_experience as fresh_experience
from motorspace.training.config import simulation_scaling as simulation_scaling
from motorspace.training.runs import Run as Run
from motorspace.training.runs import load_run as load_run
from motorspace.training.runs import train as train
from motorspace.trajectories.sampling import sample as sample
from motorspace.trajectories.transitions import Displacements as Displacements
from motorspace.trajectories.transitions import Experience as Experience
from motorspace.trajectories.transitions import Trajectories as Trajectories
from motorspace.worlds.agents import ForwardAgent as ForwardAgent
from motorspace.worlds.agents import HolonomicAgent as HolonomicAgent
from motorspace.worlds.agents import LatticeAgent as LatticeAgent
from motorspace.worlds.layouts import layout as layout
from motorspace.worlds.layouts import layout_names as layout_names
from motorspace.worlds.layouts import random_rooms as random_rooms
from motorspace.worlds.scenario import Scenario as Scenario
from motorspace.worlds.sensors.node_index import NodeIndex as NodeIndex
from motorspace.worlds.sensors.range_fan import RangeFan as RangeFan
from motorspace.worlds.simulation import rollout as rollout
from motorspace.worlds.world import LatticeWorld as LatticeWorld
from motorspace.worlds.world import WalledWorld as WalledWorld
