"""Plain tables: one row per time step, as text or Parquet.

Columns: `time` in seconds; `motor_*`, what was executed between this row and the next;
`sensor_*`, what is sensed now; optionally the true pose `x`, `y`, `theta`, for evaluation.
"""

from dataclasses import dataclass
from pathlib import Path
from typing import ClassVar, Literal

import numpy as np
from jaxtyping import Bool, Float

from motorspace._errors import UserError
from motorspace.recordings.readers.base import AbstractReader
from motorspace.recordings.readers.columns import POSE, Table, is_used
from motorspace.recordings.readers.delimited import (
    Decimal,
    Separator,
    find_header,
    read_delimited,
)
from motorspace.recordings.readers.faults import Faults
from motorspace.recordings.readers.parquet import PER_SECOND, read_parquet
from motorspace.recordings.readers.text import read_bytes
from motorspace.recordings.recording import Recording

PARQUET = b"PAR1"

TimeUnit = Literal["s", "ms", "us", "ns"]


@dataclass(frozen=True)
class TableReader(AbstractReader):
    """Reads a table with the columns `time`, `motor_*`, `sensor_*` and perhaps `x`, `y`, `theta`.

    Other columns are ignored, and so are case, a unit in brackets and a row of units. The motors
    of a row are executed until the next row, so those of the last row are not used.
    """

    endings: ClassVar[tuple[str, ...]] = (".csv", ".tsv", ".parquet", ".pq", ".txt")

    separator: Separator = "auto"
    """What stands between the cells of a text table."""
    decimal: Decimal = "auto"
    """The decimal sign of a text table."""
    time_unit: TimeUnit = "s"
    """Unit of the column time, where it holds plain numbers."""
    max_range: float | None = None
    """Readings at or beyond it mean no return and become it (default: only infinite ones, which
    become the largest finite reading of their column)."""
    missing: Literal["leave_out", "refuse"] = "leave_out"
    """Rows that lack a motor or a sensor: leave out the transitions that need them, or refuse the
    table."""
    skip_bad: bool = False
    """Take broken rows and cells as missing and count them, instead of refusing the table."""

    def __post_init__(self) -> None:
        super().__post_init__()
        if self.max_range is not None and not self.max_range > 0:
            raise UserError(f"max_range must be above 0, got {self.max_range}")

    @classmethod
    def recognises(cls, name: str, head: bytes) -> bool:
        """Whether it is Parquet, or its first row names at least two of the columns."""
        if head.startswith(PARQUET):
            return True
        header = find_header(_decoded(head).splitlines()[:50])
        return header is not None and sum(map(is_used, header.names)) > 1

    def parse(self, path: Path) -> Recording:
        """The readings of every row, and the motors between them."""
        faults = Faults(self.skip_bad)
        table = self._table(path, faults)
        motors = [name for name in table.columns if name.startswith("motor")]
        sensors = [name for name in table.columns if name.startswith("sensor")]
        if len(table.places) < 2:
            raise UserError(
                f"the table holds {len(table.places)} rows",
                where=path,
                remedy="at least two are needed",
            )
        table.about.check(len(motors), len(sensors), where=path)
        notes = [*table.notes, *faults.notes()]
        if table.ignored:
            notes.append(f"columns that are not read: {', '.join(table.ignored)}")
        executed = self._complete(table, motors, slice(0, -1), notes)
        increments = np.stack([table.columns[name][:-1] for name in motors], axis=-1)
        self._no_return(table, sensors, notes)
        sensed = self._complete(table, sensors, slice(None), notes)
        readings = np.stack([_filled(table.columns[name]) for name in sensors], axis=-1)
        largest = np.abs(readings).max(axis=0)
        scale = np.maximum(largest, table.about.sensor_scale or 0.0)
        return Recording(
            name=path.name,
            time=table.columns["time"],
            sensors=readings,
            increments=increments[executed],
            interval=np.flatnonzero(executed),
            poses=_poses(table, notes),
            sensor_scale=tuple(float(s) if s > 0 else 1.0 for s in scale),
            planar=table.about.planar,
            judged=table.about.judged,
            odometry_poses=table.about.odometry_poses,
            shape=table.about.shape or (),
            usable=executed & sensed[:-1] & sensed[1:],
            notes=tuple(notes),
        )

    def _table(self, path: Path, faults: Faults) -> Table:
        if read_bytes(path, len(PARQUET)) == PARQUET:
            table = read_parquet(path)
        else:
            table = read_delimited(path, faults, separator=self.separator, decimal=self.decimal)
        if not table.dated:
            table.columns["time"] = table.columns["time"] / PER_SECOND[self.time_unit]
        return table

    def _complete(
        self, table: Table, names: list[str], rows: slice, notes: list[str]
    ) -> Bool[np.ndarray, " N"]:
        """The rows with a finite value in each of these columns; others are noted or refused."""
        complete = np.ones(len(table.places[rows]), bool)
        for name in names:
            values = table.columns[name][rows]
            lacking = ~np.isfinite(values)
            if lacking.all():
                raise UserError(
                    f"the column {name} holds no number",
                    where=table.places[0].rsplit(",", 1)[0],
                    remedy="fill it, or give it another name",
                )
            if lacking.any():
                place = table.places[int(np.argmax(lacking))]
                if self.missing == "refuse":
                    raise UserError(
                        f"{name} is missing",
                        where=place,
                        remedy="fill it, or set missing to leave_out",
                    )
                notes.append(f"{name} is missing in {lacking.sum()} rows (the first: {place})")
            _refuse_overflow(name, values, table.places[rows])
            complete &= ~lacking
        return complete

    def _no_return(self, table: Table, sensors: list[str], notes: list[str]) -> None:
        """Put the maximum range where a sensor reports an infinite or a longer distance."""
        count = 0
        for name in sensors:
            values = table.columns[name]
            finite = values[np.isfinite(values)]
            limit = self.max_range or (float(finite.max()) if len(finite) else np.inf)
            beyond = values == np.inf if self.max_range is None else values >= limit
            count += int(beyond.sum())
            table.columns[name] = np.where(beyond, limit, values)
        if count:
            limit_of = f"{self.max_range:g}" if self.max_range else "their column's largest reading"
            notes.append(f"{count} readings are no return: {limit_of} stands for them")


def _poses(table: Table, notes: list[str]) -> Float[np.ndarray, "N 4"]:
    """(x, y, theta, 0), NaN where one of the three is unknown."""
    num = len(table.places)
    named = [name for name in POSE if name in table.columns]
    if 0 < len(named) < 3:
        notes.append(f"a pose needs {', '.join(POSE)}; the table has {', '.join(named)} alone")
    unknown = np.full(num, np.nan)
    poses = np.stack([table.columns.get(name, unknown) for name in POSE], axis=-1)
    lacking = ~np.isfinite(poses).all(axis=1)
    if len(named) == 3 and lacking.any():
        notes.append(f"the true pose is unknown in {lacking.sum()} rows")
    poses[lacking] = np.nan
    if (np.abs(poses[:, 2]) > 4 * np.pi).any():
        notes.append("theta exceeds two full turns: it has to be in radians")
    return np.concatenate([poses, np.zeros((num, 1))], axis=1)


def _filled(values: Float[np.ndarray, " N"]) -> Float[np.ndarray, " N"]:
    """The last known value where one is missing; no transition uses it."""
    known = np.isfinite(values)
    last = np.maximum.accumulate(np.where(known, np.arange(len(values)), np.argmax(known)))
    return values[last]


def _refuse_overflow(name: str, values: Float[np.ndarray, " N"], places: list[str]) -> None:
    finite = np.where(np.isfinite(values), np.abs(values), 0.0)
    if finite.max() > np.finfo(np.float32).max:
        row = int(np.argmax(finite))
        raise UserError(
            f"{name} is {values[row]:g}, too large for 32-bit numbers",
            where=places[row],
            remedy="correct the value, or choose a larger unit",
        )


def _decoded(head: bytes) -> str:
    if head.startswith((b"\xff\xfe", b"\xfe\xff")):
        return head.decode("utf-16", errors="replace")
    return head.decode("utf-8-sig", errors="replace")
