"""Fill the tables of the documentation from `results/`, or with --check see that they are filled.

A table stands between `<!-- table: NAME -->` and `<!-- end -->`.
"""

import json
import re
import sys
from collections.abc import Callable
from pathlib import Path
from typing import Any

import benchmarks.claims
from motorspace._files import write_atomically
from motorspace.experiments import topology_summary
from motorspace.experiments.paper import finished
from motorspace.experiments.summary import claims, gathered, judged
from motorspace.reports.tables import markdown_table

ROOT = Path(__file__).parent.parent
RESULTS = ROOT / "results" / "paper"
RUNS = ROOT / "results" / "runs"
TOPOLOGY = ROOT / "results" / "topology"
PERFORMANCE = ROOT / "results" / "performance"
PAGES = (
    ROOT / "README.md",
    *(ROOT / "docs" / f"{page}.md" for page in ("reproduction", "performance", "topology")),
)
Row = dict[str, Any]


def errors(rows: list[Row]) -> list[Row]:
    """Table I: the error beside the paper's and the reference rows."""
    return [
        {
            "agent": row["agent"],
            "r": f"{row['rotation']} pi",
            "epochs": row["epochs"],
            "weights, step": row["recipe"],
            "error": row["model"],
            "oracle": row["oracle"],
            "error / oracle": row["to_oracle"],
            "floor": row.get("floor"),
            "untrained": row["untrained"],
            "mean": row["mean"],
            "persistence": row["persistence"],
            "skill": row["skill"],
            "paper": row["paper"],
        }
        for row in rows
    ]


def short_errors(rows: list[Row]) -> list[Row]:
    """What the README shows of it."""
    columns = ("agent", "r", "error", "oracle", "floor", "mean", "persistence", "paper")
    return [{c: row[c] for c in columns} for row in errors(rows)]


def probes(rows: list[Row]) -> list[Row]:
    """R2 of a linear probe of the code, per component."""
    return [
        {"agent": row["agent"], "r": f"{row['rotation']} pi", **row["probe_r2"]} for row in rows
    ]


def lattice(rows: list[Row]) -> list[Row]:
    """Accuracy and organisation of the lattice runs."""
    return [
        {
            "run": row["name"].split("/")[1].replace("-", " ")
            + (", untrained encoder" if row["part"] == "untrained" else ""),
            "epochs": row["epochs"],
            "weights, step": row["recipe"],
            "wrong cases": row["wrong"],
            "within / total, pose": row["within_to_total_pose"],
            "within / total, translation": row["within_to_total"],
            **{
                f"R2 {component}, {count} PCs": row["r2_from_components"][count][component]
                for count in ("2", "3")
                for component in ("longitudinal", "lateral")
            },
            "code variance": row["code_variance"],
        }
        for row in rows
    ]


def lattice_cases(rows: list[Row]) -> list[Row]:
    """Exact predictions by length of the sequence."""
    trained = {r["name"].split("/")[1]: r["cases"] for r in rows if r["part"] == "model"}
    steps = next(iter(trained.values()))
    return [
        {
            "T": number,
            "cases": f"{case['valid']:,}",
            **{
                f"correct, {name.replace('-', ' ')}": f"{cases[number]['correct']['mean']:,.0f}"
                for name, cases in trained.items()
            },
        }
        for number, case in steps.items()
    ]


def points(rows: list[Row]) -> list[Row]:
    """The open points, one changed at a time."""
    return [
        {
            "changed": row["point"],
            "error": row["model"],
            "mean": row["mean"],
            "persistence": row["persistence"],
            **{f"R2 {name}": value["mean"] for name, value in row["probe_r2"].items()},
        }
        for row in rows
    ]


def robots(rows: list[Row]) -> list[Row]:
    """Errors on held-out blocks of the recorded robots."""
    columns = ("model", "oracle", "untrained", "no motors", "mean", "persistence")
    return [{"recording": r["recording"], **{c: r[c] for c in columns}} for r in rows]


def robot_probes(rows: list[Row]) -> list[Row]:
    """R2 of a linear probe of the robots' codes."""
    return [{"recording": r["recording"], **r["probe_r2 of model"]} for r in rows]


def organisation(rows: list[Row]) -> list[Row]:
    """Both presets in every cell, and the references: the measures that have a target."""
    return [_coded(row) | _measured(row) for row in _of_cells(rows)]


def organisation_lattice(rows: list[Row]) -> list[Row]:
    """The same measures of the lattice's codes."""
    return [{"codes": row["row"]} | _measured(row) for row in rows if row["agent"] == "lattice"]


def _of_cells(rows: list[Row]) -> list[Row]:
    return [row for row in rows if row["agent"] != "lattice"]


def _measured(row: Row) -> Row:
    columns = (
        "linear R2",
        "collapse ratio",
        "AUC",
        "rank correlation",
        "partial, motors",
        "partial, affine",
        "semipartial, motors",
        "D_topo",
        "trustworthiness",
        "continuity",
        "winding",
        "T = 24 / T = 6",
        "error",
    )
    return {"seeds": row["seeds"]} | {c: row.get(c) for c in columns}


def _coded(row: Row) -> Row:
    return {"agent": row["agent"], "r": f"{row['rotation']} pi", "codes": row["row"]}


def shape(rows: list[Row]) -> list[Row]:
    """How many dimensions the codes fill, how curved they are, how they compose."""
    columns = (
        "dimension",
        "components",
        "nonlinear R2",
        "loop",
        "neighbours / floor",
        "composition, linear",
        "composition, bilinear",
        "composition, network",
        "congruence left",
        "congruence right",
    )
    return [
        _coded(row) | {c: row.get(c, row.get(f"composition, {c}")) for c in columns}
        for row in _of_cells(rows)
    ]


def turns(rows: list[Row]) -> list[Row]:
    """The collapse ratio by what the members of a group differ in."""
    kinds = [f"collapse, {kind}" for kind in ("split", "permuted", "undone", "head")]
    counts = [f"{count} full turns" for count in range(topology_summary.MOST_TURNS + 1)]
    return [
        _coded(row) | {name.removeprefix("collapse, "): row.get(name) for name in (*kinds, *counts)}
        for row in _of_cells(rows)
    ]


def lengths(rows: list[Row]) -> list[Row]:
    """Root mean square error of the translation decoded at every length, world units."""
    return [
        _coded(row) | {name: row.get(name) for name in (f"T = {n}" for n in (1, 2, 3, 6, 12, 24))}
        for row in _of_cells(rows)
    ]


def ablation(rows: list[Row]) -> list[Row]:
    """What changes with one change to the paper's system."""
    columns = (
        "seeds",
        "error",
        "linear R2",
        "collapse ratio",
        "AUC",
        "partial, motors",
        "D_topo",
        "trustworthiness",
        "T = 1",
        "T = 6",
        "T = 24",
    )
    return [{"changed": row["change"]} | {c: row.get(c) for c in columns} for row in rows]


def standard(rows: list[Row]) -> list[Row]:
    """How the codes of `best` are organised as they are, and in standard form."""
    names = topology_summary.IN_STANDARD_FORM
    return [
        {"agent": row["agent"], "r": f"{row['rotation']} pi"}
        | {column: row[column] for name in names for column in (name, f"{name}, standard")}
        for row in rows
        if "rank correlation, standard" in row
    ]


def mixed(rows: list[Row]) -> list[Row]:
    """What `best` gains from trajectories of many lengths."""
    columns = ("seeds", "error", "linear R2", "T = 1", "T = 6", "T = 12", "T = 24")
    return [
        {"r": f"{row['rotation']} pi", "trained at": row["trained at"]}
        | {c: row.get(c) for c in (*columns, "T = 24 / T = 6")}
        for row in rows
    ]


def angle(rows: list[Row]) -> list[Row]:
    """Errors of predictors that are told displacements with wrong angles."""

    def percent(ratio: Row) -> Row:
        return {end: 100 * (value - 1) for end, value in ratio.items()}

    return [
        {"r": f"{row['rotation']} pi", "angle taken for": f"{row['angle']:g} times"}
        | {"seeds": row["seeds"], "error": row["error"], "more, %": percent(row["ratio"])}
        for row in rows
        if "ratio" in row
    ]


def rates(rows: list[Row]) -> list[Row]:
    """Ours beside every peer, the median and the range over launches."""

    def spread(values: Row) -> str:
        return "{median:.3g} ({low:.3g} to {high:.3g})".format(**values)

    return [
        {
            "work": row["work"],
            "threads": row["threads"],
            "vectors": row["processor"].split(", ")[-1],
            "unit": f"{row['unit']}/s",
            "motorspace": spread(row["ours"]),
            "peer": row["peer"],
            "its rate": spread(row["theirs"]),
            "ratio": spread(row["ratio"]),
        }
        for row in rows
    ]


def targets(rows: list[Row]) -> list[Row]:
    """Every claim with its target; those about speed have neither epochs nor seeds."""
    columns = ("claim", "epochs", "seeds", "measured", "interval", "target", "holds")
    present = [c for c in columns if any(c in row for row in rows)]
    return [
        {c: row.get(c) for c in present}
        | {"interval": "{:.3g} to {:.3g}".format(*row["interval"])}
        | {"reason": row.get("reason", "")}
        for row in rows
    ]


def targets_by_claim(rows: list[Row]) -> list[Row]:
    """In how many cells each target of `best` is reached."""
    claims_of: dict[str, list[Row]] = {}
    for row in rows:
        claims_of.setdefault(row["claim"].partition(", best: ")[2], []).append(row)
    return [
        {
            "target": f"{claim}: {cells[0]['target']}",
            "cells": len(cells),
            "reached in": sum(cell["holds"] for cell in cells),
        }
        for claim, cells in claims_of.items()
    ]


def floors(rows: list[Row]) -> list[Row]:
    """How the floor comes down with the number of remembered poses."""
    return [
        {"agent": row["agent"], "r": f"{row['rotation']} pi"}
        | {f"{int(num):,} poses": error for num, error in row["by_poses"].items()}
        | {"disagreement": row["disagreement"], "neighbours": row["neighbours"]}
        for row in rows
    ]


TABLES: dict[str, tuple[str, Callable[[list[Row]], list[Row]]]] = {
    "errors": ("table", errors),
    "short_errors": ("table", short_errors),
    "probes": ("table", probes),
    "lattice": ("lattice", lattice),
    "lattice_cases": ("lattice", lattice_cases),
    "points": ("points", points),
    "robots": ("robots", robots),
    "robot_probes": ("robots", robot_probes),
    "floor": ("floor", floors),
    "topology": ("topology", organisation),
    "topology_lattice": ("topology at the paper's budget", organisation_lattice),
    "topology_lattice_fifth": ("topology", organisation_lattice),
    "topology_whole": ("topology at the paper's budget", organisation),
    "topology_shape": ("topology", shape),
    "topology_standard": ("topology", standard),
    "topology_turns": ("topology", turns),
    "topology_lengths": ("topology", lengths),
    "ablation": ("ablation", ablation),
    "closing": ("closing", list),
    "mixed": ("mixed", mixed),
    "angle": ("angle", angle),
}


def reasons_in(folder: Path) -> dict[str, str]:
    """Why claims fail that do."""
    return dict(json.loads((folder / "reasons.json").read_text()))


def filled() -> dict[Path, str]:
    """What every file made from the results must hold."""
    whole = list(finished(RUNS / "paper"))
    files = gathered(whole, "paper")
    files |= gathered(list(finished(RUNS / "quick")), "quick")
    files["robots"] = json.loads((RESULTS / "robots.json").read_text())
    made = {RESULTS / "summary.json": claims(files, reasons_in(RESULTS))}
    files["floor"] = json.loads((RESULTS / "floor.json").read_text())
    floor = {(row["agent"], row["rotation"]): row["floor"] for row in files["floor"]["rows"]}
    for row in files["table"]["rows"]:
        row["floor"] = floor[row["agent"], row["rotation"]]
    files |= topology_summary.gathered(list(finished(RUNS / "fifth")), "fifth")
    files["topology at the paper's budget"] = topology_summary.gathered(whole, "paper")["topology"]
    found = topology_summary.topology_claims(files["topology"]["rows"])
    made[TOPOLOGY / "summary.json"] = judged(found, files["topology"], reasons_in(TOPOLOGY))
    tables = {
        name: markdown_table(make(files[source]["rows"]))
        for name, (source, make) in TABLES.items()
        if source in files
    }
    tables["targets"] = markdown_table(targets(made[RESULTS / "summary.json"]))
    organised = made[TOPOLOGY / "summary.json"]
    tables["topology_targets"] = markdown_table(targets_by_claim(organised))
    missed = [row for row in organised if not row["holds"]]
    tables["topology_missed"] = markdown_table(targets(missed))
    if (measured := PERFORMANCE / "benchmarks.json").exists():
        file = json.loads(measured.read_text())
        found = benchmarks.claims.claims(file["rows"])
        reached = judged(found, file, reasons_in(PERFORMANCE))
        made[PERFORMANCE / "summary.json"] = reached
        tables["benchmarks"] = markdown_table(rates(file["rows"]))
        tables["performance_targets"] = markdown_table(targets(reached))
    texts = {path: json.dumps(rows, indent=1) + "\n" for path, rows in made.items()}
    for page in PAGES:
        texts[page] = re.sub(
            r"(<!-- table: (\w+) -->\n).*?(<!-- end -->)",
            lambda found: found[1] + tables.get(found[2], "Not measured yet.\n") + found[3],
            page.read_text(),
            flags=re.DOTALL,
        )
    return texts


if __name__ == "__main__":
    stale = {
        path: text
        for path, text in filled().items()
        if not path.exists() or path.read_text() != text
    }
    if "--check" in sys.argv and stale:
        sys.exit("not made from the results: " + ", ".join(path.name for path in stale))
    for path, text in stale.items():
        write_atomically(path, text.encode())
