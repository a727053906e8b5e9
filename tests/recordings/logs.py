"""Small logs as text, as robots write them."""

import gzip
import math
from pathlib import Path

RANGES = "1 2 3 4 5 4 3 2 1"


def flaser(x, y=0.0, theta=0.0, time=0.0, ranges=RANGES, odometry=None, row="FLASER"):
    pose = f"{x} {y} {theta}"
    return f"{row} {len(ranges.split())} {ranges} {pose} {odometry or pose} {time} host {time}"


def robotlaser(x, time, ranges=RANGES, first=-math.pi / 2, limit=80.0, row="ROBOTLASER1"):
    num = len(ranges.split())
    view = -2 * first
    head = f"{row} 0 {first} {view} {view / (num - 1)} {limit} 0.01 0 {num} {ranges} 0"
    poses = "" if row.startswith("RAW") else f"{x} 0 0 {x} 0 0 0 0 0 0 0 "
    return f"{head} {poses}{time} host {time}"


def odom(x, y=0.0, theta=0.0, time=0.0):
    return f"ODOM {x} {y} {theta} 0 0 0 {time} host {time}"


def corrected_log(num=6, claimed=1.5, time=0.0):
    """A robot that turns left by 0.1 and moves 1 ahead; its odometry claims `claimed` ahead.

    The rows of odometry have no time stamps of their own unless `time` is above 0.
    """
    lines = ["# a comment", "PARAM robot_width 0.4 host 0"]
    x = y = theta = 0.0
    for scan in range(num):
        lines += [
            flaser(x, y, theta, float(scan), ranges="20.5 0.5 0.5 0.5 0.5"),
            odom(x, y, theta),
        ]
        turned = theta + 0.1
        for share in (0.5, 1.0):
            there = (x + share * claimed * math.cos(turned), y + share * claimed * math.sin(turned))
            lines.append(odom(*there, turned, time=time and scan + share))
        x, y, theta = x + math.cos(turned), y + math.sin(turned), turned
    return "\n".join(lines) + "\n"


def raw_log(num=8, steps=2, length=1.0, start=0.5, scan=flaser):
    """A robot that drives straight on: `steps` rows of odometry between two scans, all raw.

    The scans are taken at `start`, `start` + `length`, ... and `length` is what each interval has.
    """
    lines = [odom(0.0, time=0.0)]
    for index in range(num):
        here = start + index * length
        lines.append(scan(here, time=here))
        for step in range(1, steps + 1):
            there = round(here + length * (step - 0.5) / steps, 6)
            lines.append(odom(there, time=there))
    return "\n".join(lines) + "\n"


def write(path: Path, text: str, encoding: str = "utf-8") -> Path:
    content = text.encode(encoding)
    path.write_bytes(gzip.compress(content) if path.suffix == ".gz" else content)
    return path
