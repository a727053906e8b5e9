"""A run's codes, and the trajectories behind them, as files that other programs read."""

import io
import json
from collections.abc import Callable
from pathlib import Path
from typing import Any, Literal, NamedTuple

import jax
import numpy as np
from jaxtyping import Float, Shaped

from motorspace._errors import UserError
from motorspace.evaluation.sampling import test_trajectories
from motorspace.export.files import Files, made_by, needs, write_files
from motorspace.training.run import Run
from motorspace.trajectories.transitions import Experience, Trajectories

Format = Literal["npy", "parquet"]

Draw = Callable[..., Trajectories]
"""`draw(data, num, key=key)`: a number of trajectories for a run on these data."""

EXPORT_SEED = 2_000_003
"""Exports draw from their own stream, apart from training and evaluation."""

CHUNK_SIZE = 8192
"""Sequences encoded at once: what is needed beside the result stays bounded."""


class Table(NamedTuple):
    """An array with one row for each trajectory, and what there is to know about it."""

    values: Shaped[np.ndarray, "N ..."]
    columns: tuple[str, ...]
    """A name for every number of a row, in C order."""
    about: str
    unit: str


def export_arrays(
    run: Run,
    out: Path,
    *,
    num: int,
    seed: int = 0,
    format: Format = "npy",
    draw: Draw = test_trajectories,
    force: bool = False,
) -> None:
    """Write the codes of fresh trajectories, and the trajectories, as arrays or tables.

    Row i of every file belongs to trajectory i: `codes`, `displacements` (achieved),
    `nominal_displacements`, `motors`, `num_steps`, `sensors` and `later_sensors`, each as `.npy`
    or as a Parquet table with column names. `schema.json`, written last, holds shapes, units,
    columns, and the configuration of the run.

    Args:
        run: A trained run.
        out: The folder to write into.
        num: Trajectories.
        seed: Seed of the trajectories.
        format: npy or parquet (extra `table`).
        draw: Draws trajectories from a configuration, a number and a key.
        force: Replace files that are already there.

    Raises:
        UserError: `num` is below 1, pyarrow is not installed, or a file is already there.
    """
    write_files(out, array_files(run, num=num, seed=seed, format=format, draw=draw), force=force)


def array_files(
    run: Run, *, num: int, seed: int = 0, format: Format = "npy", draw: Draw = test_trajectories
) -> Files:
    """The files of `export_arrays`. Raises `UserError` as it does."""
    if num < 1:
        raise UserError(f"num must be at least 1, got {num}")
    trajectories = draw(run.config.data, num, key=jax.random.key(EXPORT_SEED + seed))
    return trajectory_files(run, trajectories, format=format, origin={"num": num, "seed": seed})


def trajectory_files(
    run: Run, trajectories: Trajectories, *, format: Format, origin: dict[str, Any]
) -> Files:
    """The files of `export_arrays` for given trajectories.

    Args:
        run: A trained run.
        trajectories: N trajectories in the units that the run was trained in.
        format: npy or parquet.
        origin: What `schema.json` says about where the trajectories come from.

    Returns:
        The content of each file by its name.

    Raises:
        UserError: pyarrow is not installed.
    """
    tables = tables_of(run, trajectories)
    pack = _npy if format == "npy" else _parquet
    files = {f"{name}.{format}": pack(table) for name, table in tables.items()}
    schema = {
        "files": {f"{name}.{format}": _described(table) for name, table in tables.items()},
        **origin,
        **made_by(run),
    }
    return files | {"schema.json": (json.dumps(schema, indent=1) + "\n").encode()}


def tables_of(run: Run, trajectories: Trajectories) -> dict[str, Table]:
    """The run's codes and the arrays of the trajectories by their names."""
    experience, (nominal, achieved) = trajectories.experience, trajectories.displacements
    motors = np.asarray(experience.motors)
    codes, (_, horizon, motor_size) = _codes(run, experience), motors.shape
    sensors = _numbered("sensor", experience.sensors.shape[1])
    steps = tuple(f"{m}.t{t}" for t in range(horizon) for m in _numbered("motor", motor_size))
    moved = ("longitudinal", "lateral", "orientation_change")
    unit = "world units, world units, radians in (-pi, pi]"
    frame = "in the frame of the sensors at the start"
    raw = "the units that the run was trained in"
    return {
        "codes": Table(codes, _numbered("code", codes.shape[1]), "codes h^m of the motors", "1"),
        "displacements": Table(np.asarray(achieved), moved, f"what happened, {frame}", unit),
        "nominal_displacements": Table(
            np.asarray(nominal), moved, f"what the commands do without walls, {frame}", unit
        ),
        "motors": Table(motors, steps, "motor sequences; zeros beyond num_steps", raw),
        "num_steps": Table(
            np.asarray(experience.num_steps), ("num_steps",), "commands of each sequence", "1"
        ),
        "sensors": Table(np.asarray(experience.sensors), sensors, "before the sequence", raw),
        "later_sensors": Table(
            np.asarray(experience.later_sensors), sensors, "after the sequence", raw
        ),
    }


def _codes(run: Run, experience: Experience) -> Float[np.ndarray, "N C"]:
    starts = range(0, len(experience), CHUNK_SIZE)
    chunks = (experience[start : start + CHUNK_SIZE] for start in starts)
    return np.concatenate([np.asarray(run.encode(c.motors, c.num_steps)) for c in chunks])


def _numbered(name: str, size: int) -> tuple[str, ...]:
    return tuple(f"{name}_{index}" for index in range(size))


def _described(table: Table) -> dict[str, Any]:
    return {
        "about": table.about,
        "unit": table.unit,
        "shape": list(table.values.shape),
        "dtype": str(table.values.dtype),
        "columns": list(table.columns),
    }


def _npy(table: Table) -> bytes:
    packed = io.BytesIO()
    np.save(packed, table.values, allow_pickle=False)
    return packed.getvalue()


def _parquet(table: Table) -> bytes:
    with needs("table"):
        import pyarrow
        from pyarrow import parquet
    rows = table.values.reshape(len(table.values), -1)
    columns = pyarrow.table(dict(zip(table.columns, rows.T, strict=True)))
    packed = io.BytesIO()
    parquet.write_table(columns, packed)
    return packed.getvalue()
