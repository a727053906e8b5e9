"""Recorded robots: one file a format, all giving the same `Recording`."""

from pathlib import Path

from motorspace._errors import UserError
from motorspace.recordings.readers.carmen import read_carmen
from motorspace.recordings.readers.table import read_table
from motorspace.recordings.recording import Recording

READERS = {
    ".log": read_carmen,
    ".log.gz": read_carmen,
    ".clf": read_carmen,
    ".clf.gz": read_carmen,
    ".csv": read_table,
    ".parquet": read_table,
}


def read_log(path: Path) -> Recording:
    """The recording in a file of any known format, told by its ending."""
    for ending, read in READERS.items():
        if path.name.endswith(ending):
            return read(path)
    raise UserError(
        "this ending belongs to no known format",
        where=path,
        remedy=f"give a file that ends in {', '.join(READERS)}",
    )
