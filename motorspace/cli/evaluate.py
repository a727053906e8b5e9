"""`motorspace evaluate`."""

import argparse
import shlex
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path

from motorspace._errors import UserError
from motorspace._files import write_json
from motorspace.cli.parsing import CommandParser, Usage, existing, note
from motorspace.cli.show import show
from motorspace.training import folder as run_folder
from motorspace.training.data import Derived, Given, Logged, base_of


def configure(parser: CommandParser, words: Sequence[str]) -> None:
    """The flags of the command."""
    del words
    add = parser.add_argument
    add("run", type=Path, metavar="RUN", help="The run's folder.")
    add(
        "--num",
        type=int,
        default=100_000,
        metavar="N",
        help="Fresh trajectories to measure on (default: 100000).",
    )
    add(
        "--data",
        type=existing,
        default=None,
        metavar="LOG",
        help="Where the log is now that the run has learned from, if it was moved.",
    )
    add("--json", action="store_true", default=False, help="Print the results as JSON.")


def run(options: argparse.Namespace) -> None:
    """Measure a run."""
    if options.num < 1:
        raise Usage(f"--num must be at least 1, got {options.num}")
    described = run_folder.read_description(options.run)
    data = described.config.data
    base = base_of(data)
    if options.data is not None and not isinstance(base, Logged):
        learned = "data of one's own" if isinstance(base, Given) else "a simulation"
        raise UserError(
            f"the run has learned from {learned}, not from a log",
            where=options.run,
            remedy="leave out --data",
        )
    if isinstance(base, Logged):
        moved = base.at(options.data) if options.data is not None else base
        moved.check_content(
            remedy=f"give it with: motorspace evaluate {shlex.quote(str(options.run))} --data LOG"
        )
        data = replace(data, base=moved) if isinstance(data, Derived) else moved
    if not run_folder.finished(options.run):
        raise UserError(
            "this run is not finished", where=options.run, remedy="continue it with --resume"
        )
    from motorspace.cli.runtime import prepare_jax

    prepare_jax()
    from motorspace.evaluation.evaluate import evaluate
    from motorspace.training.run import load_run

    found = evaluate(load_run(options.run), num=options.num, data=data)
    show(dict(found), as_json=options.json)
    try:
        write_json(options.run / run_folder.EVALUATION, dict(found))
    except UserError as error:
        note(f"the results are not kept: {error}")
