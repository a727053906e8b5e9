"""MCAP files: records of an operation, a length and a content, in chunks or not."""

import zlib
from collections.abc import Iterator
from dataclasses import dataclass, field
from pathlib import Path

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

MAGIC = b"\x89MCAP0\r\n"

FOOTER, SCHEMA, CHANNEL, MESSAGE, CHUNK, STATISTICS = 2, 3, 4, 5, 6, 0x0B


@dataclass
class State:
    """What is known so far while a file is read."""

    path: Path
    contents: Contents
    faults: Faults
    schemas: dict[int, str] = field(default_factory=dict)
    channels: dict[int, tuple[str, str, str]] = field(default_factory=dict)
    """Topic, type and encoding by number."""
    closed: bool = False


def messages(path: Path, contents: Contents, faults: Faults) -> Iterator[Raw]:
    """Every message that is wanted, in the order of the file."""
    file, size = opened(path)
    state = State(path, contents, faults)
    with file:
        source = Source(file, size)
        try:
            source.skip(len(MAGIC))
            while source.left and not state.closed:
                start = source.at
                op, length = _head(source)
                if op == CHUNK:
                    yield from _chunk(
                        Source.of(source.up_to(length)), state, f"{path}, byte {start}"
                    )
                elif op in (SCHEMA, CHANNEL, MESSAGE, STATISTICS):
                    record = Source.of(source.take(length))
                    yield from _read(op, record, state, f"{path}, byte {start}")
                else:
                    source.skip(length)
                    state.closed = op == FOOTER
        except Cut as why:
            faults.add(cut_off(path, source.at, why))
            state.closed = True  # one sentence is enough
    if not state.closed:
        faults.add(cut_off(path, size, "its footer is missing"))
    report_count(path, contents, faults)


def _head(source: Source) -> tuple[int, int]:
    """The operation of the next record, and how long it is."""
    op, length = source.number(1), source.number(8)
    if op == 0:
        raise Cut("there are zeros where a record begins")
    return op, length


def _read(op: int, record: Source, state: State, place: str) -> Iterator[Raw]:
    if op == SCHEMA:
        number, name = record.number(2), _text(record)
        state.schemas[number] = _long_name(name)
    elif op == CHANNEL:
        number, schema = record.number(2), record.number(2)
        topic, encoding = _text(record), _text(record)
        state.channels[number] = topic, state.schemas.get(schema, "of no known type"), encoding
        state.contents.kinds.setdefault(topic, state.channels[number][1])
    elif op == MESSAGE:
        yield from _message(record, state, place)
    elif op == STATISTICS:
        record.skip(8 + 2 + 4 + 4 + 4 + 4 + 8 + 8)
        counts = Source.of(record.take(record.number(4)))
        while counts.left:
            number, count = counts.number(2), counts.number(8)
            if number in state.channels:
                state.contents.claimed[state.channels[number][0]] += count


def _chunk(record: Source, state: State, place: str) -> Iterator[Raw]:
    """The messages in a chunk; from where it is damaged on, its rest is left out."""
    try:
        record.skip(16)
        size, checksum = record.number(8), record.number(4)
        method = _text(record)
        length = record.number(8)
        whole = length <= record.left
        content = unpacked(record.up_to(length), method, size, whole=whole)
        if whole and checksum and zlib.crc32(content) != checksum:
            raise Cut("its checksum is wrong")
        chunk = Source.of(content)
        while chunk.left:
            op, length = _head(chunk)
            if op in (SCHEMA, CHANNEL, MESSAGE):
                yield from _read(op, Source.of(chunk.take(length)), state, place)
            else:
                chunk.skip(length)
        if not whole:
            raise Cut("the file ends before it does")
    except Cut as why:
        state.faults.add(broken_chunk(place, why))


def _message(record: Source, state: State, place: str) -> Iterator[Raw]:
    number = record.number(2)
    if number not in state.channels:
        raise Cut("a message belongs to no channel")
    topic, kind, encoding = state.channels[number]
    if not state.contents.count(topic, kind):
        return
    record.skip(4)
    time = record.number(8)
    record.skip(8)
    where = f"{place}, topic {topic}, message {state.contents.counts[topic]}"
    yield Raw(topic, kind, encoding, time, record.take(record.left), where)


def _text(record: Source) -> str:
    return record.take(record.number(4)).decode("utf-8", "replace")


def _long_name(name: str) -> str:
    """`pkg/msg/Name`, also of the ROS 1 spelling `pkg/Name`."""
    return name if name.count("/") != 1 else name.replace("/", "/msg/")
