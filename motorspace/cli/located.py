"""Where the data of a run are now, for the commands that measure it on them."""

import shlex
from dataclasses import replace
from pathlib import Path

from motorspace._errors import UserError
from motorspace.cli.parsing import CommandParser, existing
from motorspace.training import folder as run_folder
from motorspace.training.data import Data, Derived, Given, Logged, base_of


def add_data_flag(parser: CommandParser) -> None:
    """`--data LOG`, for a log that was moved."""
    parser.add_argument(
        "--data",
        type=existing,
        default=None,
        metavar="LOG",
        help="Where the log is now that the run has learned from, if it was moved.",
    )


def data_of(folder: Path, log: Path | None, *, command: str) -> Data:
    """What the finished run in a folder has learned from, its log at its present place.

    Raises `UserError` where there is no finished run, and for a log that is gone or has changed.
    """
    data = run_folder.read_description(folder).config.data
    base = base_of(data)
    if log is not None and not isinstance(base, Logged):
        learned = "data of one's own" if isinstance(base, Given) else "a simulation"
        raise UserError(
            f"the run has learned from {learned}, not from a log",
            where=folder,
            remedy="leave out --data",
        )
    if isinstance(base, Logged):
        moved = base.at(log) if log is not None else base
        moved.check_content(
            remedy=f"give it with: motorspace {command} {shlex.quote(str(folder))} --data LOG"
        )
        data = replace(data, base=moved) if isinstance(data, Derived) else moved
    if not run_folder.finished(folder):
        raise UserError(
            "this run is not finished", where=folder, remedy="continue it with --resume"
        )
    return data
