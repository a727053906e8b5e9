"""A robot of one's own: body, sensor, encoder and log. None of it is part of motorspace.

Each class is registered under a name. From Python, import this module; on the command line, say
`--import my_robot` in its folder. Fields are options, and become flags: `--wheel-base 0.4`.
"""

import json
from dataclasses import dataclass
from typing import ClassVar

import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np

import motorspace as ms
from motorspace.recordings.readers.text import read_text
from motorspace.se2 import advance, wrap


@ms.register("two_wheels")
class TwoWheels(ms.AbstractAgent):
    """A body on two wheels. Motor command: how far the left and the right wheel roll."""

    wheel_base: float = eqx.field(static=True, default=0.5, metadata={"positive": True})
    """Distance between the wheels, world units."""

    @property
    def commands(self):
        return ms.ContinuousCommands(low=(-0.2, -0.2), high=(1.0, 1.0), names=("left", "right"))

    def start(self, place, *, key):
        return place

    def turn(self, pose, motor):
        left, right = motor
        turned = wrap(pose.heading + (right - left) / self.wheel_base)
        return ms.Pose(pose.x, pose.y, turned, pose.head)

    def move(self, pose, motor):
        left, right = motor
        half = (right - left) / self.wheel_base / 2
        # The wheels roll along an arc. Its chord points half way from the old heading to the new.
        chord = (left + right) / 2 * jnp.sinc(half / jnp.pi)
        half_way = ms.Pose(pose.x, pose.y, pose.heading + half, pose.head)
        there = advance(half_way, chord, jnp.zeros_like(chord))
        turned = self.turn(pose, motor)
        return (ms.Pose(there.x, there.y, turned.heading, pose.head),)


@ms.register("compass_and_sonar")
class CompassAndSonar(ms.AbstractSensor):
    """Which way the robot faces, and how far it is to the walls in a few directions."""

    num_sonars: int = eqx.field(static=True, default=5, metadata={"positive": True})
    """Sonars, from the right over the front to the left."""
    max_range: float = eqx.field(static=True, default=6.0, metadata={"positive": True})
    """What a sonar reads that meets no wall, world units."""

    @property
    def sonars(self):
        return ms.RangeFan(num_rays=self.num_sonars, max_range=self.max_range)

    def space(self, world):
        ranges = self.sonars.space(world)
        names = ("east", "north", *ranges.names)
        return ms.SensorSpace((-1.0, -1.0, *ranges.low), (1.0, 1.0, *ranges.high), names)

    def sense(self, world, pose):
        compass = jnp.stack([jnp.cos(pose.gaze), jnp.sin(pose.gaze)])
        return jnp.concatenate([compass, self.sonars.sense(world, pose)])

    def rays(self, world, pose):
        return self.sonars.rays(world, pose)


@ms.register("odometer")
class Odometer(ms.AbstractMotorEncoder):
    """Learns by how much each command turns and moves, in several planes, and adds it up."""

    motion: eqx.nn.MLP

    def __init__(self, motor_size, hidden_size, code_size, *, key):
        planes = max(1, code_size // 4)
        self.motion = eqx.nn.MLP(motor_size, 3 * planes, hidden_size, 1, jnp.tanh, key=key)

    def __call__(self, motors, num_steps):
        turn, ahead, aside = jnp.split(jax.vmap(self.motion)(motors), 3, axis=1)
        executed = jnp.arange(len(motors))[:, None] < num_steps
        heading = jnp.cumsum(jnp.where(executed, turn, 0.0), axis=0)
        cos, sin = jnp.cos(heading), jnp.sin(heading)
        x = jnp.where(executed, ahead * cos - aside * sin, 0.0).sum(axis=0)
        y = jnp.where(executed, ahead * sin + aside * cos, 0.0).sum(axis=0)
        return jnp.concatenate([x, y, cos[-1], sin[-1]])


@ms.register("json_lines")
@dataclass(frozen=True)
class JsonLinesReader(ms.AbstractReader):
    """Lines such as {"t": 0, "wheels": [0.1, 0.2], "sensors": [...], "pose": [x, y, heading]}.

    `wheels` is what the robot does next. `pose` may be missing: it is for evaluation alone.
    """

    endings: ClassVar[tuple[str, ...]] = (".jsonl",)

    wheel_scale: float = 1.0
    """What the wheels' readings are multiplied by."""

    @classmethod
    def recognises(cls, name, head):
        return head.startswith(b'{"t":')

    def parse(self, path):
        rows, no_pose = [], (np.nan,) * 3
        for number, line in enumerate(read_text(path).splitlines(), start=1):
            try:
                row = json.loads(line)
                pose = row.get("pose", no_pose)
                rows.append(np.array([row["t"], *row["wheels"], *pose, *row["sensors"]], float))
                if len(rows[-1]) != len(rows[0]):
                    raise ValueError("its number of values differs from that of the first line")
            except (ValueError, KeyError, TypeError, AttributeError) as error:
                raise ms.UserError(
                    f"the line is no scan ({error!r})",
                    where=f"{path}, line {number}",
                    remedy="correct it, or leave it out",
                ) from None
        time, wheels, poses, sensors = np.split(np.array(rows), [1, 3, 6], axis=1)
        return ms.Recording(
            name=path.name,
            time=time[:, 0],
            sensors=sensors,
            increments=wheels[:-1] * self.wheel_scale,
            interval=np.arange(len(rows) - 1),  # one command between each two scans
            poses=np.pad(poses, ((0, 0), (0, 1))),  # the sensors do not turn on the body
            sensor_scale=tuple(np.abs(sensors).max(axis=0).clip(min=1e-6)),
            planar=False,
            usable=np.ones(len(rows) - 1, bool),
        )
