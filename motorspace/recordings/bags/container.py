"""What all kinds of bags have in common: messages with a topic, one after the other.

The containers are read here record by record, not with a library, since libraries need the index
at a bag's end (which a robot that was switched off never wrote), trust the sizes that records
claim, and hand over fewer messages than there were without a word.
"""

import bz2
import io
import os
from collections import Counter
from collections.abc import Callable
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, NamedTuple

from motorspace._errors import UserError
from motorspace.recordings.readers.faults import Faults

LARGEST = 256 * 2**20
"""Bytes of the largest record, chunk or message that is read."""

INSTALL = "pip install 'motorspace[ros]'"

ZSTD = b"\x28\xb5\x2f\xfd"

COPY = "copy the bag again"


class Raw(NamedTuple):
    """One message as it is stored."""

    topic: str
    kind: str
    """Its type, as `sensor_msgs/msg/LaserScan`."""
    encoding: str
    """cdr or ros1."""
    time: int
    """When it was recorded, nanoseconds."""
    data: bytes
    place: str


@dataclass
class Contents:
    """What a bag turned out to hold, beside the messages themselves."""

    wanted: Callable[[str, str], bool]
    """Whether messages of a (topic, type) are read; all others are counted."""
    kinds: dict[str, str] = field(default_factory=dict)
    """The type of each topic."""
    counts: Counter[str] = field(default_factory=Counter)
    """Messages of each topic that are there."""
    claimed: Counter[str] = field(default_factory=Counter)
    """Messages of each topic by the bag's own account; empty where it has none."""

    def count(self, topic: str, kind: str) -> bool:
        """Count a message. Whether it is read."""
        self.kinds[topic] = kind
        self.counts[topic] += 1
        return self.wanted(topic, kind)


class Cut(Exception):
    """The file ends, or makes no sense, in the middle of a record."""


class Source:
    """A file or a chunk, read in pieces that are never longer than what is left of it."""

    def __init__(self, file: io.BufferedReader | io.BytesIO, size: int) -> None:
        self._file = file
        self.left = size
        self.at = 0

    @classmethod
    def of(cls, content: bytes) -> "Source":
        """The bytes of a chunk."""
        return cls(io.BytesIO(content), len(content))

    def take(self, size: int) -> bytes:
        """The next bytes. Raises `Cut` if there are not so many, or more than are ever read."""
        if size > self.left:
            raise Cut(f"a record of {size} bytes begins where {self.left} are left")
        if size > LARGEST:
            raise Cut(f"a record claims {size} bytes")
        found = self._file.read(size)
        self._passed(size)
        if len(found) < size:
            raise Cut("the file is shorter than it was")
        return found

    def up_to(self, size: int) -> bytes:
        """The next bytes, fewer where the file ends before them."""
        return self.take(min(size, self.left))

    def skip(self, size: int) -> None:
        """Leave bytes out. Raises `Cut` if there are not so many."""
        if size > self.left:
            raise Cut(f"a record of {size} bytes begins where {self.left} are left")
        self._file.seek(size, os.SEEK_CUR)
        self._passed(size)

    def number(self, size: int) -> int:
        """An unsigned little-endian number."""
        return int.from_bytes(self.take(size), "little")

    def _passed(self, size: int) -> None:
        self.left -= size
        self.at += size


def opened(path: Path) -> tuple[io.BufferedReader, int]:
    """The file and its size. Raises `UserError` if it cannot be opened."""
    try:
        file = path.open("rb")
        return file, os.fstat(file.fileno()).st_size
    except OSError as error:
        raise UserError(
            f"the bag cannot be opened ({error.strerror})", where=path, remedy="check the path"
        ) from None


def unpacked(content: bytes, method: str, size: int | None, *, whole: bool = True) -> bytes:
    """A chunk, decompressed. Raises `Cut` for damaged data and for ones larger than claimed.

    Args:
        content: The packed bytes.
        method: "", "none", "bz2", "lz4" or "zstd".
        size: How long they claim to be; None where they do not say.
        whole: Whether the packed bytes are all there.
    """
    if method in ("", "none"):
        return content
    limit = LARGEST if size is None else size
    if limit > LARGEST:
        raise Cut(f"a chunk claims {limit} bytes")
    decompressor = _decompressor(method)
    try:
        found: bytes = decompressor.decompress(content, limit + 1)
    except Exception as error:  # each library has errors of its own
        raise Cut(f"its {method} data are damaged ({error})") from None
    if len(found) > limit or (whole and size is not None and len(found) < size):
        raise Cut(f"its {method} data are not {limit} bytes long, as they claim")
    return found


def _decompressor(method: str) -> Any:
    if method == "bz2":
        return bz2.BZ2Decompressor()
    try:
        if method == "lz4":
            from lz4.frame import LZ4FrameDecompressor

            return LZ4FrameDecompressor()
        if method == "zstd":
            return _zstd().ZstdDecompressor()
    except ImportError:
        raise UserError(f"bags packed with {method} need a library", remedy=INSTALL) from None
    raise Cut(f"nothing is known that unpacks {method!r}")


def _zstd() -> Any:
    try:
        from compression import zstd  # type: ignore[import-not-found,unused-ignore]
    except ImportError:
        from backports import zstd
    return zstd


def cut_off(path: Path, at: int, why: object) -> UserError:
    """The error for a bag that ends or makes no sense at a byte."""
    return UserError(
        f"the bag is cut off or damaged ({why})", where=f"{path}, byte {at}", remedy=COPY
    )


def broken_chunk(place: str, why: object) -> UserError:
    """The error for a chunk that makes no sense."""
    return UserError(f"a chunk cannot be read ({why})", where=place, remedy=COPY)


def report_count(path: Path, contents: Contents, faults: Faults) -> None:
    """Compare what was found with the bag's own account; less than that is a fault."""
    for topic, claimed in sorted(contents.claimed.items()):
        found = contents.counts[topic]
        if found != claimed:
            faults.add(
                UserError(
                    f"topic {topic} holds {found} of the {claimed} messages that the bag counts",
                    where=path,
                    remedy=COPY,
                )
            )
