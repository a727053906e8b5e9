"""What every reader of logs must satisfy."""

import tempfile
from dataclasses import fields
from pathlib import Path

import numpy as np

from motorspace._errors import UserError
from motorspace._kinds import parameters_of
from motorspace.recordings.readers.base import AbstractReader
from motorspace.recordings.readers.text import HEAD, read_bytes
from motorspace.recordings.recording import Recording
from motorspace.testing.require import require


def check_reader(reader: AbstractReader, path: Path | str) -> Recording:
    """The recording that a reader makes of a small good file, after all checks.

    Checks that the reader recognises the file, that its options have defaults, that reading twice
    gives the same, that a missing file is one sentence, and that the recording is sound
    (`check_recording`).

    Args:
        reader: The reader, of ours or of one's own.
        path: A file that it has to read.

    Raises:
        AssertionError: The first check that fails, as a sentence.
    """
    path, kind = Path(path), type(reader).__qualname__
    require(isinstance(reader, AbstractReader), f"{kind} has to be derived from AbstractReader")
    parameters_of(type(reader))
    head = read_bytes(path, HEAD)
    require(type(reader).recognises(path.name, head), f"{kind} does not recognise {path.name}")
    check_recording(reader.parse(path), judged=False)
    recording = reader.read(path)
    check_recording(recording)
    if reader.clock == "check":
        _check_time(recording)
    again = reader.read(str(path))
    for field in fields(Recording):
        first, second = (np.asarray(getattr(r, field.name)) for r in (recording, again))
        same = np.array_equal(first, second, equal_nan=first.dtype.kind == "f")
        require(same, f"reading {path.name} twice gives two different {field.name}")
    _refuses_missing_file(reader, kind)
    return recording


def check_recording(recording: Recording, *, judged: bool = True) -> None:
    """Check that a recording is sound: shapes, finite values, order, scales.

    Args:
        recording: The recording.
        judged: Whether intervals that are no transition are left out already.

    Raises:
        AssertionError: The first check that fails, as a sentence.
    """
    num, size = len(recording), recording.increments.shape[-1]
    require(num >= 2, f"a recording needs at least two scans, this one has {num}")
    shapes = {
        "time": (num,),
        "sensors": (num, len(recording.sensor_scale)),
        "increments": (len(recording.interval), size),
        "poses": (num, 4),
        "usable": (num - 1,),
    }
    for name, shape in shapes.items():
        found = np.shape(getattr(recording, name))
        require(found == shape, f"{name} has shape {found}, it needs {shape}")
    for name in ("sensors", "increments"):
        values = getattr(recording, name)
        require(bool(np.isfinite(values).all()), f"the {name} have to be finite")
        require(bool((np.abs(values) < 3.4e38).all()), f"the {name} do not fit into 32 bits")
    _check_intervals(recording)
    if judged:
        commands = np.bincount(recording.interval, minlength=num - 1)
        require(bool((commands[recording.usable] > 0).all()), "a usable interval holds no command")
    _check_scale(recording)
    known = np.isfinite(recording.poses[:, :3])
    require(bool((known.all(1) | ~known.any(1)).all()), "a pose is known in part")
    require(all(isinstance(n, str) for n in recording.notes), "notes have to be sentences")


def _check_intervals(recording: Recording) -> None:
    interval, num = recording.interval, len(recording) - 1
    require(interval.dtype.kind == "i", "interval has to hold whole numbers")
    require(bool((np.diff(interval) >= 0).all()), "interval has to be sorted")
    within = len(interval) == 0 or (interval[0] >= 0 and interval[-1] < num)
    require(bool(within), f"interval has to be from 0 to {num - 1}")
    width = recording.increments.shape[1]
    require(width > 0, "there are no motor channels")
    require(not recording.planar or width == 3, f"planar increments need 3 channels, not {width}")


def _check_scale(recording: Recording) -> None:
    scale = np.asarray(recording.sensor_scale)
    require(bool((scale > 0).all() and np.isfinite(scale).all()), "scales have to be above 0")
    beyond = np.abs(recording.sensors) > scale * (1 + 1e-6)
    require(not beyond.any(), "a reading exceeds the scale of its sensor")


def _check_time(recording: Recording) -> None:
    seconds = np.diff(recording.time)
    if not np.isfinite(seconds).any() or not (seconds != 0).any():
        return
    require(
        bool(np.isfinite(seconds[recording.usable]).all()),
        "a usable interval has no time stamps: leave it out",
    )
    moving = np.abs(seconds[np.isfinite(seconds) & (seconds != 0)])
    least = -np.quantile(moving, 0.5, method="lower")
    require(
        bool((seconds[recording.usable] > least).all()),
        "time runs backwards in a usable interval: leave it out",
    )


def _refuses_missing_file(reader: AbstractReader, kind: str) -> None:
    with tempfile.TemporaryDirectory() as folder:
        try:
            reader.read(Path(folder) / "missing")
        except UserError:
            return
        except Exception as error:
            raise AssertionError(
                f"{kind} raises {type(error).__name__} for a missing file, not UserError"
            ) from error
    raise AssertionError(f"{kind} reads a file that does not exist")
