"""Draw a layout of one's own, and let an agent explore it."""

import tempfile
from pathlib import Path

import jax

import motorspace as ms

with tempfile.TemporaryDirectory() as folder:
    file = Path(folder) / "two_rooms.layout"
    file.write_text(
        "title   Two rooms with a door\nbounds  0 0 20 10\nwall 10 0  10 4\nwall 10 6  10 10\n"
    )
    world = ms.layout(str(file))

trajectories = ms.sample(
    ms.Scenario(world, ms.HolonomicAgent()), num=5, horizon=6, key=jax.random.key(0)
)
print(trajectories.displacements.achieved)
