"""From runs whose organisation was measured to the rows of tables, and to targets."""

from collections.abc import Sequence
from statistics import fmean
from typing import Any

import numpy as np
from scipy.stats import bootstrap, irwinhall

from motorspace.analysis.coordinates import COMPONENTS
from motorspace.experiments import paper, topology
from motorspace.experiments.summary import Row, claimed, gather

ROWS = (*topology.PRESETS, "supervised", "shuffled", *topology.FIXED)
"""The rows of each cell: both presets, then the references."""

LEVEL = 0.95
TOLD_LENGTHS = ("6", "24")
"""Where the decoder was fitted, and the longest sequences that it is tried on."""


def gathered(results: Sequence[Row], budget: paper.Budget) -> dict[str, Row]:
    """What the runs have shown so far; see `gather`."""
    makers = {
        "topology": topology_rows,
        "ablation": ablation_rows,
        "closing": closing_rows,
        "folding": folding_rows,
        "mixed": mixed_rows,
        "angle": angle_rows,
    }
    return gather(results, makers, budget, experiment="topology")


def topology_rows(results: Sequence[Row]) -> list[Row]:
    """One row for each cell and preset or reference, and each lattice, that has finished runs."""
    cells: list[tuple[str, str, float | None, str]] = [
        (f"{agent}-{rotation} {row}", agent, rotation, row)
        for agent in paper.PAPER_ERRORS
        for rotation in paper.ROTATIONS
        for row in ROWS
    ]
    cells += [(f"lattice {kind}", "lattice", None, kind) for kind in paper.LATTICE_KINDS]
    rows = []
    for name, agent, rotation, row in cells:
        if runs := _named(results, f"topology/{name}"):
            rows.append({"agent": agent, "rotation": rotation, "row": row} | _measured(runs))
    return rows


def ablation_rows(results: Sequence[Row]) -> list[Row]:
    """One row for each change to the paper's system, between that and `best`."""
    agent, rotation = topology.ABLATION_CELL
    cell = f"topology/{agent}-{rotation}"
    names = {"paper": f"{cell} paper"}
    names |= {name: f"ablation/{name}" for rows in topology.ABLATION.values() for name in rows}
    names |= {"best": f"{cell} best"}
    return [
        {"change": change} | _measured(runs)
        for change, name in names.items()
        if (runs := _named(results, name))
    ]


def mixed_rows(results: Sequence[Row]) -> list[Row]:
    """`best` trained at T = 6 and over many lengths, both measured at T = 6."""
    lengths, rows = topology.MIXED["simulation"], []
    for rotation in topology.MIXED_ROTATIONS:
        names = {
            "T = 6": f"topology/forward-{rotation} best",
            f"T = {lengths['min_horizon']} to {lengths['horizon']}": f"mixed/forward-{rotation}",
        }
        for trained, name in names.items():
            if runs := _named(results, name):
                rows.append({"rotation": rotation, "trained at": trained} | _measured(runs))
    return rows


def closing_rows(results: Sequence[Row]) -> list[Row]:
    """One row for each way in which orientations can be reached."""
    rows = []
    for name in topology.CLOSING:
        runs = _named(results, f"closing/{name}")
        if runs:
            numbers = [
                {
                    "error": run["errors"]["model"],
                    "winding": abs(run["winding"]),
                    "seam gap": run["seam gap"],
                    "loop": run["loop"],
                    "linear R2 cos": run["probe_r2"]["cos"],
                    "nonlinear R2 cos": run["nonlinear_r2"]["cos"],
                }
                for run in runs
            ]
            shown = {key: interval([n[key] for n in numbers]) for key in numbers[0]}
            rows.append({"turns": name, "seeds": len(runs), "epochs": runs[0]["epochs"]} | shown)
    return rows


def folding_rows(results: Sequence[Row]) -> list[Row]:
    """One row for each preset, epoch and number of whole turns that sequences are apart."""
    rows = []
    for name in topology.PRESETS:
        runs = _named(results, f"folding/{name}")
        for index, told in enumerate(runs[0]["course"] if runs else []):
            for turns in sorted(told.keys() - {"epoch"}):
                values = [r["course"][index][turns] for r in runs if turns in r["course"][index]]
                row = {"row": name, "epoch": told["epoch"], "turns": turns, "seeds": len(values)}
                rows.append(row | {"ratio": interval(values)})
    return rows


def angle_rows(results: Sequence[Row]) -> list[Row]:
    """One row for each rotation and factor by which angles are wrong: the error of prediction."""
    rows = []
    for rotation in topology.ANGLE_ROTATIONS:
        told = {
            angle: {run["seed"]: run["errors"]["model"] for run in runs}
            for angle in topology.ANGLES
            if (runs := _named(results, f"angle/{rotation} x {angle}"))
        }
        for angle, errors in told.items():
            # Seeds share their data and initial weights: what differs is the angle alone.
            ratios = [errors[s] / told[1.0][s] for s in errors if s in told.get(1.0, {})]
            row: Row = {"rotation": rotation, "angle": angle, "seeds": len(errors)}
            row |= {"error": interval([*errors.values()])}
            rows.append(row | ({"ratio": interval(ratios)} if ratios else {}))
    return rows


MOST_TURNS = 3
"""How many whole turns, at most, the tables tell equivalent sequences apart by."""


def drawn_rows(rows: Sequence[Row]) -> list[Row]:
    """How far apart whole turns lie beside how often they are drawn, from `topology_rows`."""
    return [
        {"agent": row["agent"], "row": row["row"], "rotation": row["rotation"], "turns": turns}
        | {"drawn": share_of_turns(row["rotation"], turns), "ratio": row[f"{turns} full turns"]}
        for row in rows
        if row["row"] in topology.PRESETS
        for turns in range(1, MOST_TURNS + 1)
        if f"{turns} full turns" in row
    ]


def share_of_turns(rotation: float, turns: int, horizon: int = 6) -> float:
    """The share of random sequences whose net turn is nearest to `turns` > 0 whole ones, each way.

    The sum of `horizon` rotations uniform in +-`rotation` pi has the distribution of Irwin and
    Hall, stretched and shifted.
    """
    ends = np.array([2 * turns - 1, 2 * turns + 1])
    below = irwinhall(horizon).cdf((ends / rotation + horizon) / 2)
    return float(2 * (below[1] - below[0]))


def _named(results: Sequence[Row], name: str) -> list[Row]:
    return [r for r in results if r["name"] == name]


def _measured(runs: Sequence[Row]) -> Row:
    """The mean of every measure that all runs have, with the interval of the mean over seeds."""
    measures = [_numbers(run) for run in runs]
    names = [name for name in measures[0] if all(name in m for m in measures)]
    dead = sum(run["organisation"] is None for run in runs)
    return (
        {"seeds": len(runs), "epochs": runs[0]["epochs"]}
        | {name: interval([m[name] for m in measures]) for name in names}
        | ({"dead": interval([float(dead)])} if dead else {})
    )


def _numbers(run: Row) -> dict[str, float]:
    """The numbers of one run that the tables and targets are about; of dead codes the error."""
    numbers = {"error": run["errors"].get("model")}
    if run["organisation"]:
        numbers |= _of_organisation(run["organisation"])
    return {name: value for name, value in numbers.items() if value is not None}


def _of_organisation(found: Row) -> dict[str, float | None]:
    numbers: dict[str, float | None] = {
        "collapse ratio": found["collapse"]["ratio"],
        "AUC": found["collapse"]["auc"],
    }
    numbers |= _of_report(found["topology"])
    numbers |= {f"composition, {name}": v for name, v in found["composition"].items()}
    numbers |= {f"collapse, {name}": v for name, v in found["collapse"]["by kind"].items()}
    turned = found["collapse"].get("by full turns", {})
    numbers |= {f"{name} full turns": v for name, v in turned.items()}
    numbers |= {f"T = {length}": v["translation"] for length, v in found["lengths"].items()}
    if found["lengths"]:
        fitted, longest = (found["lengths"][length]["translation"] for length in TOLD_LENGTHS)
        numbers["T = 24 / T = 6"] = longest / fitted
    if "standard form" in found:
        standard = _of_report(found["standard form"])
        numbers |= {f"{name}, standard": standard[name] for name in IN_STANDARD_FORM}
    return numbers


IN_STANDARD_FORM = (
    "rank correlation",
    "D_topo",
    "trustworthiness",
    "partial, motors",
    "semipartial, motors",
)
"""What is told of codes in standard form as well."""


def _of_report(report: Row) -> dict[str, float | None]:
    """What a report on codes, {measure: [value, error]}, tells for tables and targets."""
    measures = {name: value for name, (value, _) in report.items()}
    return {
        "linear R2": min(measures[f"linear r2, {c}"] for c in COMPONENTS),
        "nonlinear R2": min(measures[f"nonlinear r2, {c}"] for c in COMPONENTS),
        "orientation error": measures["orientation error"],
        "D_topo": measures["normalised topology error"],
        "rank correlation": measures["rank correlation"],
        "partial, displacement": measures["partial displacement"],
        "partial, motors": measures["partial motors"],
        "partial, affine": measures.get("partial motors affine"),
        "semipartial, motors": _semipartial(measures),
        "trustworthiness": measures["trustworthiness, 20"],
        "continuity": measures["continuity, 20"],
        "neighbours / floor": measures["neighbours to floor"],
        "winding": abs(measures["winding number"]),
        "loop": measures.get("loop persistence"),
        "dimension": measures.get("intrinsic dimension"),
        "components": measures["components 95"],
    }


def _semipartial(measures: dict[str, float]) -> float | None:
    """The semipartial correlation with motors, which older results do not tell."""
    if measures.get("partial motors") is None:
        return None
    return measures["partial motors"] * max(0.0, 1 - measures["rank correlation"] ** 2) ** 0.5


def interval(values: Sequence[float]) -> Row:
    """Mean over seeds and the bootstrapped 95% interval of the mean (percentiles)."""
    mean = fmean(values)
    if len(values) < 2 or np.ptp(values) == 0:
        return {"mean": mean, "low": mean, "high": mean}
    found = bootstrap(
        (values,), np.mean, confidence_level=LEVEL, method="percentile", rng=0
    ).confidence_interval
    return {"mean": mean, "low": float(found.low), "high": float(found.high)}


TARGETS: tuple[tuple[str, str, dict[str, float]], ...] = (
    ("probe R2 of the worst of four components", "linear R2", {"least": 0.99}),
    ("collapse ratio", "collapse ratio", {"most": 0.01}),
    ("AUC of equivalent pairs", "AUC", {"least": 0.99}),
    ("partial correlation with motors, magnitude", "|partial, motors|", {"most": 0.05}),
    ("normalised D_topo", "D_topo", {"most": 0.1}),
    ("trustworthiness, k = 20", "trustworthiness", {"least": 0.98}),
    ("continuity, k = 20", "continuity", {"least": 0.98}),
    ("displacement error at T = 24 over that at T = 6", "T = 24 / T = 6", {"most": 3.0}),
    ("prediction error over the paper's network's", "error / paper", {"most": 1.0}),
)
"""What `best` is to reach in every cell: claim, measure, bound."""

CLOSED_FROM = 0.8
"""The rotation, in units of pi, from which on orientation is to close into a circle."""


def topology_claims(rows: Sequence[Row]) -> list[Row]:
    """The targets of the preset `best`, cell by cell."""
    made = []
    for row in (r for r in rows if r["row"] == "best"):
        cell = {"agent": row["agent"], "rotation": row["rotation"]}
        plain = [r for r in rows if r["row"] == "paper" and cell.items() <= r.items()]
        values = dict(row)
        if "partial, motors" in row:
            values["|partial, motors|"] = _magnitude(row["partial, motors"])
        if plain:
            level = plain[0]["error"]["mean"]
            values["error / paper"] = {k: row["error"][k] / level for k in ("mean", "low", "high")}
        scope = {"epochs": row["epochs"], "seeds": row["seeds"]}
        title = f"{row['agent']}, r = {row['rotation']} pi, best"
        targets: list[tuple[str, str, dict[str, Any]]] = [*TARGETS]
        if row["rotation"] >= CLOSED_FROM:
            targets.append(("winding number, magnitude", "winding", {"least": 1.0}))
        if "dead" in row:
            targets.append(("runs whose codes have died", "dead", {"most": 0.0}))
        for claim, name, bound in targets:
            if name in values:
                made.append(claimed(f"{title}: {claim}", values[name], **bound) | scope)
    return made


def _magnitude(spread: Row) -> Row:
    ends = [abs(spread["low"]), abs(spread["high"])]
    crosses = spread["low"] < 0 < spread["high"]
    low = 0.0 if crosses else min(ends)
    return {"mean": abs(spread["mean"]), "low": low, "high": max(ends)}
