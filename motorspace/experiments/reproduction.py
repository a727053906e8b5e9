"""Run the paper's experiments, resumably, and gather what they show."""

import atexit
import multiprocessing
import os
import threading
from collections.abc import Callable, Sequence
from concurrent.futures import ProcessPoolExecutor, as_completed
from dataclasses import replace
from datetime import date
from multiprocessing.synchronize import Lock
from pathlib import Path

import jax

from motorspace._errors import UserError
from motorspace._files import locked, write_json
from motorspace.experiments import (
    figures,
    floor,
    paper,
    robots,
    summary,
    topology,
    topology_summary,
)
from motorspace.training.config import RunConfig, fresh_experience, simulation_scaling
from motorspace.training.runs import train, train_together

Report = Callable[[str], None]


def reproduce(
    what: paper.Experiment,
    out: Path,
    *,
    budget: paper.Budget,
    seeds: int,
    parts: tuple[paper.Part, ...],
    processes: int,
    report: Report,
) -> None:
    """Train and measure every run of an experiment in simulation, then write its results.

    Runs that are finished are read, an interrupted one continues from its checkpoint. Writes
    `table.json`, `lattice.json` and `points.json` in `out/BUDGET`, and the figures beside them.
    """
    if seeds < 1:
        raise UserError("there must be at least one seed")
    folder = out / budget
    wanted = []
    if what in ("lattice", "figures", "all"):
        wanted += paper.lattice_jobs(budget, seeds=seeds)
    if what in ("table", "figures", "all"):
        wanted += paper.table_jobs(budget, seeds=seeds, parts=parts)
    if what in ("points", "all"):
        wanted += paper.point_jobs(budget, seeds=seeds)
    if what in ("topology", "all"):
        wanted += topology.topology_jobs(budget, seeds=seeds)
        wanted += topology.ablation_jobs(budget, seeds=seeds)
        wanted += topology.closing_jobs(budget, seeds=seeds)
        wanted += topology.folding_jobs(budget, seeds=seeds)
        wanted += topology.mixed_jobs(budget, seeds=seeds)
        wanted += topology.angle_jobs(budget, seeds=seeds)
    with locked(folder):
        run_all(wanted, folder, budget=budget, processes=processes, report=report)
        found = list(paper.finished(folder))
        gathered = summary.gathered(found, budget) | topology_summary.gathered(found, budget)
        for name, shown in gathered.items():
            write_json(folder / f"{name}.json", shown)
    if what in ("figures", "all"):
        figures.write_all(folder)
    report(f"results: {folder}")


def reproduce_floor(out: Path, *, report: Report) -> None:
    """Estimate how low any predictor's error can get in each cell, and write `floor.json`."""
    with locked(out):
        rows = floor.floor_rows(report=report)
        today = date.today().isoformat()
        shown = {"command": "motorspace reproduce floor", "date": today, "rows": rows}
        write_json(out / "floor.json", shown)
    report(f"results: {out / 'floor.json'}")


def reproduce_robots(out: Path, logs: Path | None, *, seeds: int, report: Report) -> None:
    """Learn from both recorded robots and write `robots.json` and a figure of their codes."""
    if logs is None:
        raise UserError(
            "the robots' logs are not part of motorspace",
            remedy="give the folder that holds them with --logs",
        )
    rows = []
    with locked(out):
        for name, experiment in robots.EXPERIMENTS.items():
            log = logs / name
            rows.append(robots.robot_results(log, experiment, out, seeds=seeds, report=report))
            command = f"motorspace reproduce robots --logs FOLDER --seeds {seeds}"
            shown = {"command": command, "date": date.today().isoformat(), "rows": rows}
            write_json(out / "robots.json", shown)
        figures.write_robots(out, logs)
    report(f"results: {out / 'robots.json'}")


def run_all(
    jobs: list[paper.Job],
    folder: Path,
    *,
    budget: paper.Budget,
    processes: int,
    report: Report,
) -> None:
    """Train and measure jobs side by side."""
    num_test = paper.TEST_TRAJECTORIES[budget]
    with _pool(processes) as pool:
        running = {pool.submit(paper.run_job, job, folder, num_test=num_test): job for job in jobs}
        for done, future in enumerate(as_completed(running), start=1):
            errors = future.result()["errors"]
            told = f": error {errors['model']:.4g}" if errors else ""
            report(f"[{done}/{len(jobs)}] {running[future].folder}{told}")


def train_seeds(
    config: RunConfig, out: Path, *, seeds: int, processes: int, resume: bool, report: Report
) -> None:
    """Train one network per seed, counted from the configuration's own, in `out/seedN`.

    On a CPU each in a process, on other devices all in one program.
    """
    first = config.training.seed
    seeded = {
        out / f"seed{seed}": replace(config, training=replace(config.training, seed=seed))
        for seed in range(first, first + seeds)
    }

    def finished(folder: Path, loss: float) -> None:
        report(f"finished: {folder}, loss {loss:.4g}")

    if one_program(config):
        source, scaling = fresh_experience(config), simulation_scaling(config)
        runs = train_together([*seeded.values()], source, scaling, [*seeded], resume=resume)
        for folder, run in zip(seeded, runs, strict=True):
            finished(folder, run.log[-1]["prediction_loss"])
        return
    with _pool(processes) as pool:
        running = {
            pool.submit(_train_one, config, folder, resume=resume): folder
            for folder, config in seeded.items()
        }
        for future in as_completed(running):
            finished(running[future], future.result())


def one_program(config: RunConfig) -> bool:
    """Whether several seeds train fastest as one program, which shares its source of experience.

    Two cores train two seeds in two processes 1.3 times as fast as in one program.
    """
    return jax.default_backend() != "cpu" and config.training.fresh


def _train_one(config: RunConfig, folder: Path, *, resume: bool) -> float:
    source, scaling = fresh_experience(config), simulation_scaling(config)
    run = train(config, source, scaling, folder, resume=resume)
    return run.log[-1]["prediction_loss"]


def _pool(processes: int) -> ProcessPoolExecutor:
    """Processes of one thread each, which on a CPU beat one of many threads."""
    if processes < 1:
        raise UserError("there must be at least one process")
    os.environ["XLA_FLAGS"] = (
        f"{os.environ.get('XLA_FLAGS', '')} --xla_cpu_multi_thread_eigen=false"
    )
    context = multiprocessing.get_context("spawn")
    present = os.sched_getaffinity(0) if hasattr(os, "sched_getaffinity") else ()
    cores = [(core, context.Lock()) for core in sorted(present)]
    return ProcessPoolExecutor(
        processes,
        mp_context=context,
        initializer=_begin_worker,
        initargs=(cores,),
        max_tasks_per_child=1,
    )


def _begin_worker(cores: Sequence[tuple[int, Lock]]) -> None:
    _end_with_parent()
    _take_a_core(cores)


def _take_a_core(cores: Sequence[tuple[int, Lock]]) -> None:
    """Stay on a core that no other worker has taken, if there is one.

    One of the libraries behind the compiled products starts a thread for every core that it
    may use, whatever the flags say; those of several workers would wait for one another.
    """
    for core, untaken in cores:
        if untaken.acquire(block=False):
            os.sched_setaffinity(0, {core})
            atexit.register(untaken.release)
            return


def _end_with_parent() -> None:
    """Let a worker end when the command that started it is killed: its checkpoint stays."""
    parent = multiprocessing.parent_process()
    assert parent is not None

    def wait() -> None:
        parent.join()
        os._exit(1)

    threading.Thread(target=wait, daemon=True).start()
