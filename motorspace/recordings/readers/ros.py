"""ROS 1 bags, ROS 2 bags and MCAP files: laser scans, and the motion between them."""

from dataclasses import dataclass, field
from pathlib import Path
from typing import Literal

import numpy as np

from motorspace._errors import UserError
from motorspace.recordings.bags import mcap, ros1, sqlite
from motorspace.recordings.bags.container import Contents
from motorspace.recordings.bags.files import messages
from motorspace.recordings.bags.messages import Decoder, LaserScan
from motorspace.recordings.bags.mounting import Mount, beams, mount
from motorspace.recordings.bags.topics import Streams, Wanted
from motorspace.recordings.bags.tracks import TrackMaker, clocked
from motorspace.recordings.readers.faults import Faults
from motorspace.recordings.readers.lasers import NOWHERE, LaserReader, Log, Odometry, Scan
from motorspace.recordings.readers.motion import Motion, interpolated, pauses

MAGICS = (ros1.MAGIC, sqlite.MAGIC, mcap.MAGIC, b"rosbag2_bagfile_information")


@dataclass(frozen=True)
class RosReader(LaserReader):
    """Reads LaserScan messages with Odometry, transforms or Twist commands (the extra `ros`).

    Metres, radians, seconds. Motor increments are (longitudinal, lateral, rotation). Takes a
    `.bag`, a `.db3`, an `.mcap`, or the folder of a ROS 2 bag.
    """

    scan_topic: str | None = None
    """Topic of the scans (default: the only one of LaserScan)."""
    motion_topic: str | None = None
    """Topic of the motion: Odometry, transforms (/tf), Twist or TwistStamped (default: the only one
    of Odometry; else transforms of the odometry's frame; else the only one of commands)."""
    truth_topic: str | None = None
    """Topic of true poses, for evaluation only: Odometry, PoseStamped or
    PoseWithCovarianceStamped."""
    odometry_frame: str = "odom"
    """Frame in which transforms say where the robot is."""
    base_frame: str | None = None
    """Frame of the robot's body (default: base_link, base_footprint or base)."""
    laser_yaw: float | None = field(default=None, metadata={"in_pi": True})
    """Angle from the robot's heading to the laser's (default: as the bag's transforms say)."""
    stamps: Literal["header", "bag"] = "header"
    """Time stamps: those in the messages' headers, or when the bag received them."""
    command_timeout: float | None = None
    """Seconds after which a robot that hears no new Twist stands still (default: never)."""

    @classmethod
    def recognises(cls, name: str, head: bytes) -> bool:
        """Whether it begins as a bag does, or as the metadata of one."""
        return head.startswith(MAGICS)

    def parse_rows(self, path: Path, faults: Faults) -> Log:
        """Scans and odometry in order of time, each scan with its pose by odometry."""
        streams = self._streams(path, faults)
        scan_topic, scans = streams.scans(self.scan_topic)
        maker = TrackMaker(self.odometry_frame, self._bodies(), self.command_timeout)
        source = maker.source(streams, self.motion_topic)
        clock = clocked(self.stamps, scans, source, streams.notes, where=path)
        scans, times = clock.sort(scans, scan_topic, streams.notes)
        motion = maker.motion(source, clock, times, streams.notes)
        mounted = self._mount(streams, scans)
        streams.notes += _readings_note(scans, scan_topic)
        truth = streams.truth(self.truth_topic, clock, times)
        rows = _rows(scans, times, motion, truth, mounted, streams.notes)
        streams.note_unread({scan_topic, source.topic, self.truth_topic or ""})
        gaps = () if source.commands else pauses(motion, times)
        return Log(rows, streams.notes, gaps)

    def _bodies(self) -> tuple[str, ...]:
        return (self.base_frame,) if self.base_frame else ("base_link", "base_footprint", "base")

    def _streams(self, path: Path, faults: Faults) -> Streams:
        """All messages of use, by topic."""
        decoder = Decoder()
        wanted = Wanted(self.scan_topic, self.motion_topic, self.truth_topic)
        streams = Streams(path, Contents(wanted.wants), faults)
        for raw in messages(path, streams.contents, faults):
            try:
                found = decoder.decode(raw)
            except UserError as error:
                faults.add(error)
                continue
            streams.add(raw.topic, found)
        return streams

    def _mount(self, streams: Streams, scans: list[LaserScan]) -> Mount:
        if self.laser_yaw is not None:
            return Mount(self.laser_yaw)
        frame = scans[0].frame
        found = mount(streams.frames, frame, self._bodies())
        if found is None:
            streams.notes.append(
                f"no transform says how the laser ({frame or 'without a frame'}) is mounted: it is "
                "taken to look ahead; set laser_yaw if it does not"
            )
            return Mount(0.0)
        if abs(found.yaw) > 1e-3 or not found.upright:
            streams.notes.append(
                f"the laser ({frame}) is turned by {np.degrees(found.yaw):.1f} degrees"
                + " and hangs upside down" * (not found.upright)
            )
        return found


def _rows(
    scans: list[LaserScan],
    times: np.ndarray,
    motion: Motion,
    truth: np.ndarray | None,
    mounted: Mount,
    notes: list[str],
) -> list[Odometry | Scan]:
    """Rows in order of time. Scans before and after all odometry are left out."""
    inside = (times >= motion.time[0]) & (times <= motion.time[-1])
    if not inside.all():
        notes.append(
            f"{(~inside).sum()} of {len(times)} scans are from before the first or after the last "
            "message of the motion: left out"
        )
    places = interpolated(motion, times).tolist()
    true = None if truth is None else truth.tolist()
    found: list[Odometry | Scan] = [
        Odometry((x, y, angle), time)
        for (x, y, angle), time in zip(motion.pose.tolist(), motion.time.tolist(), strict=True)
    ]
    for index in np.flatnonzero(inside).tolist():
        scan, pose = scans[index], tuple(true[index]) if true is not None else NOWHERE
        x, y, angle = places[index]
        seen = beams(scan, mounted)
        found.append(Scan(seen, pose, (x, y, angle), float(times[index]), scan.limit))
    return sorted(found, key=lambda row: row.time)


def _readings_note(scans: list[LaserScan], topic: str) -> list[str]:
    short = sum(scan.short for scan in scans)
    if not short:
        return []
    return [f"{short} readings of {topic} are below range_min: they count as not a number"]
