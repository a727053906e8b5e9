"""What happened: transitions sampled from a world or read from a robot's log."""

from motorspace.trajectories.sampling import SamplingPlan as SamplingPlan
from motorspace.trajectories.sampling import sample as sample
from motorspace.trajectories.sampling import simulate as simulate
from motorspace.trajectories.trajectories import Displacements as Displacements
from motorspace.trajectories.trajectories import Experience as Experience
from motorspace.trajectories.trajectories import ExperienceSource as ExperienceSource
from motorspace.trajectories.trajectories import Trajectories as Trajectories
