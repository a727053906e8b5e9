"""The command line: parse, call, print. The only `print` and the only `sys.exit`."""

import json
import os
import sys
import warnings
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from functools import partial
from pathlib import Path
from typing import Annotated, Any, Literal

import jax
import tyro

from motorspace._errors import UserError
from motorspace._files import write_as_told, write_json
from motorspace._types import Record, Watch
from motorspace.experiments import paper
from motorspace.experiments.measurement import measure
from motorspace.training.config import RunConfig, fresh_experience, simulation_scaling
from motorspace.training.runs import load_run, train

Flag = tyro.conf.FlagCreatePairsOff[bool]
AsJson = Annotated[Flag, tyro.conf.arg(name="json", help="Print the results as JSON.")]
Preset = tyro.extras.subcommand_type_from_defaults(paper.PRESETS, prefix_names=False)

app = tyro.extras.SubcommandApp()
tell = partial(print, flush=True)


@app.command(name="train")
def train_command(
    config: Preset = paper.FORWARD,  # type: ignore[valid-type]
    preset: Literal["paper", "best"] = "paper",
    out: Path | None = None,
    data: Path | None = None,
    resume: Flag = False,
    seeds: int = 1,
    jobs: int = 2,
) -> None:
    """Train a network, in simulation or on a recorded robot.

    Args:
        config: The paper's system to start from; every flag changes one of its parameters.
        preset: paper, or best: the network whose codes are organised best (docs/topology.md); it
            changes what is not given as a flag.
        out: Folder of the run; runs/AGENT-SEED when left out.
        data: A robot's log to learn from instead of a simulation (CARMEN, CSV or Parquet).
        resume: Continue the run in this folder from its last checkpoint.
        seeds: Networks to train, in folders seedN below the run's (simulation only).
        jobs: Networks trained at once when there are several.
    """
    run: RunConfig = config
    if preset == "best":
        from motorspace.experiments.topology import BEST

        run = paper.changed_where_default(run, BEST)
    name = run.simulation.agent if data is None else data.name.partition(".")[0]
    folder = out or Path("runs") / f"{name}-{run.training.seed}"
    if seeds < 1 or (seeds > 1 and data is not None):
        raise UserError(
            f"cannot train {seeds} seeds" + (" on a log" if data is not None else ""),
            remedy="ask for at least one, and for one at a time on a log",
        )
    if seeds > 1:
        from motorspace.experiments.reproduction import train_seeds

        train_seeds(
            run,
            folder,
            seeds=seeds,
            processes=jobs,
            resume=resume,
            report=tell,
        )
        return
    if data is None:
        source, scaling, validation = fresh_experience(run), simulation_scaling(run), None
    else:
        from motorspace.experiments.robots import data_for

        recorded = data_for(data, run.simulation)
        source, scaling = recorded.train.experience, recorded.scaling
        validation = recorded.validation.experience
    if run.training.starts > 1 and not resume:
        tell(f"trying {run.training.starts} starts for {run.training.trial_epochs} epochs each")
    with progress("training", run.training.epochs) as watch:
        trained = train(
            run, source, scaling, folder, validation=validation, resume=resume, watch=watch
        )
    if trained.collapsed:
        print("the codes have collapsed: they no longer vary with the commands", file=sys.stderr)
    again = "" if data is None else f" --data {data}"
    print(f"finished: {folder}; measure it with: motorspace evaluate {folder}{again}")


@app.command(name="evaluate")
def evaluate_command(
    run: tyro.conf.Positional[Path],
    num: int = 100_000,
    data: Path | None = None,
    as_json: AsJson = False,
) -> None:
    """Measure a run on fresh trajectories, beside its reference rows.

    Args:
        run: The run's folder.
        num: Fresh trajectories to measure on.
        data: The robot's log that the run has learned from: measures on its test blocks.
    """
    if num < 1:
        raise UserError(f"cannot measure on {num} trajectories", remedy="ask for at least one")
    trained = load_run(run)
    if data is None:
        measured = measure(trained, num=num)
    else:
        from motorspace.experiments.robots import data_for, measure_on

        measured = measure_on(trained, data_for(data, trained.config.simulation))
    write_json(run / "evaluation.json", measured)
    show(measured, as_json=as_json)


@app.command(name="inspect")
def inspect_command(file: tyro.conf.Positional[Path], as_json: AsJson = False) -> None:
    """Describe a recorded robot's log.

    Args:
        file: A CARMEN log (plain or gzip), a CSV or a Parquet table.
    """
    from motorspace.recordings.readers.base import read_log
    from motorspace.recordings.recording import describe

    show(describe(read_log(file)), as_json=as_json)


@app.command(name="reproduce")
def reproduce_command(
    what: tyro.conf.Positional[paper.Experiment] = "all",
    budget: paper.Budget = "quick",
    out: Path = Path("runs/paper"),
    seeds: int = 3,
    parts: tuple[paper.Part, ...] = ("model", "oracle", "untrained"),
    jobs: int = 2,
    logs: Path | None = None,
) -> None:
    """Repeat the paper's experiments; finished work is never repeated.

    Args:
        what: Which of the paper's experiments.
        budget: Share of the paper's epochs: quick 5%, fifth 20%, half 50%, paper all.
        out: Folder of all runs and results.
        seeds: Seeds of every cell.
        parts: The rows to train: the model, its oracle, its untrained encoder.
        jobs: Runs trained at once, each in a process of its own.
        logs: Folder of the recorded robots' logs, for robots.
    """
    from motorspace.experiments import reproduction

    if what == "robots":
        reproduction.reproduce_robots(out, logs, seeds=seeds, report=tell)
        return
    if what == "floor":
        reproduction.reproduce_floor(out, report=tell)
        return
    reproduction.reproduce(
        what,
        out,
        budget=budget,
        seeds=seeds,
        parts=parts,
        processes=jobs,
        report=tell,
    )
    if what == "all":
        reproduction.reproduce_floor(out, report=tell)
        if logs is not None:
            reproduction.reproduce_robots(out, logs, seeds=seeds, report=tell)


@app.command(name="topology")
def topology_command(
    codes: tyro.conf.Positional[Path],
    displacements: tyro.conf.Positional[Path | None] = None,
    motors: Path | None = None,
    out: Path = Path("topology.html"),
    standard_form: Flag = False,
    seed: int = 0,
    as_json: AsJson = False,
) -> None:
    """Measure how codes are organised by displacement, on anybody's codes or on a run.

    Args:
        codes: Codes, one row for each motor sequence (NumPy, Parquet, Zarr or CSV; FILE:NAME where
            a file holds several arrays), or a run's folder.
        displacements: Longitudinal and lateral displacement and orientation change of each code, in
            radians; left out for a run.
        motors: The motor commands behind each code: tells codes that copy them.
        out: The page to write.
        standard_form: Measure a run's codes with unit, body point and readout standardised
            (encoder group only; docs/topology.md).
        seed: Seed of the random subsets of pairs, and of a run's fresh sequences.
    """
    from motorspace._arrays import read_array
    from motorspace.analysis.topology import topology
    from motorspace.experiments.organisation import Sampled
    from motorspace.experiments.topology import topology_of, topology_page

    if displacements is None:
        found = topology_of(load_run(codes), seed=seed, standard=standard_form)
    elif standard_form:
        raise UserError(
            "codes from files are measured as they are",
            remedy="leave --standard-form out, or give the folder of a run alone",
        )
    else:
        h, d = read_array(codes, name="codes"), read_array(displacements, name="displacements")
        m = None if motors is None else read_array(motors, name="motors")
        report = topology(h, d, m, seed=seed)
        found = Sampled(h.reshape(len(h), -1), d, report)
    what = "codes in standard form" if standard_form else "codes"
    write_as_told(out, topology_page(found, what=what).encode(), what="file")
    if as_json:
        print(json.dumps(found.topology.to_dict()))
    else:
        print(f"{found.topology}\nopen {out}")


@app.command(name="demo")
def demo_command(out: Path = Path("demo"), seed: int = 0) -> None:
    """Train a forward agent in a few minutes and write a page about it.

    Args:
        out: Folder of the run and its report.
        seed: Seed of the run.
    """
    from motorspace.experiments import demo

    with progress("training", demo.EPOCHS) as watch:
        page = demo.demo(out, seed=seed, watch=watch)
    print(f"open {page}")


def show(results: dict[str, Any], *, as_json: bool) -> None:
    """Print results, for a program or for a person."""
    if as_json:
        print(json.dumps(results))
        return
    for name, value in _flat(results):
        print(f"{name:<32} {value:.6g}" if isinstance(value, float) else f"{name:<32} {value}")


def _flat(results: dict[str, Any], prefix: str = "") -> Iterator[tuple[str, Any]]:
    for name, value in results.items():
        if isinstance(value, dict):
            yield from _flat(value, f"{prefix}{name}.")
        else:
            yield f"{prefix}{name}", value


@contextmanager
def progress(what: str, epochs: int) -> Iterator[Watch]:
    """A bar with rate and time left on a terminal, a line now and then elsewhere."""
    from rich.console import Console
    from rich.progress import (
        BarColumn,
        MofNCompleteColumn,
        Progress,
        TextColumn,
        TimeElapsedColumn,
        TimeRemainingColumn,
    )

    console = Console(stderr=True)
    columns = (
        TextColumn("{task.description}"),
        BarColumn(),
        MofNCompleteColumn(),
        TimeElapsedColumn(),
        TimeRemainingColumn(),
        TextColumn("{task.fields[rate]:.1f} epochs/s, loss {task.fields[loss]:.4f}"),
    )
    with Progress(*columns, console=console, disable=not console.is_terminal) as bar:
        task = bar.add_task(what, total=epochs, rate=0.0, loss=float("nan"))

        def watch(record: Record) -> None:
            epoch, loss = int(record["epoch"]), record["prediction_loss"]
            bar.update(task, completed=epoch, rate=bar.tasks[0].speed or 0.0, loss=loss)
            if not console.is_terminal and epoch % max(1, epochs // 10) == 0:
                console.print(f"{what}: epoch {epoch} of {epochs}, loss {loss:.5f}")

        yield watch


MOST_CACHED = 2**30
"""Bytes of compiled programs to keep; those used least lately go first."""


def keep_compiled_programs() -> None:
    """Compile each program once per machine: later runs, and all processes of one, load it.

    A folder that JAX_COMPILATION_CACHE_DIR names is its owner's, and gets no bound of ours.
    """
    if "JAX_COMPILATION_CACHE_DIR" in os.environ:
        return
    caches = Path(os.environ.get("XDG_CACHE_HOME") or Path.home() / ".cache")
    folder = caches / "motorspace" / "compiled"
    settings = {
        "jax_compilation_cache_dir": str(folder),
        "jax_compilation_cache_max_size": MOST_CACHED,
    }
    for name, value in settings.items():
        jax.config.update(name, value)
        # Workers must keep to the bound: one entry written without it stops all later writing.
        os.environ[name.upper()] = str(value)


def refuse_missing_device() -> None:
    """Raise `UserError` with the devices there are when JAX_PLATFORMS asks for another."""
    asked = os.environ.get("JAX_PLATFORMS")
    if not asked:
        return
    try:
        jax.devices()
    except (RuntimeError, AssertionError):
        jax.config.update("jax_platforms", "")
        present = ", ".join(sorted({device.platform for device in jax.devices()}))
        raise UserError(
            f"there is no device {asked!r} here",
            where="JAX_PLATFORMS",
            remedy=f"choose from: {present}",
        ) from None


def show_warning(message: Warning | str, *_: object, **__: object) -> None:
    """Print a warning in one line, without the place in the code that it comes from."""
    print(f"motorspace: {message}", file=sys.stderr)


def main(argv: Sequence[str] | None = None) -> None:
    """Run the command line. Wrong input ends with one sentence and exit code 2."""
    # The products are small: a second thread gains a fifth on an idle machine, and loses an
    # order of magnitude when it waits for a core that another process holds.
    os.environ.setdefault("XLA_FLAGS", "--xla_cpu_multi_thread_eigen=false")
    keep_compiled_programs()
    try:
        refuse_missing_device()
        with warnings.catch_warnings():
            warnings.showwarning = show_warning
            app.cli(
                prog="motorspace",
                args=argv,
                config=(tyro.conf.OmitArgPrefixes, tyro.conf.CascadeSubcommandArgs),
            )
    except UserError as error:
        print(f"motorspace: {error}", file=sys.stderr)
        sys.exit(2)
    except KeyboardInterrupt:
        print("motorspace: stopped; --resume continues", file=sys.stderr)
        sys.exit(130)
    except BrokenPipeError:
        os.close(sys.stdout.fileno())
