"""`motorspace sweep`."""

import argparse
from collections.abc import Sequence
from pathlib import Path

from motorspace.cli.executors import add_executor_flags, executor_of
from motorspace.cli.parsing import CommandParser, Usage, count
from motorspace.running.sweep import Sweep

VIEWS = ("status", "table", "best")


def configure(parser: CommandParser, words: Sequence[str]) -> None:
    """The flags of the command."""
    view = next(iter(words), "")
    if view in VIEWS:
        parser.prog = f"motorspace sweep {view}"
        parser.add_argument("view", choices=VIEWS, metavar=view, help=f"What to show: {view}.")
    else:
        parser.epilog = (
            "`motorspace sweep status|table|best SPEC` shows how far it is, its results, and the "
            "best cell."
        )
    parser.add_argument(
        "spec",
        type=Path,
        nargs="?",
        default=None,
        metavar="SPEC",
        help="A TOML file that describes the sweep, or the folder of its runs.",
    )
    add = parser.add_argument
    add(
        "--out",
        type=Path,
        default=Path("runs/sweeps"),
        metavar="FOLDER",
        help="Folder of the results and of all runs (default: runs/sweeps).",
    )
    if view in ("table", "best"):
        add(
            "--metrics",
            nargs="+",
            default=(),
            metavar="KEY",
            help="Measures to show or to rank by.",
        )
    elif view != "status":
        _add_what_runs(parser)


def _add_what_runs(parser: CommandParser) -> None:
    group = parser.add_argument_group("the sweep, instead of a file")
    add = group.add_argument
    add("--name", default=None, metavar="NAME", help="Name of the sweep.")
    add("--agent", default=None, nargs="+", metavar="AGENT", help="Agents to train.")
    add(
        "--grid",
        default=(),
        nargs="+",
        metavar="FLAG=A,B",
        help="Flags of motorspace train, and values of which all combinations are trained.",
    )
    add(
        "--random",
        default=(),
        nargs="+",
        metavar="FLAG=KIND:A,B",
        help="Flags and distributions: uniform, log-uniform or choice.",
    )
    add("--fixed", default=(), nargs="+", metavar="FLAG=A", help="Flags that all runs share.")
    add("--samples", type=count, default=None, metavar="N", help="Random values of each.")
    add("--seeds", type=count, default=None, metavar="N", help="Seeds of every cell (default: 3).")
    add(
        "--measure",
        default=None,
        metavar="WHAT",
        help="prediction, or structure: also the report on the codes (default: prediction).",
    )
    add_executor_flags(parser)


def run(options: argparse.Namespace) -> None:
    """Run a sweep, or show what it has found."""
    from motorspace.running.trainer import trainer

    if hasattr(options, "view"):
        _show(options)
        return
    sweep = _sweep(options)
    from motorspace.running.sweep import jobs_of, run_sweep

    jobs_of(sweep, trainer())  # what is wrong in it is said before anything is started
    from motorspace.cli.runtime import prepare_jax
    from motorspace.running.sweep_results import rows, table
    from motorspace.running.trainer import train_and_measure

    prepare_jax()
    run_sweep(
        sweep,
        trainer(),
        options.out,
        train_and_measure,
        executor=executor_of(options),
        report=lambda sentence: print(sentence, flush=True),
    )
    print(table(rows(jobs_of(sweep, trainer()), options.out), sweep.metrics))


def _sweep(options: argparse.Namespace) -> Sweep:
    from motorspace.running.sweep_spec import read_sweep, sweep_of_flags

    own = ("name", "agent", "grid", "random", "fixed", "samples", "seeds", "measure")
    given = {name: getattr(options, name) for name in own if getattr(options, name)}
    if options.spec is not None:
        if given:
            raise Usage(
                f"{options.spec} says what the sweep is, and so does --{next(iter(given))}",
                remedy="give the file or the flags",
            )
        return read_sweep(options.spec)
    if not given:
        raise Usage("no sweep was given", remedy="give a file, or --grid FLAG=A,B")
    return sweep_of_flags(given.pop("name", "sweep"), **given)


def _show(options: argparse.Namespace) -> None:
    from motorspace.running.jobs import described
    from motorspace.running.sweep import jobs_of
    from motorspace.running.sweep_results import best, rows, status, table
    from motorspace.running.sweep_spec import read_sweep
    from motorspace.running.trainer import trainer

    if options.spec is None:
        raise Usage("no sweep was given", remedy="give its file, or the folder of its runs")
    sweep = read_sweep(options.spec)
    jobs = jobs_of(sweep, trainer())
    out = options.spec.resolve().parent if options.spec.is_dir() else options.out
    if options.view == "status":
        print(status(jobs, out))
        return
    found, metrics = rows(jobs, out), tuple(options.metrics or sweep.metrics)
    if options.view == "table":
        print(table(found, metrics))
        return
    metric = metrics[0] if metrics else "prediction.error"
    cell = best(found, metric, perfect=_perfect(metric))
    print(
        f"{described(cell.cell)}: {metric} {cell.mean(metric):.6g} ± {cell.half_width(metric):.2g}"
    )


def _perfect(metric: str) -> float:
    """The value of a measure that is best."""
    from motorspace.analysis.measures import measure

    known = measure(metric)
    if known.perfect is not None:
        return known.perfect
    return float("inf") if known.goal == "high" else 0.0
