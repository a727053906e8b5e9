"""`motorspace import`."""

import argparse
from collections.abc import Sequence
from pathlib import Path

from motorspace._errors import UserError
from motorspace._files import file_hash, write_atomically, write_json
from motorspace.cli.inspect import (
    add_file,
    add_reader_flags,
    described_map,
    map_kind,
    recording_of,
    settings_of,
)
from motorspace.cli.parsing import CommandParser
from motorspace.cli.show import show

REPORT = ".report.json"
LAYOUT = ".layout"


def configure(parser: CommandParser, words: Sequence[str]) -> None:
    """The flags of the command: those of the reader that recognises the log."""
    add_file(parser)
    parser.add_argument(
        "--out",
        type=Path,
        required=True,
        metavar="FILE",
        help="The table (.csv or .parquet) that is written of a log, or the layout (.layout) of a "
        "map, with a report beside it.",
    )
    add_reader_flags(parser, words)


def run(options: argparse.Namespace) -> None:
    """Write what was read of a log as a table, or of a map as a layout; and a report."""
    if options.out.exists():
        raise UserError("the file exists already", where=options.out, remedy="choose another name")
    kind = None if options.reader else map_kind(options.file)
    described = _write_layout(options, kind) if kind else _write_table(options)
    report = options.out.with_name(options.out.name + REPORT)
    source = {"file": str(options.file), "sha256": file_hash(options.file)}
    settings = {} if kind else settings_of(options)
    write_json(report, {"source": source, "options": settings, **described})
    show(described, as_json=False)
    how = f"--layout {options.out}" if kind else f"--data {options.out}"
    print(f"written: {options.out}; train on it with: motorspace train {how}")


def _write_table(options: argparse.Namespace) -> dict[str, object]:
    from motorspace.recordings.recording import describe
    from motorspace.recordings.written import check_ending, write_table

    check_ending(options.out)
    recording = recording_of(options)
    write_table(recording, options.out)
    return describe(recording)


def _write_layout(options: argparse.Namespace, kind: str) -> dict[str, object]:
    if options.out.suffix != LAYOUT:
        raise UserError(
            f"a map becomes a layout, which cannot end in {options.out.suffix!r}",
            where=options.out,
            remedy=f"write for instance --out {options.out.stem}{LAYOUT}",
        )
    layout, described = described_map(options.file, kind)
    write_atomically(options.out, layout.text().encode())
    return described
