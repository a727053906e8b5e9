"""From the results of runs to the rows of tables, and to targets that hold or do not."""

from collections.abc import Callable, Mapping, Sequence
from statistics import fmean
from typing import Any

from motorspace.experiments import paper

Row = dict[str, Any]
Maker = Callable[[Sequence[Row]], list[Row]]


def gathered(results: Sequence[Row], budget: paper.Budget) -> dict[str, Row]:
    """What each of the paper's experiments has shown so far; see `gather`."""
    makers = {"table": table_rows, "lattice": lattice_rows, "points": point_rows}
    return gather(results, makers, budget)


def gather(
    results: Sequence[Row],
    makers: Mapping[str, Maker],
    budget: paper.Budget,
    *,
    experiment: paper.Experiment | None = None,
) -> dict[str, Row]:
    """{"command", "date", "rows"} for each folder of `makers` in which there are runs.

    The date is that of the newest run, the seeds are as many as the cell with most has. The
    command is that of the `experiment`, or of the one that a folder is named after.
    """
    files = {}
    for name, rows in makers.items():
        runs = [r for r in results if r["name"].startswith(f"{name}/")]
        if runs:
            seeds = 1 + max(r["seed"] for r in runs)
            command = f"motorspace reproduce {experiment or name} --budget {budget} --seeds {seeds}"
            date = max(r["date"] for r in runs)
            files[name] = {"command": command, "date": date, "rows": rows(results)}
    return files


def table_rows(results: Sequence[Row]) -> list[Row]:
    """One row per cell of the paper's table I."""
    rows = []
    for agent, errors in paper.PAPER_ERRORS.items():
        for rotation, published in zip(paper.ROTATIONS, errors, strict=True):
            of = _by_part(results, f"table/{agent}-{rotation}")
            if not of["model"]:
                continue
            row: Row = {"agent": agent, "rotation": rotation, "paper": published}
            for part, runs in of.items():
                row[part] = spread([r["errors"]["model"] for r in runs])
            row |= {
                "persistence": fmean(r["errors"]["persistence"] for r in of["model"]),
                "mean": fmean(r["errors"]["mean"] for r in of["model"]),
                "skill": spread([r["errors"]["skill"] for r in of["model"]]),
                "to_oracle": relative(row["model"], row["oracle"]),
                "probe_r2": _spreads([r["probe_r2"] for r in of["model"]]),
                "epochs": of["model"][0]["epochs"],
                "recipe": of["model"][0]["recipe"],
                "num_test": of["model"][0]["errors"]["num_trajectories"],
            }
            rows.append(row)
    return rows


def lattice_rows(results: Sequence[Row]) -> list[Row]:
    """One row per kind of lattice run."""
    rows = []
    for name in (f"lattice/{kind}" for kind in paper.LATTICE_KINDS):
        for part, runs in _by_part(results, name).items():
            if not runs:
                continue
            row: Row = {
                "name": name,
                "part": part,
                "epochs": runs[0]["epochs"],
                "recipe": runs[0]["recipe"],
            }
            for number in ("accuracy", "within_to_total", "within_to_total_pose", "code_variance"):
                row[number] = spread([r[number] for r in runs])
            row["wrong"] = spread([_wrong(r["cases"]) for r in runs])
            row["cases"] = {
                steps: {"valid": valid, "correct": spread([r["cases"][steps][0] for r in runs])}
                for steps, (_, valid) in runs[0]["cases"].items()
            }
            row["r2_from_components"] = {
                count: _spreads([r["r2_from_components"][count] for r in runs])
                for count in runs[0]["r2_from_components"]
            }
            rows.append(row)
    return rows


def point_rows(results: Sequence[Row]) -> list[Row]:
    """One row per value of an open point of the paper."""
    rows = []
    for name in paper.POINTS:
        runs = _by_part(results, f"points/{name}")["model"]
        if runs:
            errors = spread([r["errors"]["model"] for r in runs])
            level, persistence = (
                fmean(r["errors"][reference] for r in runs) for reference in ("mean", "persistence")
            )
            probes = _spreads([r["probe_r2"] for r in runs])
            rows.append(
                {"point": name, "model": errors, "mean": level, "persistence": persistence}
                | {"probe_r2": probes, "epochs": runs[0]["epochs"]}
            )
    return rows


def claims(files: Mapping[str, Row], reasons: Mapping[str, str]) -> list[Row]:
    """Every target for the results in `files`, and whether it holds.

    A file is {"command", "date", "rows"}; `reasons` says why a claim does not hold.
    """
    makers = {
        "table": _table_claims,
        "lattice": _lattice_claims,
        "points": lambda rows: [],
        "robots": _robot_claims,
    }
    return [
        claim
        for name, file in files.items()
        for claim in judged(makers[name](file["rows"]), file, reasons)
    ]


def judged(found: Sequence[Row], file: Row, reasons: Mapping[str, str]) -> list[Row]:
    """The claims found in a file with its command and date, and why those fail that do.

    A claim is "CELL: WHAT"; `reasons` names it whole, or CELL for all that fails there, or WHAT
    alone for all cells.
    """

    def told(claim: str) -> dict[str, str]:
        cell, _, what = claim.rpartition(": ")
        known = (reasons[name] for name in (claim, cell, what) if name in reasons)
        return {"reason": next(known, "not known")}

    return [
        claim
        | ({} if claim["holds"] else told(claim["claim"]))
        | {"command": file["command"], "date": file["date"]}
        for claim in found
    ]


def claimed(
    claim: str, measured: Row, *, least: float | None = None, most: float | None = None
) -> Row:
    """What is claimed of a spread: it holds when all of `low` to `high` meets the target."""
    holds = measured["low"] >= least if least is not None else measured["high"] <= (most or 0.0)
    return {
        "claim": claim,
        "measured": measured["mean"],
        "interval": [measured["low"], measured["high"]],
        "target": f"at least {least:g}" if least is not None else f"at most {most:g}",
        "holds": holds,
    }


def _table_claims(cells: list[Row]) -> list[Row]:
    made = []
    for cell in cells:
        name = f"{cell['agent']}, r = {cell['rotation']} pi"
        scope = {"epochs": cell["epochs"], "seeds": cell["model"]["seeds"]}
        if cell["to_oracle"]:
            claim = claimed(f"{name}: error over its oracle's", cell["to_oracle"], most=1.10)
            made.append(claim | scope)
        worst = cell["model"]["high"] / cell["mean"]
        made.append(
            claimed(
                f"{name}: every seed has left the plateau (largest error over the mean's)",
                {"mean": worst, "low": worst, "high": worst},
                most=0.85,
            )
            | scope
        )
    return made


def _lattice_claims(kinds: list[Row]) -> list[Row]:
    made = []
    for kind in kinds:
        if kind["part"] != "model":
            continue
        name = kind["name"]
        scope = {"epochs": kind["epochs"], "seeds": kind["accuracy"]["seeds"]}
        num_cases = sum(case["valid"] for case in kind["cases"].values())
        exact = claimed(
            f"{name}: wrong of {num_cases:,} cases, all there are", kind["wrong"], most=0
        )
        made.append(exact | scope)
        if name == "lattice/with-slowness":
            for component in ("longitudinal", "lateral"):
                made.append(
                    claimed(
                        f"{name}: R2 of {component} displacement from 3 components",
                        kind["r2_from_components"]["3"][component],
                        least=0.9,
                    )
                    | scope
                )
    return made


def _robot_claims(robots: list[Row]) -> list[Row]:
    made = []
    for robot in robots:
        level = min(robot["persistence"], robot["mean"])
        blind = robot["no motors"]["mean"]
        for reference, value, most in (
            ("the better of persistence and mean", level, 0.75),
            ("the no-motor model's", blind, 0.85),
        ):
            ratio = {k: robot["model"][k] / value for k in ("mean", "low", "high")}
            claim = claimed(f"{robot['recording']}: error over {reference}", ratio, most=most)
            made.append(claim | {"seeds": robot["seeds"]})
    return made


def spread(values: Sequence[float]) -> Row | None:
    """Mean, smallest and largest over seeds, and how many there are."""
    if not values:
        return None
    return {"mean": fmean(values), "low": min(values), "high": max(values), "seeds": len(values)}


def relative(measured: Row | None, reference: Row | None) -> Row | None:
    """A spread as multiples of another one's mean."""
    if not measured or not reference:
        return None
    return {k: measured[k] / reference["mean"] for k in ("mean", "low", "high")}


def _wrong(cases: Mapping[str, tuple[int, int]]) -> int:
    """How many of every possible case are predicted wrong: (correct, valid) for each length."""
    return sum(valid - correct for correct, valid in cases.values())


def _spreads(measures: Sequence[Mapping[str, float]]) -> dict[str, Row | None]:
    return {name: spread([m[name] for m in measures]) for name in measures[0]}


def _by_part(results: Sequence[Row], name: str) -> dict[str, list[Row]]:
    return {
        part: [r for r in results if (r["name"], r["part"]) == (name, part)]
        for part in ("model", "oracle", "untrained")
    }
