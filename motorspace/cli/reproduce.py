"""`motorspace reproduce`."""

import argparse
from collections.abc import Sequence
from pathlib import Path

from motorspace.cli.executors import add_executor_flags, executor_of
from motorspace.cli.parsing import CommandParser, count, existing
from motorspace.studies.reproduce import ALL
from motorspace.studies.study import BUDGETS, studies, study_named

FIGURES = "figures"
"""Stands for the studies that the paper's figures are drawn from, and draws them."""
DRAWN = ("table1", "lattice")


def configure(parser: CommandParser, words: Sequence[str]) -> None:
    """The flags of the command."""
    del words
    questions = "\n".join(f"  {name:<14} {study.question}" for name, study in studies().items())
    parser.epilog = (
        f"studies:\n{questions}\n  {FIGURES:<14} The paper's figures, from {' and '.join(DRAWN)}.\n"
        f"  {ALL:<14} All of them."
    )
    parser.add_argument(
        "names", nargs="*", default=[ALL], metavar="STUDY", help="Studies to run (default: all)."
    )
    add = parser.add_argument
    add(
        "--budget",
        default="quick",
        choices=BUDGETS,
        help="Share of the paper's epochs: quick 5 %%, fifth 20 %%, half 50 %%, paper all of them "
        "(default: quick).",
    )
    add("--seeds", type=count, default=3, metavar="N", help="Seeds of every cell (default: 3).")
    add(
        "--out",
        type=Path,
        default=Path("runs/studies"),
        metavar="FOLDER",
        help="Folder of the results and of all runs (default: runs/studies). What is finished "
        "there is not repeated.",
    )
    add(
        "--logs",
        type=existing,
        default=None,
        metavar="FOLDER",
        help="Folder of the recorded robots' logs, for the studies of robots.",
    )
    add_executor_flags(parser)


def run(options: argparse.Namespace) -> None:
    """Train and measure what is missing."""
    from motorspace.cli.runtime import prepare_jax
    from motorspace.studies.reproduce import reproduce

    wanted = [name for name in options.names if name != FIGURES]
    if FIGURES in options.names:
        wanted += DRAWN
    for name in wanted:
        if name != ALL:
            study_named(name)
    prepare_jax()
    reproduce(
        wanted,
        options.out,
        budget=options.budget,
        seeds=options.seeds,
        executor=executor_of(options),
        logs=options.logs,
        report=lambda sentence: print(sentence, flush=True),
    )
    if FIGURES in options.names:
        from motorspace.studies.figures import write_figures

        write_figures(options.out, options.budget)
    print(f"results: {options.out}")
