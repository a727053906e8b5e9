"""What is claimed of the rates."""

from typing import Any

from motorspace.experiments.summary import claimed

from benchmarks.whole_table import SAMPLES

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
            in_the_middle(row["ratio"]),
            least=target,
        )
        for row in rows
        if (target := TARGETS.get((row["work"], row["threads"], row["peer"])))
    ]
    for row in rows:
        match row["work"]:
            case "the whole table":
                minutes = in_minutes(row["ours"], SAMPLES)
                made.append(claimed("the whole table on two cores, in minutes", minutes, most=60.0))
            case "an epoch of the paper":
                share = in_the_middle(row["ratio"])
                made.append(claimed("share of an epoch that sampling takes", share, most=0.02))
            case "make demo":
                cold, warm = in_minutes(row["ours"], 1), in_minutes(row["theirs"], 1)
                made.append(claimed("make demo, caches empty, in minutes", cold, most=5.0))
                made.append(claimed("make demo, caches full, in minutes", warm, most=2.0))
            case "a report on 100,000 codes" as work:
                made.append(claimed(f"{work}, in minutes", in_minutes(row["ours"], 1), most=1.0))
                size = in_the_middle(row["peak GiB"])
                made.append(claimed(f"{work}, in GiB of memory", size, most=4.0))
    return made


def in_the_middle(spread: dict[str, float]) -> dict[str, float]:
    """The median over launches as what is claimed."""
    return spread | {"mean": spread["median"]}


def in_minutes(rate: dict[str, float], amount: float) -> dict[str, float]:
    """How long `amount` takes at the median, the highest and the lowest rate per second."""
    ends = {"mean": "median", "low": "high", "high": "low"}
    return {name: amount / rate[end] / 60 for name, end in ends.items()}
