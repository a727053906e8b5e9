"""Scalars of every epoch, read back from the event file."""

import struct
import sys

import pytest

from motorspace._errors import UserError
from motorspace.export.tensorboard import TensorBoardLog


def scalars(path):
    """(name, step, value) of each scalar in an event file: records of length, checksum, bytes."""
    from tensorboardX.proto.event_pb2 import Event

    content, position = path.read_bytes(), 0
    while position < len(content):
        (size,) = struct.unpack_from("<Q", content, position)
        event = Event.FromString(content[position + 12 : position + 12 + size])
        yield from ((v.tag, event.step, v.simple_value) for v in event.summary.value)
        position += size + 16


def test_each_value_of_a_record_becomes_a_scalar(tmp_path):
    pytest.importorskip("tensorboardX")
    with TensorBoardLog(tmp_path) as log:
        log({"epoch": 1, "prediction_loss": 0.5, "code_variance": 0.25})
        log({"epoch": 2, "prediction_loss": 0.125, "code_variance": 0.75})
    (path,) = tmp_path.glob("events.out.tfevents.*")
    assert list(scalars(path)) == [
        ("prediction_loss", 1, 0.5),
        ("code_variance", 1, 0.25),
        ("prediction_loss", 2, 0.125),
        ("code_variance", 2, 0.75),
    ]


def test_a_missing_tensorboardx_says_how_to_install_it(monkeypatch, tmp_path):
    monkeypatch.setitem(sys.modules, "tensorboardX", None)
    with pytest.raises(UserError, match=r"pip install 'motorspace\[tensorboard\]'"):
        TensorBoardLog(tmp_path)


def test_a_folder_that_cannot_be_made_is_refused(tmp_path):
    pytest.importorskip("tensorboardX")
    (tmp_path / "file").write_bytes(b"")
    with pytest.raises(UserError, match="the TensorBoard log cannot be written"):
        TensorBoardLog(tmp_path / "file")
