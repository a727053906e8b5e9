"""Small bags of a robot that drives an arc, written with rosbags."""

import math
from types import SimpleNamespace

import numpy as np

HZ = 10
START = 1_700_000_000
SPEED, TURN = 0.5, 0.4
BEAMS = 9


def store(version):
    from rosbags.typesys import Stores, get_types_from_msg, get_typestore

    if version == 2:
        return get_typestore(Stores.ROS2_HUMBLE)
    found = get_typestore(Stores.ROS1_NOETIC)
    transforms = "geometry_msgs/TransformStamped[] transforms"
    found.register(get_types_from_msg(transforms, "tf2_msgs/msg/TFMessage"))
    return found


class Bag:
    """Messages by topic, in the order in which they were received.

    Args:
        version: 1 or 2, of ROS.
    """

    def __init__(self, version=2):
        self.version = version
        self.store = store(version)
        self.types = {}
        self.written = []

    def make(self, kind, **fields):
        return self.store.types[kind](**fields)

    def header(self, time, frame):
        stamp = self.make(
            "builtin_interfaces/msg/Time", sec=int(time), nanosec=round(time % 1 * 1e9)
        )
        counted = {"seq": 0} if self.version == 1 else {}
        return self.make("std_msgs/msg/Header", stamp=stamp, frame_id=frame, **counted)

    def add(self, topic, kind, time, message):
        self.types[topic] = kind
        self.written.append((round(time * 1e9), topic, message))

    def vector(self, x=0.0, y=0.0, z=0.0):
        return self.make("geometry_msgs/msg/Vector3", x=x, y=y, z=z)

    def pose(self, x, y, angle, roll=0.0):
        point = self.make("geometry_msgs/msg/Point", x=x, y=y, z=0.0)
        return self.make(
            "geometry_msgs/msg/Pose", position=point, orientation=self.quaternion(angle, roll)
        )

    def quaternion(self, angle, roll=0.0):
        (cz, sz), (cx, sx) = ((math.cos(a / 2), math.sin(a / 2)) for a in (angle, roll))
        return self.make("geometry_msgs/msg/Quaternion", x=cz * sx, y=sz * sx, z=sz * cx, w=cz * cx)

    def scan(self, time, ranges=None, topic="/scan", bag_time=None, **fields):
        ranges = np.arange(1, BEAMS + 1) if ranges is None else np.asarray(ranges)
        defaults = {
            "angle_min": -math.pi / 2,
            "angle_max": math.pi / 2,
            "angle_increment": math.pi / max(len(ranges) - 1, 1),
            "time_increment": 0.0,
            "scan_time": 0.1,
            "range_min": 0.1,
            "range_max": 30.0,
            "ranges": ranges.astype(np.float32),
            "intensities": np.zeros(0, np.float32),
        }
        kind = "sensor_msgs/msg/LaserScan"
        header = self.header(time, fields.pop("frame", "laser"))
        message = self.make(kind, header=header, **defaults | fields)
        self.add(topic, kind, time if bag_time is None else bag_time, message)

    def odometry(self, time, place, topic="/odom", bag_time=None):
        with_covariance = self.make(
            "geometry_msgs/msg/PoseWithCovariance", pose=self.pose(*place), covariance=np.zeros(36)
        )
        still = self.make(
            "geometry_msgs/msg/TwistWithCovariance", twist=self.twist(), covariance=np.zeros(36)
        )
        kind = "nav_msgs/msg/Odometry"
        message = self.make(
            kind,
            header=self.header(time, "odom"),
            child_frame_id="base_link",
            pose=with_covariance,
            twist=still,
        )
        self.add(topic, kind, time if bag_time is None else bag_time, message)

    def twist(self, ahead=0.0, turn=0.0):
        return self.make(
            "geometry_msgs/msg/Twist", linear=self.vector(ahead), angular=self.vector(z=turn)
        )

    def command(self, time, ahead, turn, topic="/cmd_vel"):
        self.add(topic, "geometry_msgs/msg/Twist", time, self.twist(ahead, turn))

    def transform(self, time, parent, child, place, topic="/tf", roll=0.0):
        x, y, angle = place
        transform = self.make(
            "geometry_msgs/msg/Transform",
            translation=self.vector(x, y),
            rotation=self.quaternion(angle, roll),
        )
        stamped = self.make(
            "geometry_msgs/msg/TransformStamped",
            header=self.header(time, parent),
            child_frame_id=child,
            transform=transform,
        )
        kind = "tf2_msgs/msg/TFMessage"
        self.add(topic, kind, time, self.make(kind, transforms=[stamped]))

    def text(self, time, words="hello", topic="/chatter"):
        kind = "std_msgs/msg/String"
        self.add(topic, kind, time, self.make(kind, data=words))

    def write(self, path, plugin="sqlite3"):
        """Write the bag and return the path that a person would give."""
        if self.version == 1:
            return self._write_1(path)
        from rosbags.rosbag2 import StoragePlugin, Writer

        kind = StoragePlugin.MCAP if plugin == "mcap" else StoragePlugin.SQLITE3
        with Writer(path, version=9, storage_plugin=kind) as writer:
            self._write(writer, self.store.serialize_cdr)
        return path

    def _write_1(self, path):
        from rosbags.rosbag1 import Writer

        with Writer(path) as writer:
            self._write(writer, self.store.serialize_ros1)
        return path

    def _write(self, writer, serialize):
        connections = {
            topic: writer.add_connection(topic, kind, typestore=self.store)
            for topic, kind in self.types.items()
        }
        for time, topic, message in self.written:
            content = message if isinstance(message, bytes) else None
            content = content or serialize(message, self.types[topic])
            writer.write(connections[topic], time, content)


def place_at(time):
    """Where a robot is that has driven an arc from time 0 on."""
    angle = TURN * time
    radius = SPEED / TURN
    return radius * math.sin(angle), radius * (1 - math.cos(angle)), angle


def driving(version=2, scans=30, motion="odometry", rate=20, mounted=True):
    """A robot on an arc: scans at 10 Hz between messages of motion at `rate` Hz."""
    bag = Bag(version)
    if mounted:
        bag.transform(START, "base_link", "laser", (0.1, 0.0, 0.0), topic="/tf_static")
    events = [(k / rate, motion) for k in range(int(scans / HZ * rate) + 1)]
    events += [(0.03 + k / HZ, "scan") for k in range(scans - 1)]
    for time, what in sorted(events):
        if what == "scan":
            bag.scan(START + time, ranges=np.arange(1, BEAMS + 1) + 0.01 * time)
        elif what == "odometry":
            bag.odometry(START + time, place_at(time))
        elif what == "transforms":
            bag.transform(START + time, "odom", "base_link", place_at(time))
        elif what == "commands":
            bag.command(START + time, SPEED, TURN)
    return bag


def bag_files(path):
    """The one file of messages in a folder."""
    return next(p for p in path.iterdir() if p.suffix in (".db3", ".mcap"))


EXPECTED = SimpleNamespace(step=SPEED / HZ, turn=TURN / HZ)
