"""`motorspace compare`."""

import argparse
from collections.abc import Sequence
from pathlib import Path

from motorspace._files import json_text
from motorspace.cli.parsing import CommandParser, Usage, count
from motorspace.training import folder as run_folder


def configure(parser: CommandParser, words: Sequence[str]) -> None:
    """The flags of the command."""
    del words
    add = parser.add_argument
    add("runs", type=Path, nargs="+", metavar="RUN", help="The folders of two or more runs.")
    add(
        "--num",
        type=count,
        default=100_000,
        metavar="N",
        help="Fresh trajectories for runs that are not evaluated yet (default: 100000).",
    )
    add("--json", action="store_true", default=False, help="Print the comparison as JSON.")


def run(options: argparse.Namespace) -> None:
    """Show what runs differ in."""
    if len(options.runs) < 2:
        raise Usage("one run cannot be compared", remedy="give the folders of two or more")
    for folder in options.runs:
        run_folder.read_description(folder)
    from motorspace.cli.runtime import prepare_jax

    prepare_jax()
    from motorspace.evaluation.structure import evaluate_with_structure
    from motorspace.export.compare import compare

    found = compare(options.runs, measure=lambda run: evaluate_with_structure(run, num=options.num))
    print(json_text(found.as_json()) if options.json else found)
