"""The text of a file, whatever its compression, encoding and line ends."""

import io
import math
import zlib
from collections.abc import Iterator
from pathlib import Path

from motorspace._errors import UserError
from motorspace.recordings.readers.faults import Faults

GZIP = b"\x1f\x8b"
HEAD = 65_536
"""Bytes that a reader sees to recognise its format."""

LARGEST = 256 * 2**20
"""Bytes of the largest text that is read. Its numbers take about ten times as many."""

UTF_16 = (b"\xff\xfe", b"\xfe\xff")


def read_text(path: Path, faults: Faults | None = None) -> str:
    """The whole text, decompressed and decoded.

    UTF-8 and UTF-16 with or without a byte order mark where there is one, else Latin-1.

    Args:
        path: The file.
        faults: Takes a gzip file that is cut off, of which the first part is read.

    Raises `UserError` for a file that is missing, empty, damaged, too large or not text.
    """
    content = read_bytes(path, faults=faults)
    if not content.strip():
        raise UserError("the file is empty", where=path, remedy="check how it was written")
    if content.startswith(UTF_16):
        return content.decode("utf-16", errors="replace")
    if b"\0" in content:
        raise UserError("the file is not text", where=path, remedy="give a text log or a table")
    try:
        return content.decode("utf-8-sig")
    except UnicodeDecodeError:
        return content.decode("latin-1").removeprefix("\xef\xbb\xbf")


def read_bytes(path: Path, size: int = -1, faults: Faults | None = None) -> bytes:
    """The first `size` bytes of a file, all of them by default, decompressed if it is gzip.

    Raises `UserError` for a file that is missing, damaged or too large to be read whole.
    """
    found = bytearray()
    try:
        with path.open("rb") as file:
            packed = file.read(2) == GZIP
            file.seek(0)
            if size >= 0:
                head = file.read(size)
                if not packed:
                    return head
                return zlib.decompressobj(zlib.MAX_WBITS | 16).decompress(head, size)
            for part in _gunzipped(file) if packed else iter(lambda: file.read(HEAD), b""):
                found += part
                if len(found) > LARGEST:
                    raise _too_large(path)
    except EOFError:
        (Faults(skip=False) if faults is None else faults).add(_cut_off(path, found.count(10)))
    except FileNotFoundError:
        raise UserError("there is no such file", where=path, remedy="check the path") from None
    except IsADirectoryError:
        raise UserError("this is a folder", where=path, remedy="give the log's file") from None
    except (OSError, zlib.error) as error:
        reason = getattr(error, "strerror", None) or "the gzip data are damaged"
        raise UserError(
            f"the file cannot be read ({reason})", where=path, remedy="check it, or copy it again"
        ) from None
    return bytes(found)


def _gunzipped(file: io.BufferedReader) -> Iterator[bytes]:
    """The content of a gzip file, part by part. Raises `EOFError` where it is cut off."""
    stream = zlib.decompressobj(zlib.MAX_WBITS | 16)
    while packed := file.read(HEAD):
        while packed:
            if stream.eof:  # another file follows, as after `cat a.gz b.gz`
                stream = zlib.decompressobj(zlib.MAX_WBITS | 16)
            yield stream.decompress(packed, 16 * HEAD)
            packed = stream.unconsumed_tail or stream.unused_data.lstrip(b"\0")
    if not stream.eof:
        raise EOFError


def _cut_off(path: Path, lines: int) -> UserError:
    return UserError(
        "the gzip file is cut off", where=f"{path}, after line {lines}", remedy="copy it again"
    )


def _too_large(path: Path) -> UserError:
    return UserError(
        f"the text is larger than {LARGEST // 2**20} MiB",
        where=path,
        remedy="cut it into parts, or export it as Parquet",
    )


def numbers(words: list[str], place: str) -> list[float]:
    """The words as numbers, infinite ones and NaN too. Raises `UserError` for any other word."""
    try:
        return [float(word) for word in words]
    except ValueError:
        wrong = next(word for word in words if not is_number(word))
        raise UserError(
            f"{wrong!r} is not a number", where=place, remedy="correct the value"
        ) from None


def finite(words: list[str], place: str) -> list[float]:
    """The words as finite numbers. Raises `UserError` for any other word."""
    values = numbers(words, place)
    for word, value in zip(words, values, strict=True):
        if not math.isfinite(value):
            raise UserError(f"{word!r} is not finite", where=place, remedy="correct the value")
    return values


def is_number(word: str) -> bool:
    """Whether the word is a number; "nan" and "inf" are."""
    try:
        float(word)
    except ValueError:
        return False
    return True
