"""`motorspace evaluate`."""

import argparse
from collections.abc import Sequence
from pathlib import Path

from motorspace._errors import UserError
from motorspace._files import write_json
from motorspace.cli.located import add_data_flag, data_of
from motorspace.cli.parsing import CommandParser, count, note
from motorspace.cli.show import show
from motorspace.training import folder as run_folder


def configure(parser: CommandParser, words: Sequence[str]) -> None:
    """The flags of the command."""
    del words
    add = parser.add_argument
    add("run", type=Path, metavar="RUN", help="The run's folder.")
    add(
        "--num",
        type=count,
        default=100_000,
        metavar="N",
        help="Fresh trajectories to measure on (default: 100000).",
    )
    add_data_flag(parser)
    add("--json", action="store_true", default=False, help="Print the results as JSON.")


def run(options: argparse.Namespace) -> None:
    """Measure a run."""
    data = data_of(options.run, options.data, command="evaluate")
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
