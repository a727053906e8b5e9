"""Recordings as tables, which the reader `table` reads back with the same transitions."""

import csv
import io
from pathlib import Path

import numpy as np
from jaxtyping import Float

from motorspace._errors import UserError
from motorspace._files import write_atomically
from motorspace.recordings.readers.about import KEY, PREFIX, About
from motorspace.recordings.recording import Recording, chained_per_interval, sensor_frames

PLANAR = ("motor_longitudinal", "motor_lateral", "motor_rotation")

ENDINGS = (".csv", ".parquet")


def write_table(recording: Recording, path: Path | str) -> None:
    """Writes a recording as a table: a row for each scan, with the motors up to the next one.

    The increments between two scans become one command. Intervals that are left out have no
    motors. What the columns do not say stands in a comment, or in the metadata of the Parquet file.

    Args:
        recording: The log, or a simulated walk.
        path: A file that ends in .csv or .parquet; it is replaced as a whole.

    Raises:
        UserError: Another ending, a file that cannot be written, or Parquet without pyarrow.
    """
    path = Path(path)
    check_ending(path)
    columns = _columns(recording)
    about = About(
        planar=recording.planar,
        sensor_scale=recording.sensor_scale,
        judged=recording.judged,
        odometry_poses=recording.odometry_poses,
        shape=recording.shape or None,
    )
    content = _csv if path.suffix == ".csv" else _parquet
    write_atomically(path, content(columns, about))


def check_ending(path: Path) -> None:
    """Raise `UserError` unless a table can be written under this name."""
    if path.suffix not in ENDINGS:
        raise UserError(
            f"a table cannot end in {path.suffix!r}",
            where=path,
            remedy=f"choose one of {', '.join(ENDINGS)}",
        )


def _columns(recording: Recording) -> dict[str, Float[np.ndarray, " N"]]:
    """The columns by name; NaN where a row has no motors, or no pose."""
    size = recording.increments.shape[1]
    motors = np.full((len(recording), size), np.nan)
    chained = chained_per_interval(recording)
    executed = np.bincount(recording.interval, minlength=len(recording) - 1) > 0
    known = recording.usable & executed
    motors[:-1][known] = chained[known]
    names = PLANAR if recording.planar else tuple(f"motor_{i}" for i in range(size))
    columns = {"time": recording.time} | dict(zip(names, motors.T, strict=True))
    columns |= {f"sensor_{i}": values for i, values in enumerate(recording.sensors.T)}
    known = np.isfinite(recording.poses).all(axis=1)
    if known.any():
        columns |= dict(zip(("x", "y", "theta"), sensor_frames(recording), strict=True))
    return columns


def _csv(columns: dict[str, Float[np.ndarray, " N"]], about: About) -> bytes:
    text = io.StringIO()
    text.write(f"{PREFIX} {about.text()}\n")
    writer = csv.writer(text, lineterminator="\n")
    writer.writerow(columns)
    for row in zip(*(values.tolist() for values in columns.values()), strict=True):
        # The shortest numbers that read back as exactly these; empty where there is none.
        writer.writerow("" if value != value else repr(value) for value in row)
    return text.getvalue().encode()


def _parquet(columns: dict[str, Float[np.ndarray, " N"]], about: About) -> bytes:
    try:
        import pyarrow
        from pyarrow import parquet
    except ImportError:
        raise UserError(
            "Parquet files need pyarrow", remedy="pip install 'motorspace[table]'"
        ) from None
    table = pyarrow.table(columns).replace_schema_metadata({KEY: about.text()})
    sink = io.BytesIO()
    parquet.write_table(table, sink)
    return sink.getvalue()
