"""Files: found by their content, whatever their name, compression and encoding."""

import gzip
import re
import subprocess
import sys
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import pytest

from motorspace import UserError
from motorspace._kinds import register
from motorspace.recordings.catalog import READERS, reader_for
from motorspace.recordings.readers.base import AbstractReader, read_log
from motorspace.recordings.readers.carmen import CarmenReader
from motorspace.recordings.readers.table import TableReader
from motorspace.recordings.recording import Recording
from motorspace.testing.reader import check_reader
from tests.recordings.logs import flaser, odom, raw_log, write

ROOT = Path(__file__).parents[2]
TABLE = "time,motor_a,sensor_a\n0,0.5,1\n1,0.25,3\n2,0.1,5\n"
WEAN = "".join(
    f"O {100 * i} 0 0 {i}\nL {100 * i + 50} 0 0 {100 * i + 75} 0 0 100 200 8183 {i + 0.5}\n"
    for i in range(6)
)
TEXTS = {"carmen": raw_log(), "table": TABLE, "wean": WEAN}


@pytest.mark.parametrize("kind", TEXTS)
@pytest.mark.parametrize(
    "name", ["a", "a.log", "a.LOG", "a.CSV", "a.txt", "a.tsv", "b.log.gz", "c.gz"]
)
def test_the_content_says_which_format_it_is(tmp_path, kind, name):
    path = write(tmp_path / name, TEXTS[kind])
    assert reader_for(path) == kind
    assert len(read_log(str(path))) == len(read_log(path)) >= 3


@pytest.mark.parametrize("kind", TEXTS)
def test_gzip_without_the_ending_and_plain_text_with_it(tmp_path, kind):
    (tmp_path / "a.log.gz").write_text(TEXTS[kind])
    (tmp_path / "b.log").write_bytes(gzip.compress(TEXTS[kind].encode()))
    first, second = read_log(tmp_path / "a.log.gz"), read_log(tmp_path / "b.log")
    np.testing.assert_array_equal(first.sensors, second.sensors)


@pytest.mark.parametrize("kind", TEXTS)
@pytest.mark.parametrize("encoding", ["utf-8-sig", "latin-1", "utf-16"])
@pytest.mark.parametrize("ends", ["\n", "\r\n"])
def test_marks_encodings_and_line_ends_change_nothing(tmp_path, kind, encoding, ends):
    text = "# größe\n" * (kind != "wean") + TEXTS[kind]
    text = text.replace(" ", "\t") if kind != "table" else text
    path = write(tmp_path / "a", text.replace("\n", ends), encoding)
    plain = read_log(write(tmp_path / "b", TEXTS[kind]))
    found = read_log(path, reader=kind)
    np.testing.assert_array_equal(found.sensors, plain.sensors)
    np.testing.assert_array_equal(found.increments, plain.increments)


def test_a_mark_does_not_drop_the_first_scan(tmp_path):
    assert (
        len(read_log(write(tmp_path / "a.log", flaser(-1.0) + "\n" + raw_log(), "utf-8-sig"))) == 9
    )


def test_wean_rows_are_centimetres(tmp_path):
    recording = read_log(write(tmp_path / "wean.log.gz", WEAN), num_rays=3)
    assert recording.sensors[0].tolist() == [1, 2, 10]
    assert recording.increments[:, 0].tolist() == [0.5] * 10
    assert recording.poses[:, 0].tolist() == [0.75, 1.75, 2.75, 3.75, 4.75, 5.75]
    assert recording.time[0] == 0.5
    for broken in ("L 1 2 3\n", "O 1 2 x 4\n"):
        with pytest.raises(UserError, match="line 13"):
            read_log(write(tmp_path / "broken.log", WEAN + broken))


FOREIGN = {
    b"#ROSBAG V1.2\n": "it is a ROS bag of version 1",
    b"\x28\xb5\x2f\xfd": "it is packed with zstd",
    b"PK\x03\x04": "it is a zip archive",
    b"hello world\n": "it begins with 'hello world'",
    b"\n\n  ": "the file is empty",
    b"": "the file is empty",
}


@pytest.mark.parametrize("content", FOREIGN)
def test_files_of_other_formats_are_one_sentence(tmp_path, content):
    (tmp_path / "robot.bag").write_bytes(content)
    with pytest.raises(UserError, match=re.escape(FOREIGN[content])):
        read_log(tmp_path / "robot.bag")


def test_a_file_that_its_ending_alone_assigns_is_judged_by_that_reader(tmp_path):
    with pytest.raises(UserError, match="the columns are a, b; a table needs time"):
        read_log(write(tmp_path / "robot.csv", "a,b\n1,2\n"))
    with pytest.raises(UserError, match="no scans of the front laser"):
        read_log(write(tmp_path / "robot.clf.gz", "hello world\n"))


def test_missing_damaged_and_cut_files(tmp_path):
    with pytest.raises(UserError, match=r"nowhere\.log: there is no such file"):
        read_log(tmp_path / "nowhere.log")
    with pytest.raises(UserError, match="this is a folder"):
        read_log(tmp_path)
    whole = gzip.compress(raw_log(400).encode())
    for name, content, message in (
        ("cut.log.gz", whole[:-200], r"cut.log.gz, after line \d+: the gzip file is cut off"),
        (
            "flipped.log.gz",
            whole[:400] + b"\0" * 40 + whole[440:],
            "the gzip data are damaged|cannot",
        ),
        ("binary.log", raw_log().encode() + b"\0\1\2", "the file is not text"),
    ):
        (tmp_path / name).write_bytes(content)
        with pytest.raises(UserError, match=message):
            read_log(tmp_path / name)


def test_options_are_those_of_the_reader(tmp_path):
    log, table = write(tmp_path / "a", raw_log()), write(tmp_path / "b", TABLE)
    assert read_log(log, num_rays=3).sensors.shape == (8, 3)
    with pytest.raises(UserError, match=r"'table' has no option num_rays; its options are max_gap"):
        read_log(table, num_rays=3)
    with pytest.raises(UserError, match="clock"):
        read_log(log, clock="broken")
    assert read_log(log, CarmenReader(num_rays=2)).sensors.shape == (8, 2)
    with pytest.raises(UserError, match="takes no options"):
        read_log(log, CarmenReader(), num_rays=2)
    with pytest.raises(UserError, match="no reader named 'carman' \\(perhaps 'carmen'\\)"):
        read_log(log, "carman")
    with pytest.raises(UserError, match="the columns are"):
        read_log(log, "table")


@pytest.mark.parametrize("kind", READERS.names)
def test_every_option_says_what_it_does(kind):
    for option in READERS.parameters(kind):
        assert option.help.endswith((".", ").")), option


@dataclass(frozen=True)
class PairsReader(AbstractReader):
    """A reader of one's own: a number and a distance on each line, after a title."""

    scale: float = 1.0
    """What numbers are multiplied by."""

    @classmethod
    def recognises(cls, name, head):
        return head.startswith(b"time pairs")

    def parse(self, path):
        rows = np.loadtxt(path.read_text().splitlines()[1:]) * self.scale
        return Recording(
            name=path.name,
            time=np.arange(len(rows), dtype=float),
            sensors=rows[:, 1:],
            increments=rows[:-1, :1],
            interval=np.arange(len(rows) - 1),
            poses=np.full((len(rows), 4), np.nan),
            sensor_scale=(float(rows[:, 1].max()),),
            planar=False,
            usable=np.ones(len(rows) - 1, bool),
        )


def test_a_reader_of_ones_own_is_asked_first(tmp_path, monkeypatch):
    monkeypatch.setattr(READERS, "_added", {})
    register("pairs")(PairsReader)
    path = write(tmp_path / "a.csv", "time pairs\n1 2\n3 4\n5 6\n")
    assert reader_for(path) == "pairs"
    assert read_log(path, scale=2.0).sensors.ravel().tolist() == [4, 8, 12]
    assert [option.name for option in READERS.parameters("pairs")][-1] == "scale"


def test_readers_pass_the_checks(tmp_path):
    for kind, text in TEXTS.items():
        check_reader(READERS.class_of(kind)(), write(tmp_path / kind, text))


class Unsound(TableReader):
    """A reader that makes one mistake."""

    changes = {}

    def parse(self, path):
        import dataclasses

        return dataclasses.replace(super().parse(path), **self.changes)


MISTAKES = {
    "the sensors have to be finite": {"sensors": np.array([[1.0], [np.nan], [2.0]])},
    "interval has to be sorted": {"interval": np.array([1, 0])},
    "interval has to be from 0 to 1": {"interval": np.array([1, 2])},
    "a reading exceeds the scale": {"sensor_scale": (1.0,)},
    "scales have to be above 0": {"sensor_scale": (0.0,)},
    "planar increments need 3 channels": {"planar": True},
    "a pose is known in part": {"poses": np.array([[1.0, np.nan, 0.0, 0.0]] * 3)},
}


@pytest.mark.parametrize("sentence", MISTAKES)
def test_the_checks_name_what_is_wrong(tmp_path, sentence, monkeypatch):
    monkeypatch.setattr(Unsound, "changes", MISTAKES[sentence])
    with pytest.raises(AssertionError, match=sentence):
        check_reader(Unsound(), write(tmp_path / "a.csv", TABLE))


def test_nothing_heavy_is_imported_before_a_file_is_there(tmp_path):
    """In a process of its own, without what the package's front door imports."""
    package = tmp_path / "motorspace"
    package.mkdir()
    (package / "__init__.py").write_text(f"__path__.append({str(ROOT / 'motorspace')!r})\n")
    code = (
        "import sys; from motorspace.recordings.catalog import reader_for\n"
        "try: reader_for('nowhere.log')\n"
        "except Exception as error: assert 'no such file' in str(error)\n"
        "assert not {'numpy', 'jaxtyping'} & set(sys.modules)\n"
        "from motorspace.recordings.readers.base import read_log\n"
        f"read_log({str(write(tmp_path / 'a', TABLE))!r})\n"
        "sys.exit(' '.join({'jax', 'equinox', 'pyarrow', 'scipy'} & set(sys.modules)) or 0)"
    )
    done = subprocess.run(
        [sys.executable, "-c", code], cwd=tmp_path, capture_output=True, text=True, check=False
    )
    assert done.returncode == 0, done.stderr


def test_odometry_is_kept_where_it_is_written_first(tmp_path):
    text = odom(0.0, time=0.0) + "\n" + raw_log()
    assert len(read_log(write(tmp_path / "a.log", text))) == 8
