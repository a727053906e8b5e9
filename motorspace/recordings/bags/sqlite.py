"""ROS 2 bags in SQLite databases."""

import shutil
import sqlite3
import tempfile
from collections.abc import Iterator
from contextlib import closing
from pathlib import Path
from urllib.parse import quote

from motorspace._errors import UserError
from motorspace.recordings.bags.container import (
    COPY,
    LARGEST,
    ZSTD,
    Contents,
    Cut,
    Raw,
    cut_off,
    opened,
    unpacked,
)
from motorspace.recordings.readers.faults import Faults

MAGIC = b"SQLite format 3\0"


BROKEN = (sqlite3.Error, UnicodeDecodeError, OverflowError, MemoryError)
"""What a broken database raises: the module also fails at the words of its own errors."""

PAGE_SIZE, NUM_PAGES = slice(16, 18), slice(28, 32)
"""Where the head of a database says how large it is, in numbers with the highest byte first."""


def messages(path: Path, contents: Contents, faults: Faults) -> Iterator[Raw]:
    """Every message that is wanted, in the order in which they were recorded."""
    size, claimed = _sizes(path)
    if size >= claimed:
        yield from _read(path, path, contents, faults)
        return
    faults.add(cut_off(path, size, f"its head says that it has {claimed} bytes"))
    with tempfile.TemporaryDirectory() as folder:
        yield from _read(_shortened(path, Path(folder)), path, contents, faults)


def _sizes(path: Path) -> tuple[int, int]:
    """The bytes of a database, and those that its head says it has."""
    file, size = opened(path)
    with file:
        head = file.read(NUM_PAGES.stop)
    page = int.from_bytes(head[PAGE_SIZE], "big")
    return size, (65536 if page == 1 else page) * int.from_bytes(head[NUM_PAGES], "big")


def _shortened(path: Path, folder: Path) -> Path:
    """A copy whose head says how many pages there are: SQLite opens no other."""
    size, _ = _sizes(path)
    copy = folder / "bag.db3"
    try:
        shutil.copyfile(path, copy)
        with copy.open("r+b") as file:
            page = int.from_bytes(file.read(PAGE_SIZE.stop)[PAGE_SIZE], "big")
            pages = size // max(65536 if page == 1 else page, 512)
            file.seek(NUM_PAGES.start)
            file.write(pages.to_bytes(4, "big"))
    except OSError as error:
        raise UserError(
            f"the bag is cut off and cannot be copied ({error.strerror})", where=path, remedy=COPY
        ) from None
    return copy


def _read(file: Path, path: Path, contents: Contents, faults: Faults) -> Iterator[Raw]:
    """The messages in a database that is, or is a copy of, the bag at `path`."""
    try:
        # Immutable: neither a lock nor a journal is written beside the bag.
        place = f"file:{quote(str(file.absolute()))}?mode=ro&immutable=1"
        connection = sqlite3.connect(place, uri=True)
        connection.text_factory = lambda text: text.decode("utf-8", "replace")
        with closing(connection):
            yield from _messages(connection, path, contents, faults)
    except BROKEN as error:
        raise _no_bag(path, error) from None


def _messages(
    connection: sqlite3.Connection, path: Path, contents: Contents, faults: Faults
) -> Iterator[Raw]:
    topics = {
        number: (str(name), str(kind), str(encoding))
        for number, name, kind, encoding in connection.execute(
            "SELECT id, name, type, serialization_format FROM topics"
        )
    }
    contents.kinds.update({name: kind for name, kind, _ in topics.values()})
    wanted = [number for number, (name, kind, _) in topics.items() if contents.wanted(name, kind)]
    last = 0
    try:
        for last, number, time, size, data in _rows(connection, wanted):
            where = f"{path}, message {last}"
            if number not in topics:
                faults.add(UserError("a message has no topic", where=where, remedy=COPY))
                continue
            name, kind, encoding = topics[number]
            if not contents.count(name, kind):
                continue
            if not isinstance(data, bytes) or not isinstance(time, int):
                what = f"a message of {size} bytes cannot be read"
                faults.add(UserError(what, where=f"{where}, topic {name}", remedy=COPY))
                continue
            yield from _message(Raw(name, kind, encoding, time, data, where), faults)
    except BROKEN as error:
        faults.add(cut_off(path, 0, f"after message {last}: {error}"))


def _rows(connection: sqlite3.Connection, wanted: list[int]) -> sqlite3.Cursor:
    """All messages in the order of their numbers; the data of those alone that are wanted."""
    marks = ",".join("?" * len(wanted))
    return connection.execute(
        "SELECT id, topic_id, timestamp, length(data), CASE WHEN typeof(data) = 'blob' "
        f"AND length(data) <= {LARGEST} AND topic_id IN ({marks}) THEN data END "
        "FROM messages NOT INDEXED ORDER BY id",
        wanted,
    )


def _message(raw: Raw, faults: Faults) -> Iterator[Raw]:
    """The message, unpacked where the bag packs each one."""
    if not raw.data.startswith(ZSTD):
        yield raw
        return
    try:
        yield raw._replace(data=unpacked(raw.data, "zstd", None))
    except Cut as why:
        faults.add(UserError(f"a message cannot be unpacked ({why})", where=raw.place, remedy=COPY))


def _no_bag(path: Path, error: Exception) -> UserError:
    return UserError(
        f"the database cannot be read as a ROS 2 bag ({error})",
        where=path,
        remedy="check that it has the tables topics and messages, or copy it again",
    )
