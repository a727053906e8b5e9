"""Messages of robots as plain numbers, decoded with rosbags (the extra `ros`)."""

import math
from collections.abc import Callable
from typing import Any, NamedTuple

import numpy as np
from jaxtyping import Float

from motorspace._errors import UserError
from motorspace.recordings.bags.container import INSTALL, Raw

Place = tuple[float, float, float]

SCAN = "sensor_msgs/msg/LaserScan"
ODOMETRY = "nav_msgs/msg/Odometry"
TWIST = "geometry_msgs/msg/Twist"
TWIST_STAMPED = "geometry_msgs/msg/TwistStamped"
TRANSFORMS = "tf2_msgs/msg/TFMessage"
TRANSFORMS_DEFINED = "geometry_msgs/TransformStamped[] transforms"
OLD_TRANSFORMS = "tf/msg/tfMessage"
POSE = "geometry_msgs/msg/PoseStamped"
POSE_COVARIANCE = "geometry_msgs/msg/PoseWithCovarianceStamped"


class Stamped(NamedTuple):
    """When a message is from."""

    header: float
    """Seconds by its own header; NaN where it has none."""
    bag: float
    """Seconds, when it was recorded."""


class LaserScan(NamedTuple):
    """One scan, its beams counter-clockwise."""

    stamp: Stamped
    frame: str
    first: float
    """Angle of the first beam in the frame of the laser, radians."""
    step: float
    """Angle between beams, above 0."""
    ranges: Float[np.ndarray, " R"]
    """Metres; NaN where one is above 0 and below the shortest that the laser measures."""
    limit: float
    """The longest that the laser measures."""
    short: int
    """Readings below the shortest."""


class Located(NamedTuple):
    """A pose in the plane of one frame in another."""

    stamp: Stamped
    parent: str
    child: str
    place: Place
    rotation: tuple[float, float, float, float]
    """The whole rotation as a quaternion x, y, z, w."""


class Command(NamedTuple):
    """A velocity: longitudinal and lateral, in metres a second, and radians a second."""

    stamp: Stamped
    velocity: Place


Message = LaserScan | Located | Command


class Decoder:
    """From stored messages to plain ones. Raises `UserError` where rosbags is missing."""

    def __init__(self) -> None:
        try:
            from rosbags.typesys import Stores, get_types_from_msg, get_typestore
        except ImportError:
            raise UserError("ROS bags need rosbags", remedy=INSTALL) from None
        # The messages that are read here have not changed since these releases.
        self._ros1 = get_typestore(Stores.ROS1_NOETIC)
        self._ros1.register(get_types_from_msg(TRANSFORMS_DEFINED, TRANSFORMS))
        self._ros2 = get_typestore(Stores.ROS2_HUMBLE)

    def decode(self, raw: Raw) -> list[Message]:
        """The message; for transforms, one for each. Raises `UserError` for a broken one."""
        kind = TRANSFORMS if raw.kind == OLD_TRANSFORMS else raw.kind
        if raw.encoding not in ("cdr", "ros1"):
            raise _broken(raw, f"it is encoded as {raw.encoding!r}, not as ROS does")
        try:
            if raw.encoding == "ros1":
                found = self._ros1.deserialize_ros1(raw.data, kind)
            else:
                found = self._ros2.deserialize_cdr(raw.data, kind)
            return READ[raw.kind](found, raw.time * 1e-9)
        except _Wrong as error:
            raise _broken(raw, str(error)) from None
        except (Exception, MemoryError) as error:  # what broken bytes do to a library is open
            raise _broken(raw, f"{type(error).__name__}: {error}"[:120]) from None


class _Wrong(Exception):
    """Why the numbers in a message make no sense."""


def _scan(found: Any, bag: float) -> list[Message]:
    ranges = np.array(found.ranges, np.float32)
    first, step = float(found.angle_min), float(found.angle_increment)
    if not len(ranges):
        raise _Wrong("the scan has no beams")
    if len(ranges) > 1 and not (math.isfinite(first) and 0 < abs(step) < math.inf):
        raise _Wrong(f"its angles begin at {first:g} and go on by {step:g}")
    if step < 0:
        first, step, ranges = first + step * (len(ranges) - 1), -step, ranges[::-1].copy()
    if step * (len(ranges) - 1) > 2 * math.pi + 2 * step:
        raise _Wrong(f"its {len(ranges)} beams span more than a full turn")
    short = (ranges > 0) & (ranges < found.range_min)
    ranges[short] = np.nan
    limit = float(found.range_max) if found.range_max > 0 else math.inf
    stamp = Stamped(_seconds(found.header), bag)
    frame = str(found.header.frame_id).lstrip("/")
    return [LaserScan(stamp, frame, first, step, ranges, limit, int(short.sum()))]


def _odometry(found: Any, bag: float) -> list[Message]:
    return [_located(found.header, found.child_frame_id, found.pose.pose, bag)]


def _pose(found: Any, bag: float) -> list[Message]:
    return [_located(found.header, "", found.pose, bag)]


def _pose_covariance(found: Any, bag: float) -> list[Message]:
    return [_located(found.header, "", found.pose.pose, bag)]


def _transforms(found: Any, bag: float) -> list[Message]:
    return [
        _at(
            each.header,
            each.child_frame_id,
            each.transform.translation,
            each.transform.rotation,
            bag,
        )
        for each in found.transforms
    ]


def _located(header: Any, child: str, pose: Any, bag: float) -> Located:
    return _at(header, child, pose.position, pose.orientation, bag)


def _at(header: Any, child: str, position: Any, quaternion: Any, bag: float) -> Located:
    x, y, z, w = (float(getattr(quaternion, name)) for name in "xyzw")
    place = (float(position.x), float(position.y), _yaw(x, y, z, w))
    if not all(map(math.isfinite, place)) or x == y == z == w == 0:
        raise _Wrong("its pose is not finite, or has no direction")
    stamp = Stamped(_seconds(header), bag)
    frames = str(header.frame_id).lstrip("/"), str(child).lstrip("/")
    return Located(stamp, *frames, place, (x, y, z, w))


def _yaw(x: float, y: float, z: float, w: float) -> float:
    """The angle about the vertical axis of a rotation, whose length does not matter."""
    return math.atan2(2 * (w * z + x * y), w * w + x * x - y * y - z * z)


def _twist(found: Any, bag: float) -> list[Message]:
    return [_command(found, Stamped(math.nan, bag))]


def _twist_stamped(found: Any, bag: float) -> list[Message]:
    return [_command(found.twist, Stamped(_seconds(found.header), bag))]


def _command(twist: Any, stamp: Stamped) -> Command:
    velocity = (float(twist.linear.x), float(twist.linear.y), float(twist.angular.z))
    if not all(map(math.isfinite, velocity)):
        raise _Wrong("its velocity is not finite")
    return Command(stamp, velocity)


def _seconds(header: Any) -> float:
    """The stamp of a header; NaN where it was left at zero."""
    stamp = header.stamp.sec + header.stamp.nanosec * 1e-9
    return stamp if stamp > 0 else math.nan


def _broken(raw: Raw, why: str) -> UserError:
    return UserError(
        f"a {raw.kind.rpartition('/')[2]} message cannot be read ({why})",
        where=raw.place,
        remedy="correct the bag",
    )


READ: dict[str, Callable[[Any, float], list[Message]]] = {
    SCAN: _scan,
    ODOMETRY: _odometry,
    TWIST: _twist,
    TWIST_STAMPED: _twist_stamped,
    TRANSFORMS: _transforms,
    OLD_TRANSFORMS: _transforms,
    POSE: _pose,
    POSE_COVARIANCE: _pose_covariance,
}
"""The types that are read, and how."""
