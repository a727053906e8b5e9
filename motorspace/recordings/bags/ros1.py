"""ROS 1 bags, version 2.0: records of a header and data, in chunks."""

from collections.abc import Iterator
from pathlib import Path
from typing import NamedTuple

from motorspace.recordings.bags.container import (
    Contents,
    Cut,
    Raw,
    Source,
    broken_chunk,
    cut_off,
    opened,
    report_count,
    unpacked,
)
from motorspace.recordings.readers.faults import Faults

MAGIC = b"#ROSBAG V2.0\n"

MESSAGE, HEADER, INDEX, CHUNK, CHUNK_INFO, CONNECTION = 2, 3, 4, 5, 6, 7


Connections = dict[int, tuple[str, str]]
"""Topic and type by number."""


class Record(NamedTuple):
    """The header of a record as fields; its data follow in the source."""

    fields: dict[bytes, bytes]
    size: int
    """Bytes of the data."""

    def number(self, name: bytes) -> int:
        """A field as a number. Raises `Cut` where there is none."""
        if name not in self.fields:
            raise Cut(f"a record lacks the field {name.decode('latin-1')!r}")
        return int.from_bytes(self.fields[name], "little")


def messages(path: Path, contents: Contents, faults: Faults) -> Iterator[Raw]:
    """Every message that is wanted, in the order of the bag."""
    file, size = opened(path)
    with file:
        source = Source(file, size)
        connections: Connections = {}
        indexed = False
        try:
            source.skip(len(MAGIC))
            while source.left:
                start = source.at
                record = _record(source)
                op = record.number(b"op")
                if op == HEADER:
                    indexed = record.number(b"index_pos") > 0
                if op == CHUNK_INFO:
                    _count(source.take(record.size), connections, contents)
                elif op == CHUNK:
                    data, place = source.up_to(record.size), f"{path}, byte {start}"
                    yield from _chunk(data, record, connections, contents, faults, place)
                elif op in (CONNECTION, MESSAGE):
                    yield from _read(source, record, connections, contents, f"{path}, byte {start}")
                else:
                    source.skip(record.size)
        except Cut as why:
            faults.add(cut_off(path, source.at, why))
            indexed = True  # one sentence is enough
        if not indexed:
            faults.add(cut_off(path, size, "it was not closed: its last messages are missing"))
        report_count(path, contents, faults)


def _record(source: Source) -> Record:
    header = Source.of(source.take(source.number(4)))
    fields = {}
    while header.left:
        name, equals, value = header.take(header.number(4)).partition(b"=")
        if not equals:
            raise Cut("the header of a record makes no sense")
        fields[name] = value
    return Record(fields, source.number(4))


def _chunk(
    data: bytes,
    record: Record,
    connections: Connections,
    contents: Contents,
    faults: Faults,
    place: str,
) -> Iterator[Raw]:
    """The messages in a chunk; from where it is damaged on, its rest is left out."""
    try:
        method = record.fields.get(b"compression", b"none").decode("latin-1")
        whole = len(data) == record.size
        chunk = Source.of(unpacked(data, method, record.number(b"size"), whole=whole))
        while chunk.left:
            yield from _read(chunk, _record(chunk), connections, contents, place)
        if not whole:
            raise Cut("the file ends before it does")
    except Cut as why:
        faults.add(broken_chunk(place, why))


def _read(
    source: Source, record: Record, connections: Connections, contents: Contents, place: str
) -> Iterator[Raw]:
    """The message in a record; connections are remembered, all else is passed over."""
    op = record.number(b"op")
    if op == CONNECTION:
        topic = record.fields.get(b"topic", b"").decode("utf-8", "replace")
        about = Source.of(source.take(record.size))
        kind = _type(about)
        connections[record.number(b"conn")] = topic, kind
        contents.kinds.setdefault(topic, kind)
    elif op == MESSAGE:
        yield from _message(source, record, connections, contents, place)
    else:
        source.skip(record.size)


def _message(
    source: Source, record: Record, connections: Connections, contents: Contents, place: str
) -> Iterator[Raw]:
    found = connections.get(record.number(b"conn"))
    if found is None:
        raise Cut("a message belongs to no connection")
    if not contents.count(*found):
        source.skip(record.size)
        return
    stamp = record.number(b"time")
    time = (stamp & 0xFFFFFFFF) * 10**9 + (stamp >> 32)
    number = contents.counts[found[0]]
    where = f"{place}, topic {found[0]}, message {number}"
    yield Raw(*found, "ros1", time, source.take(record.size), where)


def _type(about: Source) -> str:
    while about.left:
        name, _, value = about.take(about.number(4)).partition(b"=")
        if name == b"type":
            return "/msg/".join(value.decode("utf-8", "replace").split("/", 1))
    raise Cut("a connection has no type")


def _count(data: bytes, connections: Connections, contents: Contents) -> None:
    """Add what the account of one chunk says."""
    source = Source.of(data)
    while source.left:
        number, count = source.number(4), source.number(4)
        if number in connections:
            contents.claimed[connections[number][0]] += count
