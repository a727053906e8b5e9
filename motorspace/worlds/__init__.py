"""Where: places, bodies and senses, as pure functions on arrays."""

from motorspace.worlds.agents import AbstractAgent as AbstractAgent
from motorspace.worlds.agents import ForwardAgent as ForwardAgent
from motorspace.worlds.agents import HolonomicAgent as HolonomicAgent
from motorspace.worlds.agents import LatticeAgent as LatticeAgent
from motorspace.worlds.layouts import Layout as Layout
from motorspace.worlds.layouts import layout as layout
from motorspace.worlds.layouts import layout_names as layout_names
from motorspace.worlds.layouts import random_rooms as random_rooms
from motorspace.worlds.layouts import read_layout as read_layout
from motorspace.worlds.sensors import AbstractSensor as AbstractSensor
from motorspace.worlds.sensors import NodeIndex as NodeIndex
from motorspace.worlds.sensors import RangeFan as RangeFan
from motorspace.worlds.simulation import rollout as rollout
from motorspace.worlds.simulation import step as step
from motorspace.worlds.world import AbstractWorld as AbstractWorld
from motorspace.worlds.world import LatticeWorld as LatticeWorld
from motorspace.worlds.world import WalledWorld as WalledWorld
