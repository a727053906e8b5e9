"""A folder is never overwritten unasked, and files are whole or not there."""

import pytest

from motorspace._errors import UserError
from motorspace.export.files import write_files


def test_files_already_there_are_kept_unless_forced(tmp_path):
    (tmp_path / "b").write_bytes(b"mine")
    files = {"a": b"1", "b": b"2"}
    with pytest.raises(UserError, match=r"already holds b; .* --force"):
        write_files(tmp_path, files)
    assert (tmp_path / "b").read_bytes() == b"mine"
    assert not (tmp_path / "a").exists()
    write_files(tmp_path, files, force=True)
    assert {p.name: p.read_bytes() for p in tmp_path.iterdir()} == files


def test_other_files_are_left_alone(tmp_path):
    (tmp_path / "notes.part").write_bytes(b"mine")
    write_files(tmp_path, {"a": b"1"})
    assert (tmp_path / "notes.part").read_bytes() == b"mine"


def test_a_file_in_the_place_of_the_folder_is_refused(tmp_path):
    (tmp_path / "out").write_bytes(b"mine")
    with pytest.raises(UserError, match=r"out: the export cannot be written \(File exists\)"):
        write_files(tmp_path / "out", {"a": b"1"}, force=True)
