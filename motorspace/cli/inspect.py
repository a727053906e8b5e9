"""`motorspace inspect`."""

import argparse
import itertools
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

from motorspace._errors import UserError
from motorspace.cli.parsing import CommandParser, existing
from motorspace.cli.show import show

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from motorspace.recordings.recording import Recording
    from motorspace.worlds.layouts import Layout

DESCRIPTION = "inspection.json"


def configure(parser: CommandParser, words: Sequence[str]) -> None:
    """The flags of the command: those of the reader that recognises the log."""
    add_file(parser)
    parser.add_argument(
        "--json", action="store_true", default=False, help="Print the description as JSON."
    )
    parser.add_argument(
        "--out",
        type=Path,
        default=None,
        metavar="FOLDER",
        help="Also write a picture of the path, or of the map, and the description.",
    )
    add_reader_flags(parser, words)


def add_file(parser: CommandParser) -> None:
    """The log or the map, and the reader of a log."""
    add = parser.add_argument
    add(
        "file",
        type=existing,
        metavar="LOG",
        help="A log (CARMEN, ROS bag, MCAP, wheel encoders, or a table as CSV or Parquet), or a map"
        " (map_server, MovingAI, GeoJSON, SVG).",
    )
    add("--reader", default=None, metavar="READER", help="The reader of the log.")


def add_reader_flags(parser: CommandParser, words: Sequence[str]) -> None:
    """The flags of the reader that is named, or that recognises the log; none for a map."""
    after = {flag: value for flag, value in itertools.pairwise(words) if flag.startswith("--")}
    known = (after.get("--import"), after.get("--reader"), after.get("--out"))
    found = [word for word in words if not word.startswith("-") and word not in known]
    if not found:
        return
    from motorspace.recordings.catalog import READERS, reader_for

    # The value of a flag that is not known yet may stand where the log may.
    log = next((word for word in found if Path(word).exists()), found[0])
    if "--reader" not in after and map_kind(existing(log)):
        return
    kind = after.get("--reader") or reader_for(existing(log))
    parser.add_parameters(f"reader {kind}", READERS.parameters(kind))


def run(options: argparse.Namespace) -> None:
    """Describe a log or a map."""
    if options.reader is None and (kind := map_kind(options.file)):
        layout, described = described_map(options.file, kind)
        show(described, as_json=options.json)
        if options.out is not None:
            write_inspection(options.out, "map.png", described, _map_figure(layout))
        return
    from motorspace.recordings.recording import describe

    recording = recording_of(options)
    described = describe(recording)
    show(described, as_json=options.json)
    if options.out is not None:
        from motorspace.reports.figures.logs import path_figure

        write_inspection(options.out, "path.png", described, path_figure(recording))


def recording_of(options: argparse.Namespace) -> "Recording":
    """The log that a command names, read with the flags of its reader."""
    from motorspace.recordings.readers.base import read_log

    return read_log(options.file, options.reader, **settings_of(options))


def settings_of(options: argparse.Namespace) -> dict[str, Any]:
    """The options of the reader, in radians where its flags are in units of pi."""
    from motorspace._kinds import to_radians
    from motorspace.recordings.catalog import READERS, reader_for

    known = READERS.parameters(options.reader or reader_for(options.file))
    written = vars(options)
    return {p.name: to_radians(p, written[p.name]) for p in known if p.name in written}


def map_kind(path: Path) -> str | None:
    """The kind of a map or "layout"; None for a log."""
    from motorspace.worlds.maps.reading import kind_of_map

    if path.is_dir():
        return None
    return "layout" if path.suffix == ".layout" else kind_of_map(path)


def described_map(path: Path, kind: str) -> tuple["Layout", dict[str, Any]]:
    """The layout of a map, and what a person wants to know of it."""
    from motorspace.worlds.layouts import load_layout
    from motorspace.worlds.maps.reading import read_map

    layout, notes = (load_layout(path), []) if kind == "layout" else read_map(path, kind)
    segments, _ = layout.segments()
    x_low, y_low, x_high, y_high = layout.bounds
    described = {
        "name": path.name,
        "format": kind,
        "bounds": list(layout.bounds),
        "size": [x_high - x_low, y_high - y_low],
        "walls": len(layout.walls),
        "solids": len(layout.solids),
        "wall segments": len(segments),
        "notes": notes,
    }
    return layout, described


def write_inspection(folder: Path, name: str, described: dict[str, Any], figure: "Figure") -> None:
    """Write a description and its picture. Raises `UserError` where that is not possible."""
    from motorspace._files import write_atomically, write_json
    from motorspace.reports.figures.style import png

    try:
        folder.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise UserError(
            f"the folder cannot be made ({error.strerror})",
            where=folder,
            remedy="choose another folder",
        ) from None
    write_json(folder / DESCRIPTION, described)
    write_atomically(folder / name, png(figure, dots_per_inch=150))


def _map_figure(layout: "Layout") -> "Figure":
    from motorspace.reports.figures.worlds import layout_figure

    return layout_figure(layout)
