"""`motorspace demo`."""

import argparse
from collections.abc import Sequence
from pathlib import Path

from motorspace.cli.parsing import CommandParser, seed


def configure(parser: CommandParser, words: Sequence[str]) -> None:
    """The flags of the command."""
    del words
    parser.add_argument(
        "--out",
        type=Path,
        default=Path("demo"),
        metavar="FOLDER",
        help="Folder of the runs and the page (default: demo).",
    )
    parser.add_argument(
        "--seed", type=seed, default=0, metavar="N", help="Seed of the runs (default: 0)."
    )


def run(options: argparse.Namespace) -> None:
    """Train, measure, and write a page."""
    from motorspace.cli.runtime import prepare_jax

    prepare_jax()
    from motorspace.demo import demo

    page = demo(options.out, seed=options.seed, report=lambda line: print(line, flush=True))
    print(f"open {page}")
