"""What a run learns from, as data: a simulated agent, a robot's log, or data of one's own."""

from dataclasses import dataclass
from functools import cache
from pathlib import Path
from typing import TYPE_CHECKING, Any, Literal, get_args

from motorspace._errors import UserError
from motorspace._kinds import Part, Registry
from motorspace.training.logged import Logged, check_horizon, set_fields
from motorspace.worlds.catalog import AGENTS, SENSORS, home_of
from motorspace.worlds.checks import one_of, positive
from motorspace.worlds.layouts import layout_content
from motorspace.worlds.paint import parse_paint

if TYPE_CHECKING:
    from motorspace.worlds.agents import AbstractAgent
    from motorspace.worlds.scenario import Scenario
    from motorspace.worlds.sensors.base import AbstractSensor

Collision = Literal["resample", "block"]
UNPAINTED = ("paint", None)
"""Not named: runs from before there was paint are the same runs."""
DerivedKind = Literal["oracle", "shuffled", "supervised", "scaled_rotations"]


@dataclass(frozen=True, init=False)
class Simulated:
    """Fresh transitions of an agent that explores a simulated world.

    Args:
        agent: The agent that explores: an object, or the name of its kind.
        sensor: What it senses; by default what suits the agent (nine distances).
        layout: The world: a bundled layout, `rooms:SEED`, `lattice:SIDE`, the path of a layout
            file, or the content of one. Of a file the content is kept, so that the run stays
            what it was when the file changes.
        horizon: Motor commands per trajectory (T).
        min_horizon: Shortest trajectory, where lengths are drawn from `min_horizon` to `horizon`.
        collision: A command that a wall forbids: `"resample"` draws another, `"block"` discards
            its translation.
        paint: The colours of the walls, such as `"texture:4"`; by default the layout's own.

    Raises:
        UserError: For a kind, option, paint or layout that does not exist, and sizes below one.
    """

    agent: Part
    sensor: Part
    layout: str
    horizon: int
    min_horizon: int | None
    collision: Collision
    paint: str | None

    def __init__(
        self,
        agent: "str | Part | AbstractAgent" = "forward",
        sensor: "str | Part | AbstractSensor[Any] | None" = None,
        layout: str | Path | None = None,
        horizon: int | None = None,
        min_horizon: int | None = None,
        collision: Collision = "resample",
        paint: str | None = None,
    ) -> None:
        described = _part(AGENTS, agent)
        home = home_of(described.kind)
        if horizon is None:
            horizon = home.horizon
            min_horizon = home.min_horizon if min_horizon is None else min_horizon
        set_fields(
            self,
            agent=described,
            sensor=_part(SENSORS, home.sensor if sensor is None else sensor),
            layout=layout_content(home.layout if layout is None else layout),
            horizon=horizon,
            min_horizon=min_horizon,
            collision=collision,
            paint=None if paint is None else parse_paint(paint, where="paint").name,
        )
        check_horizon(horizon, min_horizon)
        one_of("collision", collision, get_args(Collision))

    def scenario(self) -> "Scenario":
        """The world, the agent and its sensors; built once for equal configurations."""
        return _scenario(self)

    def as_json(self) -> dict[str, Any]:
        """The same as JSON-able data."""
        parts = {"agent": self.agent.as_json(), "sensor": self.sensor.as_json()}
        own = {name: value for name, value in vars(self).items() if (name, value) != UNPAINTED}
        return {"kind": "simulated"} | own | parts


@dataclass(frozen=True)
class Derived:
    """What a baseline learns from: the transitions of `base`, changed in one respect.

    Args:
        base: The simulation, or the log (of which there is only the oracle).
        change: What is changed, see below.
        angle: Of `scaled_rotations`: what rotations are multiplied by.

    Raises:
        UserError: For another base or change, and an angle that is not above 0.

    The changes are

    - `oracle`: the command is the true displacement itself;
    - `shuffled`: every sequence leads to what another one led to;
    - `supervised`: the displacement is to be predicted, instead of the sensors;
    - `scaled_rotations`: the command is the nominal displacement of commands whose rotations
      are scaled by `angle`.
    """

    base: Simulated | Logged
    change: DerivedKind
    angle: float = 1.0

    def __post_init__(self) -> None:
        if not isinstance(self.base, Simulated | Logged):
            raise UserError("the base of derived data must be a simulation or a log")
        one_of("change", self.change, get_args(DerivedKind))
        set_fields(self, angle=positive("angle", self.angle))
        if isinstance(self.base, Logged) and self.change != "oracle":
            raise UserError(
                f"{self.change!r} cannot be derived from a log",
                remedy="derive it from a simulation",
            )

    @property
    def horizon(self) -> int:
        """Commands, or scans, of the longest transition of `base`."""
        return self.base.horizon

    def scenario(self) -> "Scenario":
        """The world, the agent and its sensors of a simulated `base`."""
        return simulated(self.base).scenario()

    def as_json(self) -> dict[str, Any]:
        """The same as JSON-able data."""
        described = {"kind": "derived", "base": self.base.as_json(), "change": self.change}
        return described | ({"angle": self.angle} if self.change == "scaled_rotations" else {})


@dataclass(frozen=True)
class Given:
    """Data of one's own, which are passed to `train` beside the configuration.

    Args:
        description: What they are, for whoever reads the configuration.
        shape: How the sensors are arranged, for instance (height, width, 3); [K] where nothing is
            said.
    """

    description: str = "data passed to train"
    shape: tuple[int, ...] = ()

    def __post_init__(self) -> None:
        set_fields(self, shape=tuple(self.shape))

    def as_json(self) -> dict[str, Any]:
        """The same as JSON-able data."""
        shape = {"shape": list(self.shape)} if self.shape else {}
        return {"kind": "given", "description": self.description} | shape


Data = Simulated | Logged | Derived | Given


def base_of(data: Data) -> Simulated | Logged | Given:
    """The data themselves, or those that they are derived from."""
    return data.base if isinstance(data, Derived) else data


def arrangement(data: Data) -> tuple[int, ...]:
    """How the sensors are arranged: (pixels, 3) of a retina; () where nothing is said."""
    match base := base_of(data):
        case Simulated():
            return base.scenario().space.shape
        case Logged():
            return base.recording().shape
    return base.shape


def simulated(data: Data) -> Simulated:
    """The simulation behind some data. Raises `UserError` where there is none."""
    base = base_of(data)
    if isinstance(base, Simulated):
        return base
    learned = f"the log {base.path}" if isinstance(base, Logged) else base.description
    raise UserError(
        f"there is no simulated agent: the run has learned from {learned}",
        remedy="use a run that was trained in simulation",
    )


@cache
def _scenario(data: Simulated) -> "Scenario":
    from motorspace.worlds.scenario import Scenario

    return Scenario.of(data.agent, data.sensor, data.layout, data.paint)


def _part(registry: Registry[Any], value: Any) -> Part:
    part = Part(value) if isinstance(value, str) else value
    if isinstance(part, Part):
        return registry.part(part.kind, dict(part.options))
    return registry.part_of(value)
