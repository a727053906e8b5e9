"""The motion of a robot by the messages of a bag, and the clock that scans and motion share."""

from collections.abc import Sequence
from pathlib import Path
from typing import Literal, NamedTuple, TypeVar

import numpy as np
from jaxtyping import Float

from motorspace._errors import UserError
from motorspace.recordings.bags.messages import (
    ODOMETRY,
    TWIST,
    TWIST_STAMPED,
    Command,
    LaserScan,
    Located,
    Message,
)
from motorspace.recordings.bags.topics import FRAMES, MOTIONS, Streams
from motorspace.recordings.readers.motion import Motion, commanded, ordered

BACK = 1.0
"""Seconds by which a clock may step back from one message to the next: messages overtake."""

OFFSET = 0.5
"""Seconds that two clocks may lie apart without a note."""


M = TypeVar("M", LaserScan, Located, Located | Command)


class Source(NamedTuple):
    """The messages that say how the robot moves."""

    topic: str
    poses: list[Located]
    commands: list[Command]


class Clock(NamedTuple):
    """Which of their two time stamps messages go by."""

    kind: Literal["header", "bag"]

    def times(self, messages: Sequence[Message]) -> Float[np.ndarray, " P"]:
        """When the messages are from, seconds."""
        return np.array([getattr(message.stamp, self.kind) for message in messages], float)

    def sort(
        self, messages: list[M], topic: str, notes: list[str]
    ) -> tuple[list[M], Float[np.ndarray, " P"]]:
        """The messages in order of time, each time once, and the times."""
        times = self.times(messages)
        order, late, repeated = ordered(times)
        if late:
            notes.append(f"{late} messages of {topic} are out of order: sorted by time")
        if repeated:
            notes.append(f"{repeated} messages of {topic} repeat a time stamp: left out")
        return [messages[index] for index in order], times[order]


def clocked(
    wanted: Literal["header", "bag"],
    scans: list[LaserScan],
    source: Source,
    notes: list[str],
    *,
    where: Path,
) -> Clock:
    """The clock by which scans and motion are compared: the headers', if they have one.

    Raises `UserError` where even the bag's own time runs backwards.
    """
    motion: list[Message] = [*source.poses, *source.commands]
    header, bag = Clock("header"), Clock("bag")
    if wanted == "header":
        why = next(filter(None, (_no_clock(header, m) for m in (scans, motion))), None)
        if why is None:
            _compare(header, bag, scans, motion, source.topic, notes)
            return header
        notes.append(f"{why}: the times at which the bag received the messages are used")
    for messages in (scans, motion):
        if why := _no_clock(bag, messages):
            raise UserError(f"{why} in the bag", where=where, remedy="cut the bag there")
    return bag


def _no_clock(clock: Clock, messages: Sequence[Message]) -> str | None:
    """Why messages cannot be ordered by a clock."""
    times = clock.times(messages)
    if np.isnan(times).any():
        return f"{np.isnan(times).sum()} of {len(times)} messages have no time in their header"
    back = -np.diff(times)
    if len(back) and back.max() > BACK:
        return f"time goes back by {back.max():.6g} s after message {int(np.argmax(back)) + 1}"
    return None


def _compare(
    header: Clock,
    bag: Clock,
    scans: Sequence[Message],
    motion: Sequence[Message],
    topic: str,
    notes: list[str],
) -> None:
    late = [float(np.median(bag.times(m) - header.times(m))) for m in (scans, motion)]
    if abs(late[0] - late[1]) > OFFSET:
        notes.append(
            f"the scans arrive {late[0]:.3g} s after their time stamps, the messages of {topic} "
            f"{late[1]:.3g} s: if their clocks differ, set stamps to bag"
        )


class TrackMaker(NamedTuple):
    """How a robot's motion is found."""

    odometry_frame: str
    bodies: tuple[str, ...]
    timeout: float | None

    def source(self, streams: Streams, named: str | None) -> Source:
        """The messages of the topic that is named, or of the best that there is.

        Raises `UserError` where there is none, or more than one of a type.
        """
        if named is not None and streams.contents.kinds.get(named) in FRAMES:
            return self._transforms(streams, needed=True)
        kinds = MOTIONS if named is not None else (ODOMETRY,)
        topic = streams.only(kinds, named, option="motion_topic")
        if topic is None and (found := self._transforms(streams, needed=False)).poses:
            return found
        if topic is None:
            topic = streams.only((TWIST, TWIST_STAMPED), None, option="motion_topic")
        if topic is None:
            raise streams.lacking(
                f"motion: no Odometry, no transforms of {self.odometry_frame}, no Twist"
            )
        messages = streams.by_topic[topic]
        poses = [message for message in messages if isinstance(message, Located)]
        commands = [message for message in messages if isinstance(message, Command)]
        return Source(topic, poses, commands)

    def _transforms(self, streams: Streams, *, needed: bool) -> Source:
        """The transforms from the odometry's frame to the robot's body."""
        children = [child for parent, child in streams.moving if parent == self.odometry_frame]
        body = next((body for body in self.bodies if body in children), None)
        if body is None and len(children) == 1:
            body = children[0]
        if body is None and needed:
            pairs = sorted(f"{parent} to {child}" for parent, child in streams.moving)
            raise UserError(
                f"no transform leads from {self.odometry_frame} to {' or '.join(self.bodies)}; "
                f"there are {', '.join(pairs[:8])}" + ", ..." * (len(pairs) > 8),
                where=streams.path,
                remedy="choose odometry_frame and base_frame",
            )
        if body is None:
            return Source("", [], [])
        found = streams.moving[self.odometry_frame, body]
        return Source(f"transforms {self.odometry_frame} to {body}", found, [])

    def motion(
        self, source: Source, clock: Clock, scans: Float[np.ndarray, " N"], notes: list[str]
    ) -> Motion:
        """The poses by odometry or by commands. Raises `UserError` for fewer than two."""
        of_both: list[Located | Command] = [*source.poses, *source.commands]
        messages, times = clock.sort(of_both, source.topic, notes)
        if len(messages) < 2:
            raise UserError(
                f"there are only {len(messages)} messages of motion in {source.topic}",
                remedy="choose another motion_topic",
            )
        if not source.commands:
            notes.append(f"motion by odometry: {len(messages)} poses of {source.topic}")
            return Motion(times, np.array([m.place for m in messages if isinstance(m, Located)]))
        held = "until the next" if self.timeout is None else f"for {self.timeout:g} s at most"
        notes.append(
            f"motion by {len(messages)} commands of {source.topic}, each executed {held}: what the "
            "robot was asked to do, not what it did"
        )
        velocity = np.array([m.velocity for m in messages if isinstance(m, Command)])
        within = scans[(scans >= times[0]) & (scans <= times[-1])]
        return commanded(times, velocity, within, timeout=self.timeout)
