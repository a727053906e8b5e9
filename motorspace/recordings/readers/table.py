"""Plain tables: one row per time step, as CSV or Parquet.

Columns: `time` in seconds; `motor_*`, what was executed between this row and the next;
`sensor_*`, what is sensed now; optionally the true pose `x`, `y`, `theta`, for evaluation.
"""

import csv
import math
from pathlib import Path

import numpy as np

from motorspace._errors import UserError
from motorspace.recordings.recording import Recording

POSE = ("x", "y", "theta")


def read_table(path: Path) -> Recording:
    """The recording in a CSV or Parquet table.

    Each sensor's scale is its largest magnitude. Raises `UserError` naming the file, and for
    CSV the line, that is broken.
    """
    names, values = _parquet(path) if path.suffix == ".parquet" else _csv(path)
    motors = [n for n in names if n.startswith("motor_")]
    sensors = [n for n in names if n.startswith("sensor_")]
    if "time" not in names or not motors or not sensors:
        raise UserError(
            f"the columns are {', '.join(names)}",
            where=path,
            remedy="a table needs time, at least one motor_* and at least one sensor_* column",
        )
    if repeated := sorted({n for n in names if names.count(n) > 1}):
        raise UserError(
            f"more than one column is named {', '.join(repeated)}",
            where=path,
            remedy="give every column its own name",
        )
    if len(values) < 2:
        raise UserError(
            f"the table holds {len(values)} rows", where=path, remedy="at least two are needed"
        )
    column = {name: values[:, index] for index, name in enumerate(names)}
    sensed = np.stack([column[n] for n in sensors], axis=-1)
    unknown = np.full(len(values), math.nan)
    scale = np.abs(sensed).max(axis=0)
    return Recording(
        name=path.name,
        time=column["time"],
        sensors=sensed,
        increments=np.stack([column[n][:-1] for n in motors], axis=-1),
        interval=np.arange(len(values) - 1),
        poses=np.stack([column.get(n, unknown) for n in POSE], axis=-1),
        sensor_scale=tuple(float(s) if s > 0 else 1.0 for s in scale),
        planar=False,
    )


def _csv(path: Path) -> tuple[list[str], np.ndarray]:
    try:
        with path.open(newline="", encoding="utf-8-sig") as handle:
            lines = list(csv.reader(handle))
    except (OSError, UnicodeDecodeError, csv.Error) as error:
        raise _unreadable(path, error) from None
    if not lines:
        raise UserError("the table is empty", where=path, remedy="begin with a row of names")
    names, rows = [name.strip() for name in lines[0]], []
    for number, words in enumerate(lines[1:], start=2):
        if not words:
            continue
        place = f"{path}, line {number}"
        if len(words) != len(names):
            raise UserError(
                f"{len(words)} values for {len(names)} columns",
                where=place,
                remedy="mend or leave out the row",
            )
        rows.append([_number(word, place) for word in words])
    return names, np.asarray(rows, np.float64).reshape(-1, len(names))


def _parquet(path: Path) -> tuple[list[str], np.ndarray]:
    try:
        from pyarrow import ArrowException, parquet
    except ImportError:
        raise UserError(
            "Parquet files need pyarrow", where=path, remedy="pip install 'motorspace[table]'"
        ) from None
    try:
        table = parquet.read_table(path)
        values = np.stack([c.to_numpy().astype(np.float64) for c in table.columns], axis=-1)
    except (ArrowException, OSError, ValueError, TypeError) as error:
        raise _unreadable(path, error) from None
    if not np.isfinite(values).all():
        row = int(np.argwhere(~np.isfinite(values))[0, 0])
        raise UserError(
            "a value is missing or not finite",
            where=f"{path}, row {row}",
            remedy="mend or leave out the row",
        )
    return list(table.column_names), values


def _number(word: str, place: str) -> float:
    try:
        value = float(word)
    except ValueError:
        value = math.nan
    if not math.isfinite(value):
        raise UserError(
            f"{word!r} is not a number", where=place, remedy="mend or leave out the row"
        )
    return value


def _unreadable(path: Path, error: Exception) -> UserError:
    reason = getattr(error, "strerror", None) or "it is damaged or of another format"
    return UserError(
        f"the table cannot be read ({reason})", where=path, remedy="check the path and the file"
    )
