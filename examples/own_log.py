"""Learn from a robot's log: here a small table, written first as a robot might have."""

import tempfile
from pathlib import Path

import numpy as np

import motorspace as ms

# A robot drives back and forth in front of a wall, and measures how far away it is.
speed = np.random.default_rng(0).uniform(-1, 1, 600)
wall = 20 - np.concatenate([[0], np.cumsum(speed[:-1])])
rows = np.column_stack([0.1 * np.arange(600), speed, wall])

with tempfile.TemporaryDirectory() as folder:
    log = Path(folder) / "robot.csv"
    np.savetxt(log, rows, "%.4f", delimiter=",", header="time,motor_speed,sensor_wall", comments="")
    training = ms.TrainingConfig(epochs=100, trajectories_per_epoch=500, batch_size=50)
    run = ms.train(ms.RunConfig(ms.Logged(log, horizon=3), training=training))
    print(ms.evaluate(run))
