"""Draw a layout of one's own, and let an agent explore it."""

import tempfile
from pathlib import Path

import jax

import motorspace as ms

TWO_ROOMS = """
title   Two rooms with a door
bounds  0 0 20 10
wall    10 0  10 4
wall    10 6  10 10
"""

with tempfile.TemporaryDirectory() as folder:
    file = Path(folder) / "two_rooms.layout"
    file.write_text(TWO_ROOMS)
    scenario = ms.Scenario(file, ms.HolonomicAgent(), ms.RangeFan(num_rays=5))

walks = ms.sample(scenario, num=5, horizon=6, key=jax.random.key(0))
print("sensors before", walks.experience.sensors, sep="\n")
print("displacements (longitudinal, lateral, orientation)", walks.displacements.achieved, sep="\n")
