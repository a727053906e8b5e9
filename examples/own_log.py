"""Learn from a robot's log: here a small table, written first as a robot might have."""

import tempfile
from pathlib import Path

import numpy as np

from motorspace.recordings.readers.base import read_log
from motorspace.recordings.recording import describe, windows

rng = np.random.default_rng(0)
speed = rng.uniform(0.0, 0.2, 200)
wall = 5.0 - np.concatenate([[0.0], np.cumsum(speed[:-1])]) % 4.0

with tempfile.TemporaryDirectory() as folder:
    file = Path(folder) / "robot.csv"
    rows = [
        f"{t * 0.1:.1f},{m:.4f},{s:.4f}" for t, (m, s) in enumerate(zip(speed, wall, strict=True))
    ]
    file.write_text("\n".join(["time,motor_speed,sensor_wall", *rows]) + "\n")
    recording = read_log(file)

print(describe(recording))
print(windows(recording, horizon_scans=3, per_scan=False).experience.motors.shape)
