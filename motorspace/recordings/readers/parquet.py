"""Tables in Parquet files, read with pyarrow (the extra `table`)."""

from pathlib import Path
from typing import Any

import numpy as np
from jaxtyping import Float

from motorspace._errors import UserError
from motorspace.recordings.readers.about import KEY, About, read_about
from motorspace.recordings.readers.columns import (
    Table,
    check_names,
    is_used,
    plain_name,
    seconds,
    value,
)

LARGEST = 4 * 2**30
"""Bytes of the largest table, unpacked."""

PER_SECOND = {"s": 1.0, "ms": 1e3, "us": 1e6, "ns": 1e9}


def read_parquet(path: Path) -> Table:
    """The table in a Parquet file; lists become a column for each of their values.

    Raises `UserError` for a file that is damaged, and for columns that hold no numbers.
    """
    table = _opened(path)
    check_names([plain_name(name) for name in table.column_names], where=path)
    columns: dict[str, Float[np.ndarray, " N"]] = {}
    ignored: list[str] = []
    notes: list[str] = []
    for original, column in zip(table.column_names, table.columns, strict=True):
        name = plain_name(original)
        if not is_used(name):
            ignored.append(original)
            continue
        columns |= _read(name, column, notes, where=path)
    places = [f"{path}, row {row}" for row in range(table.num_rows)]
    dated = any(note.startswith("time ") for note in notes)
    described = (table.schema.metadata or {}).get(KEY.encode())
    about = read_about(described.decode(), where=path) if described else About()
    return Table(columns, ignored, places, notes, dated, about)


def _opened(path: Path) -> Any:
    """The whole table, after a look at how large it claims to be."""
    try:
        import pyarrow
        from pyarrow import parquet
    except ImportError:
        raise UserError(
            "Parquet files need pyarrow", where=path, remedy="pip install 'motorspace[table]'"
        ) from None
    try:
        with parquet.ParquetFile(path) as file:
            groups = (file.metadata.row_group(i) for i in range(file.metadata.num_row_groups))
            if sum(group.total_byte_size for group in groups) <= LARGEST:
                return file.read()
    except (pyarrow.ArrowException, OSError, ValueError, MemoryError) as error:
        reason = (str(error).splitlines() or [type(error).__name__])[0]
        raise UserError(
            f"the Parquet file cannot be read ({reason})", where=path, remedy="write it again"
        ) from None
    raise UserError(
        f"the table is larger than {LARGEST // 2**30} GiB", where=path, remedy="cut it into parts"
    )


def _read(
    name: str, column: Any, notes: list[str], *, where: Path
) -> dict[str, Float[np.ndarray, " N"]]:
    """The numbers of one column, or of one for each value of its lists."""
    from pyarrow import types

    kind = column.type
    if types.is_list(kind) or types.is_large_list(kind) or types.is_fixed_size_list(kind):
        return _read_lists(name, column.to_pylist(), where=where)
    if types.is_timestamp(kind) or types.is_duration(kind) or types.is_time(kind):
        zone = getattr(kind, "tz", None)
        notes.append(f"{name} is in {kind.unit}" + f", zone {zone}" * bool(zone))
        whole = column.cast("int64" if kind.bit_width == 64 else "int32")
        return {name: _floats(whole) / PER_SECOND[kind.unit]}
    if types.is_floating(kind) or types.is_integer(kind) or types.is_boolean(kind):
        return {name: _floats(column)}
    words = [None if word is None else str(word) for word in column.to_pylist()]
    return {name: _from_words(name, words, where=where)}


def _floats(column: Any) -> Float[np.ndarray, " N"]:
    values: np.ndarray = column.cast("float64", safe=False).to_numpy()
    return values


def _read_lists(
    name: str, rows: list[list[Any] | None], *, where: Path
) -> dict[str, Float[np.ndarray, " N"]]:
    lengths = {len(row) for row in rows if row}
    if len(lengths) != 1:
        raise UserError(
            f"the lists in column {name} have lengths {sorted(lengths)[:4]}",
            where=where,
            remedy="give them all one length",
        )
    (length,) = lengths
    try:
        values = np.array([row or [np.nan] * length for row in rows], np.float64)
    except (TypeError, ValueError):
        raise _no_number(f"column {name}", where) from None
    return {f"{name}_{index}": values[:, index] for index in range(length)}


def _from_words(name: str, words: list[str | None], *, where: Path) -> Float[np.ndarray, " N"]:
    """Numbers, or for time dates, that are written as words."""
    found = [np.nan if word is None else value(word) for word in words]
    if name == "time":
        found = [
            seconds(str(word)) if number is None else number
            for word, number in zip(words, found, strict=True)
        ]
    if None in found:
        raise _no_number(
            f"column {name}, row {found.index(None)}: {words[found.index(None)]!r}", where
        )
    return np.array(found, np.float64)


def _no_number(what: str, where: Path) -> UserError:
    return UserError(
        f"{what} is not a number",
        where=where,
        remedy="write motors and sensors as numbers, or give the column another name",
    )
