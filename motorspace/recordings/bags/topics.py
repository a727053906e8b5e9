"""Which topics of a bag are read: those that are named, or the only ones of their type."""

from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING, NamedTuple

import numpy as np
from jaxtyping import Float

from motorspace._errors import UserError
from motorspace.recordings.bags.container import Contents
from motorspace.recordings.bags.messages import (
    ODOMETRY,
    OLD_TRANSFORMS,
    POSE,
    POSE_COVARIANCE,
    SCAN,
    TRANSFORMS,
    TWIST,
    TWIST_STAMPED,
    LaserScan,
    Located,
    Message,
)
from motorspace.recordings.readers.faults import Faults
from motorspace.recordings.readers.motion import Motion, interpolated

if TYPE_CHECKING:
    from motorspace.recordings.bags.tracks import Clock

MOST_READINGS = 100_000_000
MOST_MESSAGES = 5_000_000
"""What is kept of one bag at most."""

MOTIONS = (ODOMETRY, TWIST, TWIST_STAMPED)
TRUTHS = (ODOMETRY, POSE, POSE_COVARIANCE)
FRAMES = (TRANSFORMS, OLD_TRANSFORMS)

APART = 1.0
"""Seconds between true poses from which on those in between are unknown."""


class Wanted(NamedTuple):
    """The topics that a person named; None where the type decides."""

    scan: str | None
    motion: str | None
    truth: str | None

    def wants(self, topic: str, kind: str) -> bool:
        """Whether messages of a topic are read."""
        if kind == SCAN:
            return self.scan in (None, topic)
        if kind in FRAMES or (topic == self.truth and kind in TRUTHS):
            return True
        return kind in MOTIONS and self.motion in (None, topic)


@dataclass
class Streams:
    """The messages of use in a bag."""

    path: Path
    contents: Contents
    faults: Faults
    """What was left out of the bag."""
    by_topic: dict[str, list[Message]] = field(default_factory=dict)
    """Scans, poses and commands; transforms are in `moving`."""
    frames: dict[tuple[str, str], Located] = field(default_factory=dict)
    """The last transform of each (parent, child)."""
    moving: dict[tuple[str, str], list[Located]] = field(default_factory=dict)
    """All transforms of each (parent, child)."""
    notes: list[str] = field(default_factory=list)
    _kept: int = 0
    _readings: int = 0

    def add(self, topic: str, found: list[Message]) -> None:
        """Keep messages. Raises `UserError` where they are too many for memory."""
        self._kept += len(found)
        for message in found:
            if isinstance(message, LaserScan):
                self._readings += len(message.ranges)
            if isinstance(message, Located) and self.contents.kinds[topic] in FRAMES:
                frames = message.parent, message.child
                self.frames[frames] = message
                self.moving.setdefault(frames, []).append(message)
            else:
                self.by_topic.setdefault(topic, []).append(message)
        if self._readings > MOST_READINGS or self._kept > MOST_MESSAGES:
            raise UserError(
                f"the bag holds more than {MOST_READINGS:,} laser readings or "
                f"{MOST_MESSAGES:,} messages of motion",
                where=self.path,
                remedy="cut it into parts, or name the topics to read",
            )

    def scans(self, named: str | None) -> tuple[str, list[LaserScan]]:
        """The topic of the scans, and its messages. Raises `UserError` where it is not clear."""
        topic = self.only((SCAN,), named, option="scan_topic")
        if topic is None:
            raise self.lacking("laser scans (LaserScan)")
        return topic, [m for m in self.by_topic.get(topic, []) if isinstance(m, LaserScan)]

    def only(self, kinds: tuple[str, ...], named: str | None, *, option: str) -> str | None:
        """The topic that is named, or the only one of these types; None if there is none."""
        known = self.contents.kinds
        if named is not None:
            if known.get(named) in kinds and self.by_topic.get(named):
                return named
            raise self.lacking(f"messages of {' or '.join(map(_short, kinds))} in {named}")
        found = sorted(topic for topic, kind in known.items() if kind in kinds)
        found = [topic for topic in found if self.by_topic.get(topic)]
        if len(found) > 1:
            listed = ", ".join(f"{topic} ({self.contents.counts[topic]})" for topic in found)
            raise UserError(
                f"there are several topics of {' or '.join(map(_short, kinds))}: {listed}",
                where=self.path,
                remedy=f"choose one with {option} (--{option.replace('_', '-')})",
            )
        return found[0] if found else None

    def truth(
        self, named: str | None, clock: "Clock", times: Float[np.ndarray, " N"]
    ) -> Float[np.ndarray, "N 3"] | None:
        """The true poses at the times of the scans, NaN where unknown; None without a topic."""
        if named is None:
            return None
        topic = self.only(TRUTHS, named, option="truth_topic")
        found = [m for m in self.by_topic.get(topic or "", []) if isinstance(m, Located)]
        found, known = clock.sort(found, named, self.notes)
        if len(found) < 2:
            raise self.lacking(f"two true poses in {named}")
        poses = interpolated(Motion(known, np.array([m.place for m in found])), times)
        after = np.clip(np.searchsorted(known, times), 1, len(known) - 1)
        outside = (times < known[0]) | (times > known[-1])
        poses[outside | (known[after] - known[after - 1] > APART)] = np.nan
        self.notes.append(f"true poses: {named}; {np.isnan(poses[:, 0]).sum()} scans have none")
        return poses

    def lacking(self, what: str) -> UserError:
        """The error for a bag without something; it names what there is."""
        topics = [f"{t} ({_short(k)})" for t, k in sorted(self.contents.kinds.items())]
        listed = ", ".join(topics[:12]) + ", ..." * (len(topics) > 12)
        return UserError(
            f"the bag holds no {what}; its topics are {listed or 'none'}",
            where=self.path,
            remedy="; ".join(
                ["give a bag that has them, or name other topics", *self.faults.notes()[:2]]
            ),
        )

    def note_unread(self, used: set[str]) -> None:
        """Say which topics hold messages that are not read."""
        counts = self.contents.counts
        kinds = self.contents.kinds
        unread = [t for t in sorted(counts) if t not in used and kinds[t] not in FRAMES]
        if unread:
            listed = ", ".join(f"{counts[t]} {t} ({_short(kinds[t])})" for t in unread[:12])
            more = f" and {len(unread) - 12} more" * (len(unread) > 12)
            self.notes.append(f"topics that are not read: {listed}{more}")


def _short(kind: str) -> str:
    return kind.rpartition("/")[2]
