"""What is claimed of a GPU, and the rows of its table."""

from collections.abc import Mapping, Sequence
from typing import Any

from benchmarks.claims import Launches, rounded
from benchmarks.gpu.report import COLUMNS
from motorspace.reports.tables import number
from motorspace.studies.rows import Row
from motorspace.studies.study import Line, Target
from motorspace.studies.targets import Claim, Reason, explained

PAPER = "both agents, 5,000 epochs"
RAYS = 9

SHOWN = (
    ("trajectories", "trajectories", "131,072 at once"),
    ("scans", "scans, 12 walls", "16,384 poses"),
    ("scans", "scans, 12 walls", "262,144 poses"),
    ("scans", "scans, 7,100 walls, index", "262,144 poses"),
    ("training", "training, fixed data", "16 runs"),
    ("training", "training, fixed data", "64 runs"),
    ("training", "training, fixed data", "256 runs"),
    ("peers", "training, PyTorch nn.LSTM", "1 run"),
    ("peers", "training, PyTorch nn.LSTM, CUDA graph", "1 run"),
    ("peers", "training, PyTorch vmap, CUDA graph", "64 runs"),
    ("precision", "an update, tf32", "64 runs"),
    ("precision", "an update, bf16", "64 runs"),
    ("table", "the whole table, compilation", PAPER),
    ("table", "the whole table, training", PAPER),
)
"""Part, work and size of the rows of the short table."""


def claims(
    file: Mapping[str, Any], on_cpu: Sequence[Mapping[str, Any]], reasons: Sequence[Reason] = ()
) -> list[Claim]:
    """Every target, of rows measured on a GPU and of rows of `make bench` on two cores."""
    measured = [row for row in file["rows"] if "rate" in row]
    rates = {(row["part"], row["work"], row["size"]): row["rate"] for row in measured}
    rays = next(
        row["ours"]["median"] for row in on_cpu if row["work"] == "scans" and row["threads"] == 2
    )
    table = [
        rates["table", f"the whole table, {what}", PAPER]
        for what in ("compilation", "training", "compiled")
    ]
    scans = rates["scans", "scans, 12 walls", "16,384 poses"]
    pytorch = rates["peers", "training, PyTorch nn.LSTM", "1 run"]
    wanted = (
        ("the whole table of the paper, 36 runs, in minutes", sum(table[:2]) / 60, None, 10.0),
        (
            "samples of 64 runs at once over 64 times those of PyTorch's nn.LSTM",
            rates["training", "training, fixed data", "64 runs"] / (64 * pytorch),
            5.0,
            None,
        ),
        (
            "scans from 16,384 poses over those of two cores of a CPU",
            scans / (rays / RAYS),
            20.0,
            None,
        ),
        ("programs compiled for the whole table", table[2], None, 2.0),
    )
    return [
        explained(
            Claim(
                Target(f"GPU: {what}", "ratio", low, high, every_seed=True),
                Row("benchmarks", {}, 0, {}),
                Launches((value,)),
            ),
            reasons,
        )
        for what, value, low, high in wanted
    ]


def lines(file: Mapping[str, Any], *, short: bool) -> list[Line]:
    """The rows of the table, all of them or those that say most."""
    return [
        dict(zip(COLUMNS, _cells(row), strict=True))
        for row in file["rows"]
        if "rate" in row and (not short or (row["part"], row["work"], row["size"]) in SHOWN)
    ]


def _cells(row: Mapping[str, Any]) -> tuple[str, ...]:
    ratio = "" if row["ratio"] is None else number(row["ratio"])
    return row["work"], row["size"], rounded(row["rate"]), row["unit"], row.get("beside", ""), ratio
