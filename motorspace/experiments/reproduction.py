"""Run the paper's experiments, resumably, and gather what they show."""

import os
from collections.abc import Callable
from concurrent.futures import ProcessPoolExecutor, as_completed
from datetime import date
from multiprocessing import get_context
from pathlib import Path
from statistics import fmean
from typing import Any, Literal

from motorspace._errors import UserError
from motorspace._files import locked, write_json
from motorspace.experiments import figures, paper, robots

What = Literal["lattice", "table", "figures", "robots", "all"]
Row = dict[str, Any]


def reproduce(
    what: What,
    out: Path,
    *,
    budget: paper.Budget,
    seeds: int,
    parts: tuple[paper.Part, ...],
    processes: int,
    logs: Path | None = None,
    report: Callable[[str], None],
) -> None:
    """Train and measure every run of an experiment below `out`, then write its results.

    Runs that are finished are read, an interrupted one continues from its checkpoint. Writes
    `out/BUDGET/results.json` and the figures beside it; `robots` learns from the CARMEN logs
    in the folder `logs` and writes `out/robots.json`.
    """
    if what == "robots":
        reproduce_robots(out, logs, seeds=seeds, report=report)
        return
    if seeds < 1 or processes < 1:
        raise UserError("there must be at least one seed and one process")
    folder = out / budget
    wanted = []
    if what in ("lattice", "figures", "all"):
        wanted += paper.lattice_jobs(budget, seeds=seeds)
    if what in ("table", "figures", "all"):
        wanted += paper.table_jobs(budget, seeds=seeds, parts=parts)
    with locked(folder):
        run_all(wanted, folder, budget=budget, processes=processes, report=report)
        cells, kinds = table(folder), lattice(folder)
        write_json(folder / "results.json", {"budget": budget, "table": cells, "lattice": kinds})
        write_json(folder / "summary.json", claims(cells, kinds, budget))
    if what in ("figures", "all"):
        figures.write_all(folder)
    report(f"results: {folder / 'results.json'}")


def reproduce_robots(
    out: Path, logs: Path | None, *, seeds: int, report: Callable[[str], None]
) -> None:
    """Learn from both recorded robots and write what they show."""
    if logs is None:
        raise UserError(
            "the robots' logs are not part of motorspace",
            remedy="give the folder that holds them with --logs",
        )
    results = [
        robots.robot_results(logs / name, experiment, seeds=seeds, report=report)
        for name, experiment in robots.EXPERIMENTS.items()
    ]
    with locked(out):
        write_json(out / "robots.json", results)
    report(f"results: {out / 'robots.json'}")


def run_all(
    jobs: list[paper.Job],
    folder: Path,
    *,
    budget: paper.Budget,
    processes: int,
    report: Callable[[str], None],
) -> None:
    """Run jobs in processes of one thread each, which on a CPU beats one of many threads."""
    num_test = paper.TEST_TRAJECTORIES[budget]
    os.environ["XLA_FLAGS"] = (
        f"{os.environ.get('XLA_FLAGS', '')} --xla_cpu_multi_thread_eigen=false"
    )
    with ProcessPoolExecutor(
        processes, mp_context=get_context("spawn"), max_tasks_per_child=1
    ) as pool:
        running = {pool.submit(paper.run_job, job, folder, num_test=num_test): job for job in jobs}
        for done, future in enumerate(as_completed(running), start=1):
            error = future.result()["errors"]["model"]
            report(f"[{done}/{len(jobs)}] {running[future].folder}: error {error:.4g}")


def table(folder: Path) -> list[Row]:
    """One row per cell of the paper's table I, from every finished run of it."""
    results = [r for r in paper.finished(folder) if r["name"].startswith("table/")]
    rows = []
    for agent, errors in paper.PAPER_ERRORS.items():
        for rotation, published in zip(paper.ROTATIONS, errors, strict=True):
            here = [r for r in results if r["name"] == f"table/{agent}-{rotation}"]
            of = {p: [r for r in here if r["part"] == p] for p in ("model", "oracle", "untrained")}
            if not of["model"]:
                continue
            row: Row = {"agent": agent, "rotation": rotation, "paper": published}
            for part, runs in of.items():
                row[part] = spread([r["errors"]["model"] for r in runs])
            row["persistence"] = fmean(r["errors"]["persistence"] for r in of["model"])
            row["mean"] = fmean(r["errors"]["mean"] for r in of["model"])
            row["skill"] = spread([r["errors"]["skill"] for r in of["model"]])
            row["probe_r2"] = {
                name: spread([r["probe_r2"][name] for r in of["model"]])
                for name in of["model"][0]["probe_r2"]
            }
            row["to_oracle"] = _ratio(row["model"], row["oracle"])
            rows.append(row)
    return rows


def claims(cells: list[Row], kinds: list[Row], budget: paper.Budget) -> list[Row]:
    """The targets for these results, and whether each holds at this budget."""
    rows = [
        _claim(
            f"{cell['agent']}, r = {cell['rotation']} pi: error over its oracle's",
            {k: cell["model"][k] / cell["oracle"]["mean"] for k in ("mean", "low", "high")},
            at_most=1.10,
        )
        for cell in cells
        if cell["oracle"]
    ]
    for kind in kinds:
        if kind["part"] == "model":
            rows.append(_claim(f"{kind['name']}: accuracy", kind["accuracy"], at_least=1.0))
        if kind["name"] == "lattice/with-inverse":
            for component in ("longitudinal", "lateral"):
                name = f"{kind['name']}: R2 of {component} displacement from 3 components"
                rows.append(_claim(name, kind["r2_from_3"][component], at_least=0.9))
    origin = {
        "command": f"motorspace reproduce all --budget {budget}",
        "date": date.today().isoformat(),
    }
    return [row | origin for row in rows]


def _claim(
    claim: str, measured: Row, *, at_least: float | None = None, at_most: float | None = None
) -> Row:
    high_enough = at_least is None or measured["low"] >= at_least
    low_enough = at_most is None or measured["high"] <= at_most
    return {
        "claim": claim,
        "measured": measured["mean"],
        "interval": [measured["low"], measured["high"]],
        "target": f"at least {at_least}" if at_least is not None else f"at most {at_most}",
        "holds": high_enough and low_enough,
    }


def lattice(folder: Path) -> list[Row]:
    """One row per kind of lattice run."""
    rows = []
    results = [r for r in paper.finished(folder) if r["name"].startswith("lattice/")]
    for kind in sorted({(r["name"], r["part"]) for r in results}):
        runs = [r for r in results if (r["name"], r["part"]) == kind]
        row: Row = {"name": kind[0], "part": kind[1]}
        for number in ("accuracy", "within_to_total", "within_to_total_pose", "code_variance"):
            row[number] = spread([r[number] for r in runs])
        for count, components in runs[0]["r2_from_components"].items():
            row[f"r2_from_{count}"] = {
                name: spread([r["r2_from_components"][count][name] for r in runs])
                for name in components
            }
        rows.append(row)
    return rows


def spread(values: list[float]) -> Row | None:
    """Mean, smallest and largest over seeds, and how many there are."""
    if not values:
        return None
    return {
        "mean": fmean(values),
        "low": min(values),
        "high": max(values),
        "seeds": len(values),
    }


def _ratio(above: Row | None, below: Row | None) -> float | None:
    return above["mean"] / below["mean"] if above and below else None
