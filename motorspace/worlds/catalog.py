"""The agents and sensors there are, known by name before their modules are imported.

A test holds every entry against the class that it stands for.
"""

import math
from typing import Any, NamedTuple

from motorspace._kinds import Builtin, Parameter, Registry

MAX_ROTATION = Parameter(
    "max_rotation", 0.8 * math.pi, "Largest body rotation per step.", in_pi=True, positive=True
)

AGENTS: Registry[Any] = Registry(
    "agent",
    {
        "forward": Builtin("motorspace.worlds.agents", "ForwardAgent", (MAX_ROTATION,)),
        "holonomic": Builtin(
            "motorspace.worlds.agents",
            "HolonomicAgent",
            (
                MAX_ROTATION,
                Parameter(
                    "head_rule",
                    "set",
                    "The head command: set the head's angle, or turn the head by it.",
                    ("set", "turn"),
                ),
                Parameter(
                    "head_start",
                    "aligned",
                    "The head's angle when a trajectory begins.",
                    ("aligned", "random"),
                ),
            ),
        ),
        "lattice": Builtin("motorspace.worlds.agents", "LatticeAgent"),
    },
)

SENSORS: Registry[Any] = Registry(
    "sensor",
    {
        "range_fan": Builtin(
            "motorspace.worlds.sensors.range_fan",
            "RangeFan",
            (
                Parameter("num_rays", 9, "Distance sensors.", positive=True),
                Parameter(
                    "max_range", 10.0, "Range of the distance sensors, world units.", positive=True
                ),
                Parameter(
                    "field_of_view",
                    math.pi,
                    "Field of view of the distance sensors.",
                    in_pi=True,
                    positive=True,
                ),
                Parameter("sense_head", False, "Whether the head's angle is one more sensor."),
            ),
        ),
        "retina": Builtin(
            "motorspace.worlds.sensors.retina",
            "Retina",
            (
                Parameter("num_rays", 32, "Pixels of the retina.", positive=True),
                Parameter(
                    "field_of_view",
                    math.pi,
                    "Field of view of the retina.",
                    in_pi=True,
                    positive=True,
                ),
                Parameter("samples", 4, "Rays whose colours a pixel averages.", positive=True),
                Parameter(
                    "light",
                    "constant",
                    "The light: constant, or a random factor for each trajectory or each view.",
                    ("constant", "trajectory", "view"),
                ),
            ),
        ),
        "node_index": Builtin("motorspace.worlds.sensors.node_index", "NodeIndex"),
    },
)


class Home(NamedTuple):
    """What an agent is simulated in unless another world or sensor is asked for."""

    sensor: str = "range_fan"
    layout: str = "paper"
    horizon: int = 6
    min_horizon: int | None = None


_HOMES = {"lattice": Home("node_index", "lattice:6", horizon=5, min_horizon=1)}


def home_of(agent: str) -> Home:
    """The home of an agent of this kind."""
    return _HOMES.get(agent, Home())
