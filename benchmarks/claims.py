"""What is claimed of the rates."""

from collections.abc import Mapping, Sequence
from typing import Any

from benchmarks.whole_table import SAMPLES
from motorspace.reports.tables import shown
from motorspace.studies.rows import Row, Spread
from motorspace.studies.study import Line, Target
from motorspace.studies.targets import Claim, Reason, explained

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

SHOWN = (
    ("trajectories", 2, "VMAS, batch 8192"),
    ("one agent's sensed steps", 1, "pymunk"),
    ("one agent's sensed steps", 1, "ir-sim"),
    ("training, batch 100", 2, "torch.compile, fused Adam"),
    ("training, batch 1000", 2, "torch.compile, fused Adam"),
    ("many agents' sensed steps", 2, "VMAS, batch 8192"),
    ("a system of the paper", 2, "VMAS and torch.compile"),
    ("scans", 2, "Open3D"),
    ("scans", 2, "VMAS"),
    ("scans among many walls", 1, "own brute force"),
)
"""The rows of the short table."""


class Launches(Spread):
    """Lowest, median and highest over launches; tables show the median."""

    @property
    def mean(self) -> float:
        """The median."""
        return sorted(self.values)[len(self.values) // 2]

    @property
    def ends(self) -> dict[str, float]:
        """The median, without a range."""
        return {"mean": self.mean, "low": self.mean, "high": self.mean}


def claims(rows: Sequence[Mapping[str, Any]], reasons: Sequence[Reason] = ()) -> list[Claim]:
    """Every target that is measured in `rows`, with the reasons for those that are missed."""
    made = [
        _claim(
            f"{row['work']}, {row['threads']} threads: rate over that of {row['peer']}",
            "ratio",
            launches(row["ratio"]),
            at_least=target,
        )
        for row in rows
        if (target := TARGETS.get(_work(row)))
    ]
    made += [claim for row in rows for claim in _of_ourselves(row)]
    return [explained(claim, reasons) for claim in made]


def _of_ourselves(row: Mapping[str, Any]) -> list[Claim]:
    match row["work"]:
        case "the whole table":
            minutes = in_minutes(row["ours"], SAMPLES)
            return [_claim("the whole table on two cores", "minutes", minutes, at_most=60.0)]
        case "an epoch of the paper":
            share = launches(row["ratio"])
            return [_claim("share of an epoch that sampling takes", "ratio", share, at_most=0.02)]
        case "make demo":
            empty, full = in_minutes(row["ours"], 1), in_minutes(row["theirs"], 1)
            return [
                _claim("make demo, caches empty", "minutes", empty, at_most=5.0),
                _claim("make demo, caches full", "minutes", full, at_most=2.0),
            ]
        case "a report on 100,000 codes" as work:
            minutes, size = in_minutes(row["ours"], 1), launches(row["peak GiB"])
            return [
                _claim(work, "minutes", minutes, at_most=1.0),
                _claim(work, "GiB", size, at_most=4.0),
            ]
    return []


def _claim(claim: str, measure: str, measured: Launches, **bound: float) -> Claim:
    named = claim if measure == "ratio" else f"{claim}, in {measure}"
    target = Target(named, measure, every_seed=True, **bound)
    return Claim(target, Row("benchmarks", {}, 0, {}), measured)


def launches(spread: Mapping[str, float]) -> Launches:
    """The launches behind a median and its range."""
    return Launches((spread["low"], spread["median"], spread["high"]))


def in_minutes(rate: Mapping[str, float], amount: float) -> Launches:
    """How long `amount` takes at rates per second."""
    return Launches(tuple(amount / value / 60 for value in launches(rate).values))


def tables(file: Mapping[str, Any], reasons: Sequence[Reason]) -> dict[str, Sequence[Line]]:
    """The tables of the documentation, from what `make bench` has measured."""
    found, rows = claims(file["rows"], reasons), file["rows"]
    return {
        "benchmarks": [_rates(row) for row in rows],
        "benchmarks_short": [_medians(row) for row in rows if _work(row) in SHOWN],
        "performance_targets": [
            {"target": c.sentence, "measured": c.measured.mean, "range": _range(c), "met": c.met}
            for c in found
        ],
        "performance_missed": [
            {"target": c.sentence, "measured": c.measured.mean, "reason": c.reason}
            for c in found
            if not c.met
        ],
    }


def _work(row: Mapping[str, Any]) -> tuple[str, int, str]:
    return row["work"], row["threads"], row["peer"]


def _rounded(rate: float) -> str:
    return f"{float(f'{rate:.3g}'):,.0f}" if rate >= 1000 else shown(rate)


def _medians(row: Mapping[str, Any]) -> Line:
    return {
        "work": row["work"],
        "unit": f"{row['unit']}/s",
        "motorspace": _rounded(row["ours"]["median"]),
        "peer": row["peer"],
        "its rate": _rounded(row["theirs"]["median"]),
        "ratio": row["ratio"]["median"],
    }


def _rates(row: Mapping[str, Any]) -> Line:
    """Ours beside a peer, the median and the range over launches."""

    def spread(values: Mapping[str, float]) -> str:
        low, median, high = map(_rounded, launches(values).values)
        return f"{median} ({low} to {high})"

    return {
        "work": row["work"],
        "threads": row["threads"],
        "vectors": row["processor"].split(", ")[-1],
        "unit": f"{row['unit']}/s",
        "motorspace": spread(row["ours"]),
        "peer": row["peer"],
        "its rate": spread(row["theirs"]),
        "ratio": spread(row["ratio"]),
    }


def _range(claim: Claim) -> str:
    low, high = map(shown, claim.measured.range)
    return f"{low} to {high}"
