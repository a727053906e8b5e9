"""ROS 2 bags in SQLite databases."""

import sqlite3
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
    unpacked,
)
from motorspace.recordings.readers.faults import Faults

MAGIC = b"SQLite format 3\0"


def messages(path: Path, contents: Contents, faults: Faults) -> Iterator[Raw]:
    """Every message that is wanted, in the order in which they were recorded."""
    try:
        # Immutable: neither a lock nor a journal is written beside the bag.
        place = f"file:{quote(str(path.absolute()))}?mode=ro&immutable=1"
        connection = sqlite3.connect(place, uri=True)
        connection.text_factory = lambda text: text.decode("utf-8", "replace")
        with closing(connection):
            yield from _messages(connection, path, contents, faults)
    except sqlite3.Error as error:
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
    except sqlite3.Error as error:
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


def _no_bag(path: Path, error: sqlite3.Error) -> UserError:
    return UserError(
        f"the database cannot be read as a ROS 2 bag ({error})",
        where=path,
        remedy="check that it has the tables topics and messages, or copy it again",
    )
