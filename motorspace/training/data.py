"""What a run learns from, as data: a simulated agent, a robot's log, or data of one's own."""

from dataclasses import dataclass, replace
from functools import cache, lru_cache
from pathlib import Path
from typing import TYPE_CHECKING, Any, Literal, get_args

from motorspace._errors import UserError
from motorspace._files import file_hash
from motorspace._kinds import Part, Registry
from motorspace.worlds.catalog import AGENTS, SENSORS, home_of
from motorspace.worlds.checks import flag, one_of, positive, whole
from motorspace.worlds.layouts import layout_content
from motorspace.worlds.paint import parse_paint

if TYPE_CHECKING:
    from motorspace.recordings.recording import Recording
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
        _set(
            self,
            agent=described,
            sensor=_part(SENSORS, home.sensor if sensor is None else sensor),
            layout=layout_content(home.layout if layout is None else layout),
            horizon=horizon,
            min_horizon=min_horizon,
            collision=collision,
            paint=None if paint is None else parse_paint(paint, where="paint").name,
        )
        _check_horizon(horizon, min_horizon)
        one_of("collision", collision, get_args(Collision))

    def scenario(self) -> "Scenario":
        """The world, the agent and its sensors; built once for equal configurations."""
        return _scenario(self)

    def as_json(self) -> dict[str, Any]:
        """The same as JSON-able data."""
        parts = {"agent": self.agent.as_json(), "sensor": self.sensor.as_json()}
        own = {name: value for name, value in vars(self).items() if (name, value) != UNPAINTED}
        return {"kind": "simulated"} | own | parts


@dataclass(frozen=True, init=False)
class Logged:
    """Transitions of a robot's log, split into blocks of time for training and test.

    Args:
        path: The log.
        reader: Which reader reads it; by default the one that recognises its content.
        horizon: Scans from the beginning of a transition to its end.
        min_horizon: Training also sees transitions over fewer scans, down to these.
        per_scan: Whether the motor increments between two scans are chained into one command;
            otherwise a sequence holds every increment.
        num_blocks: Blocks of time that the log is cut into: 60 % are for training, 20 % for
            validation, 20 % for test.
        sha256: Hash of the log's content; by default that of the file as it is now.
        options: Options of the reader, such as `num_rays`.

    Raises:
        UserError: For a file that cannot be read, and options that the reader does not have.
    """

    path: str
    sha256: str
    reader: Part
    horizon: int
    min_horizon: int | None
    per_scan: bool
    num_blocks: int

    def __init__(
        self,
        path: str | Path,
        reader: str | Part | None = None,
        horizon: int = 6,
        min_horizon: int | None = None,
        per_scan: bool = True,
        num_blocks: int = 20,
        sha256: str | None = None,
        **options: Any,
    ) -> None:
        from motorspace.recordings.catalog import READERS, reader_for

        kind = reader_for(Path(path)) if reader is None else reader
        part = READERS.part(kind, options) if isinstance(kind, str) else kind
        _set(
            self,
            path=str(path),
            sha256=sha256 or file_hash(Path(path)),
            reader=part,
            horizon=horizon,
            min_horizon=min_horizon,
            per_scan=per_scan,
            num_blocks=whole("num_blocks", num_blocks),
        )
        flag("per_scan", per_scan)
        _check_horizon(horizon, min_horizon)

    def at(self, path: str | Path) -> "Logged":
        """The same log, which now lies elsewhere. Raises `UserError` if it is another one."""
        moved = replace(self, path=str(path), sha256=self.sha256)
        moved.check_content()
        return moved

    def check_content(
        self, *, remedy: str = "give the original file, or train a new run on this one"
    ) -> None:
        """Raise `UserError` unless the file is there and still holds what it held."""
        try:
            content = file_hash(Path(self.path))
        except UserError as error:
            raise UserError(error.what, where=self.path, remedy=remedy) from None
        if content != self.sha256:
            raise UserError(
                "this is not the log that the run has learned from (its content differs)",
                where=self.path,
                remedy=remedy,
            )

    def recording(self) -> "Recording":
        """The log, read. Raises `UserError` if it is gone, has changed or cannot be read."""
        self.check_content()
        return _recording(self)

    def as_json(self) -> dict[str, Any]:
        """The same as JSON-able data."""
        return {"kind": "logged"} | vars(self) | {"reader": self.reader.as_json()}


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
        _set(self, angle=positive("angle", self.angle))
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
        _set(self, shape=tuple(self.shape))

    def as_json(self) -> dict[str, Any]:
        """The same as JSON-able data."""
        shape = {"shape": list(self.shape)} if self.shape else {}
        return {"kind": "given", "description": self.description} | shape


Data = Simulated | Logged | Derived | Given


def base_of(data: Data) -> Simulated | Logged | Given:
    """The data themselves, or those that they are derived from."""
    return data.base if isinstance(data, Derived) else data


def arrangement(data: Data) -> tuple[int, ...]:
    """How the sensors are arranged: (pixels, 3) of a retina; empty where nothing is said."""
    match base := base_of(data):
        case Simulated():
            return base.scenario().space.shape
        case Given():
            return base.shape
    return ()


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


@lru_cache(maxsize=1)
def _recording(data: Logged) -> "Recording":
    from motorspace.recordings.catalog import READERS

    read: Recording = READERS.build(data.reader).read(Path(data.path))
    return read


def _set(target: Any, **fields: Any) -> None:
    for name, value in fields.items():
        object.__setattr__(target, name, value)


def _part(registry: Registry[Any], value: Any) -> Part:
    part = Part(value) if isinstance(value, str) else value
    if isinstance(part, Part):
        return registry.part(part.kind, dict(part.options))
    return registry.part_of(value)


def _check_horizon(horizon: int, min_horizon: int | None) -> None:
    whole("horizon", horizon)
    if min_horizon is not None and whole("min_horizon", min_horizon) > horizon:
        raise UserError(
            f"min_horizon {min_horizon} is above horizon {horizon}",
            remedy="give a min_horizon from 1 to horizon",
        )
