"""What is claimed of the rates."""

from typing import Any

from benchmarks.whole_table import SAMPLES
from motorspace.experiments.summary import claimed

TARGETS = {
    ("scans", 2, "Open3D"): 20.0,
    ("scans", 2, "VMAS"): 150.0,
    ("trajectories", 2, "VMAS, batch 1024"): 40.0,
    ("trajectories", 2, "VMAS, batch 8192"): 40.0,
    ("one agent's sensed steps", 1, "pymunk"): 1.0,
    ("one agent's sensed steps", 1, "ir-sim"): 1.0,
    ("one agent's sensed steps", 1, "RatInABox, no sensors"): 1.0,
    ("scans among many walls", 1, "own brute force"): 50.0,
    ("training, batch 1000", 2, "nn.LSTM, fused Adam"): 1.7,
    ("training, batch 1000", 2, "torch.compile, fused Adam"): 1.2,
    ("training, batch 100", 2, "nn.LSTM, fused Adam"): 1.3,
    ("training, batch 100", 2, "torch.compile, fused Adam"): 1.15,
    ("training, batch 1000", 2, "FMA peak"): 0.38,
    ("scans beside tables", 1, "giant table"): 8.0,
    ("scans beside tables", 1, "marching in a map of distances"): 100.0,
    ("trajectories", 2, "sampler by hand"): 0.25,
    ("many agents' sensed steps", 2, "JaxNav, batch 256"): 50.0,
    ("many agents' sensed steps", 2, "VMAS, batch 8192"): 50.0,
    ("one agent's sensed steps", 1, "simple-playgrounds"): 1.0,
    ("a system of the paper", 2, "VMAS and nn.LSTM"): 1.7,
    ("a system of the paper", 2, "VMAS and torch.compile"): 1.7,
}
"""How many times as fast as a peer we want to be, at least; of the peak, which share."""


def claims(rows: list[dict[str, Any]]) -> list[dict[str, Any]]:
    """Every target that is measured in `rows`, and whether it holds."""
    made = [
        claimed(
            f"{row['work']}, {row['threads']} threads: rate over that of {row['peer']}",
            row["ratio"] | {"mean": row["ratio"]["median"]},
            least=target,
        )
        for row in rows
        if (target := TARGETS.get((row["work"], row["threads"], row["peer"])))
    ]
    for row in rows:
        if row["work"] == "the whole table":
            minutes = {
                name: SAMPLES / row["ours"][opposite] / 60
                for name, opposite in (("mean", "median"), ("low", "high"), ("high", "low"))
            }
            made.append(claimed("the whole table on two cores, in minutes", minutes, most=60.0))
    return made
