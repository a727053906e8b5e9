"""The readers of logs there are, and which of them a file is for.

Nothing heavy is imported before a file is known to be there.
"""

from pathlib import Path
from typing import Any

from motorspace._errors import UserError
from motorspace._kinds import Builtin, Registry
from motorspace.recordings.readers.text import HEAD, read_bytes

_ROOM = "motorspace.recordings.readers"

READERS: Registry[Any] = Registry(
    "reader",
    {
        "carmen": Builtin(f"{_ROOM}.carmen", "CarmenReader", light=True),
        "wean": Builtin(f"{_ROOM}.wean", "WeanReader", light=True),
        "table": Builtin(f"{_ROOM}.table", "TableReader", light=True),
        "encoders": Builtin(f"{_ROOM}.encoders", "EncoderReader", light=True),
        "ros": Builtin(f"{_ROOM}.ros", "RosReader", light=True),
    },
)

FOREIGN = {
    b"#ROSBAG": "a ROS bag of version 1",
    b"\x28\xb5\x2f\xfd": "packed with zstd",
    b"\x89HDF": "an HDF5 file",
    b"PK\x03\x04": "a zip archive (.zip, .xlsx, .npz)",
    b"BZh": "packed with bzip2",
    b"\xfd7zXZ": "packed with xz",
    b"\x93NUMPY": "a NumPy array",
}
"""Formats that are known by their first bytes, and that no reader takes."""


def reader_for(path: Path | str) -> str:
    """The kind of the reader for a file: by its content, else by its ending.

    Args:
        path: The file, or the folder of a ROS 2 bag. Readers of one's own are asked first.

    Raises:
        UserError: The file is missing, damaged, empty or of no known format.
    """
    path = Path(path)
    file = path
    if path.is_dir():
        from motorspace.recordings.bags.files import first_file

        file = first_file(path) or path
    head = read_bytes(file, HEAD)
    if not head.strip():
        raise UserError("the file is empty", where=path, remedy="check how it was written")
    # Readers of one's own first: they may know a dialect of ours better.
    kinds = READERS.names[::-1]
    for kind in kinds:
        if READERS.class_of(kind).recognises(file.name, head):
            return kind
    name = path.name.lower().removesuffix(".gz")
    for kind in kinds:
        if name.endswith(READERS.class_of(kind).endings or "\0"):
            return kind
    raise _unknown(path, head)


def _unknown(path: Path, head: bytes) -> UserError:
    for magic, what in FOREIGN.items():
        if head.startswith(magic):
            return UserError(
                f"no reader takes it: it is {what}",
                where=path,
                remedy="unpack it, or export a table with the columns time, motor_*, sensor_*",
            )
    start = head.decode("latin-1").strip().splitlines()[0][:40]
    return UserError(
        f"no reader recognises it: it begins with {start!r}",
        where=path,
        remedy=f"name its reader ({', '.join(READERS.names)}), or export a table with the columns "
        "time, motor_*, sensor_*",
    )
