"""`motorspace inspect`."""

import argparse
import itertools
from collections.abc import Sequence
from pathlib import Path

from motorspace.cli.parsing import CommandParser, existing
from motorspace.cli.show import show


def configure(parser: CommandParser, words: Sequence[str]) -> None:
    """The flags of the command: those of the reader that recognises the log."""
    add = parser.add_argument
    add("file", type=existing, metavar="LOG", help="A log (CARMEN, or a table as CSV or Parquet).")
    add("--reader", default=None, metavar="READER", help="The reader of the log.")
    add("--json", action="store_true", default=False, help="Print the description as JSON.")
    after = {flag: value for flag, value in itertools.pairwise(words) if flag.startswith("--")}
    known = (after.get("--import"), after.get("--reader"))
    found = [word for word in words if not word.startswith("-") and word not in known]
    if not found:
        return
    from motorspace.recordings.catalog import READERS, reader_for

    # The value of a flag that is not known yet may stand where the log may.
    log = next((word for word in found if Path(word).is_file()), found[0])
    kind = after.get("--reader") or reader_for(existing(log))
    parser.add_parameters(f"reader {kind}", READERS.parameters(kind))


def run(options: argparse.Namespace) -> None:
    """Describe a log."""
    from motorspace.recordings.readers.base import read_log
    from motorspace.recordings.recording import describe

    own = ("file", "reader", "json", "imports")
    settings = {name: value for name, value in vars(options).items() if name not in own}
    show(describe(read_log(options.file, options.reader, **settings)), as_json=options.json)
