"""A world with an agent and its sensors in it: what is sampled, acted in, evaluated and drawn."""

from functools import lru_cache
from pathlib import Path
from typing import Any

import equinox as eqx
import jax

from motorspace._errors import UserError
from motorspace._forks import refuse_forked
from motorspace._kinds import Part
from motorspace._types import Flags, Key, Motor, Pose, Sensors
from motorspace.worlds.agents import AbstractAgent, ForwardAgent
from motorspace.worlds.catalog import AGENTS, SENSORS
from motorspace.worlds.layouts import Layout, load_layout, painted, parse_layout
from motorspace.worlds.sensors.base import AbstractSensor
from motorspace.worlds.sensors.range_fan import RangeFan
from motorspace.worlds.simulation import step
from motorspace.worlds.spaces import CommandSpace, SensorSpace
from motorspace.worlds.world import AbstractWorld, LatticeWorld

WorldLike = AbstractWorld | Layout | Path | str
"""A world, its description, a layout file, or a name: a bundled layout, `rooms:SEED`,
`lattice:SIDE`, or the text of a layout (more than one line)."""

LATTICE = "lattice:"


class Scenario(eqx.Module):
    """A world, an agent and a sensor that fit together.

    Args:
        world: A world, a `Layout`, a layout file, or the name of a world: a bundled layout,
            `rooms:SEED` or `lattice:SIDE`.
        agent: The body that acts.
        sensor: What it senses with.

    Raises:
        UserError: For an unknown name, a broken layout, and an agent or sensor that does not
            work in this world.
    """

    world: AbstractWorld
    agent: AbstractAgent
    sensor: AbstractSensor[Any]

    def __init__(
        self,
        world: WorldLike = "paper",
        agent: AbstractAgent | None = None,
        sensor: AbstractSensor[Any] | None = None,
    ) -> None:
        self.world = world_of(world)
        self.agent = ForwardAgent() if agent is None else agent
        self.sensor = RangeFan() if sensor is None else sensor
        self.agent.check(self.world)
        self.sensor.space(self.world)

    @classmethod
    def of(cls, agent: Part, sensor: Part, layout: str, paint: str | None = None) -> "Scenario":
        """The scenario that a configuration describes; its world is built once per process.

        Args:
            agent: The agent's kind and options.
            sensor: The sensor's kind and options.
            layout: The name of a world, or the text of a layout.
            paint: Its colours, if they are not the layout's own.

        Raises:
            UserError: As `Scenario` itself, and for an unknown kind or unfit options.
        """
        world = layout if paint is None else _painted(layout, paint)
        return cls(world, AGENTS.build(agent), SENSORS.build(sensor))

    @property
    def commands(self) -> CommandSpace:
        """The motor commands that the agent takes."""
        return self.agent.commands

    @property
    def space(self) -> SensorSpace:
        """The bounds and names of the readings."""
        return self.sensor.space(self.world)

    def start(self, *, key: Key) -> Pose:
        """A uniformly random free pose, as a trajectory begins."""
        place_key, head_key = jax.random.split(key)
        return self.agent.start(self.world.place(key=place_key), key=head_key)

    def step(self, pose: Pose, motor: Motor) -> tuple[Pose, Flags]:
        """The pose after one command, and whether a wall took the translation away."""
        return step(self.world, self.agent, pose, motor)

    def sense(self, pose: Pose) -> Sensors:
        """The readings [K, *batch] at a pose or a batch of poses, raw units."""
        return self.sensor.sense(self.world, pose)


def world_of(world: WorldLike) -> AbstractWorld:
    """The world behind a name, a file or a description; equal ones are built once.

    Raises:
        UserError: For an unknown name or a broken layout.
    """
    if isinstance(world, AbstractWorld):
        return world
    if isinstance(world, Layout):
        return _built(world)
    if not isinstance(world, str | Path):
        raise UserError(
            f"a {type(world).__name__} is no world",
            remedy="give a world, a layout, a layout file, or a name such as paper",
        )
    name = str(world)
    if "\n" in name:
        return _built(parse_layout(name, where="layout"))
    if name.startswith(LATTICE):
        return _lattice(name.removeprefix(LATTICE))
    try:
        content = Path(name).read_bytes()
    except OSError:
        content = b""
    return _named(name, content)


def _painted(name: str, paint: str) -> Layout:
    """The layout of a name, or of its text, in other colours."""
    layout = parse_layout(name, where="layout") if "\n" in name else load_layout(name)
    return painted(layout, paint)


def _lattice(side: str) -> LatticeWorld:
    if not side.isdecimal() or int(side) < 1:
        raise UserError(
            f"the side of a lattice must be a whole number above 0, got {side!r}",
            where="layout",
            remedy="write for instance lattice:6",
        )
    return LatticeWorld(int(side), int(side))


@lru_cache(maxsize=32)
def _named(name: str, content: bytes) -> AbstractWorld:
    """The world of this name; `content` is that of a file, which may change."""
    del content
    return _built(load_layout(name))


@lru_cache(maxsize=32)
def _built(layout: Layout) -> AbstractWorld:
    refuse_forked()
    with jax.ensure_compile_time_eval():  # cached arrays must outlast a trace
        return layout.world()
