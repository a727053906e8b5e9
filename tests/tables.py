"""A small robot's log, as a table, for tests that learn from one."""

import math
from pathlib import Path

import numpy as np


def write_table(path: Path, *, rows: int = 800, poses: bool = True) -> Path:
    """A robot that drives along circles in a square room, and senses its distance to two walls."""
    rng = np.random.default_rng(3)
    turns = rng.uniform(-0.6, 0.6, rows)
    heading = np.concatenate([[0.0], np.cumsum(turns)[:-1]])
    x, y = (np.cumsum(0.1 * f(heading)) for f in (np.cos, np.sin))
    names = "time,motor_turn,motor_ahead,sensor_a,sensor_b" + ",x,y,theta" * poses
    values = [np.arange(rows), turns, np.full(rows, 0.1), 5 + np.sin(x), 5 + np.cos(y)]
    values += [x, y, heading % (2 * math.pi)] * poses
    lines = [",".join(f"{value:.6f}" for value in row) for row in zip(*values, strict=True)]
    path.write_text("\n".join([names, *lines]))
    return path
