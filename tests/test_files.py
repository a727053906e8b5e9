"""Files are whole or not there, and what a person keeps beside them is left alone."""

import errno
import json
import os
import subprocess
import sys

import pytest

from motorspace import _files
from motorspace._errors import UserError
from motorspace._files import PART, json_text, locked, write_atomically, write_json

OTHERS = ("mine.part", ".hidden.part", "weights.safetensors.1.part", "x.motorspace-part", PART[1:])


def failing(code):
    def fail(*_):
        raise OSError(code, os.strerror(code))

    return fail


def test_a_file_is_replaced_as_a_whole(tmp_path):
    path = tmp_path / "a"
    write_atomically(path, b"first")
    write_atomically(path, b"second")
    assert path.read_bytes() == b"second"
    assert [p.name for p in tmp_path.iterdir()] == ["a"]


@pytest.mark.parametrize("code", [errno.ENOSPC, errno.EIO])
def test_what_cannot_be_written_is_one_sentence_and_the_old_file_stays(tmp_path, monkeypatch, code):
    path = tmp_path / "a"
    write_atomically(path, b"first")
    monkeypatch.setattr(_files.os, "fsync", failing(code))
    with pytest.raises(UserError, match=rf"a: the file cannot be written \({os.strerror(code)}\)"):
        write_atomically(path, b"second")
    assert path.read_bytes() == b"first"
    assert [p.name for p in tmp_path.iterdir()] == ["a"]


def test_a_folder_that_is_not_there_is_one_sentence(tmp_path):
    with pytest.raises(
        UserError, match=r"cannot be written .*; give a place in a folder that exists"
    ):
        write_atomically(tmp_path / "nowhere" / "a", b"")


def test_only_unfinished_files_of_ours_are_cleared_away(tmp_path):
    for name in OTHERS:
        (tmp_path / name).write_text("of the user")
    (tmp_path / "below").mkdir()
    (tmp_path / "below" / f".a.1{PART}").write_text("of another folder")
    ours = tmp_path / f".weights.safetensors.1{PART}"
    ours.write_text("half of it")
    with locked(tmp_path):
        assert not ours.exists()
    for name in OTHERS:
        assert (tmp_path / name).read_text() == "of the user"
    assert (tmp_path / "below" / f".a.1{PART}").exists()


HOLD = """
import sys, time
from pathlib import Path
from motorspace._files import locked
with locked(Path(sys.argv[1])):
    print("held", flush=True)
    time.sleep(60)
"""


def test_a_folder_belongs_to_one_process_until_that_ends_however_it_ends(tmp_path):
    holder = subprocess.Popen(
        [sys.executable, "-c", HOLD, str(tmp_path)], stdout=subprocess.PIPE, text=True
    )
    assert holder.stdout.readline() == "held\n"
    with (
        pytest.raises(UserError, match="another process is training in this folder"),
        locked(tmp_path),
    ):
        pass
    holder.kill()
    holder.communicate()
    with locked(tmp_path):
        pass


def test_a_folder_that_cannot_be_made_is_one_sentence(tmp_path):
    (tmp_path / "file").write_text("")
    for place in (tmp_path / "file", tmp_path / "file" / "below"):
        with pytest.raises(UserError, match="the folder cannot be written"), locked(place):
            pass


def test_json_holds_no_numbers_that_json_does_not_know(tmp_path):
    value = {"a": float("nan"), "b": [1.5, float("inf")], "c": {"d": (-float("inf"), None, "x")}}
    assert json.loads(json_text(value)) == {
        "a": None,
        "b": [1.5, None],
        "c": {"d": [None, None, "x"]},
    }
    write_json(tmp_path / "a.json", value)
    assert json.loads((tmp_path / "a.json").read_text())["a"] is None
