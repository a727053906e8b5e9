"""Recordings that are written as tables and read back."""

import json

import jax
import numpy as np
import pytest

from motorspace import UserError
from motorspace.cli.main import main
from motorspace.recordings.readers.base import read_log
from motorspace.recordings.windows import windows
from motorspace.recordings.written import write_table
from tests.recordings.logs import corrected_log, raw_log, write

LOGS = {
    "raw": raw_log(12),
    "corrected": corrected_log(9),
    "with a gap": raw_log(6) + raw_log(6, start=40.5),
    "of a table": "time,motor_a,sensor_a,x,y,theta\n"
    + "".join(f"{k},{0.5 * k},{k % 3},{k},0,\n" for k in range(9)).replace("4,2.0", "4,"),
}


@pytest.mark.parametrize("case", LOGS)
@pytest.mark.parametrize("ending", [".csv", ".parquet"])
def test_the_transitions_are_the_same(tmp_path, case, ending):
    if ending == ".parquet":
        pytest.importorskip("pyarrow")
    before = read_log(write(tmp_path / "a.log", LOGS[case]), max_gap=5.0)
    write_table(before, tmp_path / f"b{ending}")
    after = read_log(tmp_path / f"b{ending}")
    assert after.usable.tolist() == before.usable.tolist()
    assert (after.planar, after.sensor_scale) == (before.planar, before.sensor_scale)
    assert after.odometry_poses == before.odometry_poses == (case in ("raw", "with a gap"))
    first, second = (windows(r, horizon=2, per_scan=True) for r in (before, after))
    for one, other in zip(jax.tree.leaves(first), jax.tree.leaves(second), strict=True):
        np.testing.assert_array_equal(one, other)


def test_rules_are_applied_anew_where_they_are_given(tmp_path):
    log = write(tmp_path / "a.log", raw_log(12))
    write_table(read_log(log), tmp_path / "b.csv")
    assert read_log(tmp_path / "b.csv").usable.all()
    assert not read_log(tmp_path / "b.csv", max_gap=0.5).usable.any()


@pytest.mark.parametrize(
    ("text", "why"),
    [
        ("[]", "it is no JSON object"),
        ("{", "it is no JSON object"),
        ('{"planar": 1}', "planar is true or false"),
        ('{"sensor_scale": [0]}', "numbers above 0"),
        ('{"sensor_scale": [1, 2]}', "does not fit 1 motor and 1 sensor"),
        ('{"planar": true}', "does not fit 1 motor"),
        ('{"other": 1}', "it names other"),
        ('{"shape": [0]}', "shape is a list of whole numbers above 0"),
        ('{"shape": []}', "shape is a list of whole numbers above 0"),
        ('{"shape": [2, 1]}', "does not fit 1 motor and 1 sensor"),
    ],
)
def test_a_broken_description_is_one_sentence(tmp_path, text, why):
    table = f"# motorspace: {text}\ntime,motor_a,sensor_a\n0,1,1\n1,1,2\n"
    with pytest.raises(UserError, match=why):
        read_log(write(tmp_path / "a.csv", table))


def test_broken_rows_of_a_table_are_counted_and_not_crossed(tmp_path):
    rows = [f"{k},0.5,{k}" for k in range(10)]
    rows[3], rows[6], rows[8] = "3,0.5", "6,fast,6", "8,0.5,far"
    path = write(tmp_path / "a.csv", "time,motor_a,sensor_a\n" + "\n".join(rows) + "\n")
    with pytest.raises(UserError, match=r"line 5: 2 values for 3 columns.*skip_bad"):
        read_log(path)
    found = read_log(path, skip_bad=True)
    assert (~found.usable).nonzero()[0].tolist() == [2, 3, 6, 7, 8]
    assert sum(note.startswith("skipped 1 broken") for note in found.notes) == 3


def test_broken_rows_of_robots_logs_are_counted(tmp_path):
    lines = raw_log(8).splitlines()
    lines[4] = "FLASER 9 1 2 3"
    lines[9] = "ODOM x y z"
    path = write(tmp_path / "a.log", "\n".join(lines) + "\n")
    with pytest.raises(UserError, match=r"line 5: .*skip_bad"):
        read_log(path)
    found = read_log(path, skip_bad=True)
    assert sum(note.startswith("skipped 1 broken") for note in found.notes) == 2


def test_a_cut_gzip_file_is_read_up_to_there(tmp_path):
    path = write(tmp_path / "a.log.gz", raw_log(400))
    path.write_bytes(path.read_bytes()[:-200])
    with pytest.raises(UserError, match=r"cut off.*skip_bad"):
        read_log(path)
    assert len(read_log(path, skip_bad=True)) > 100


def test_text_beyond_the_limit_is_refused_before_memory_ends(tmp_path, monkeypatch):
    monkeypatch.setattr("motorspace.recordings.readers.text.LARGEST", 2000)
    for name in ("a.log", "b.log.gz"):
        with pytest.raises(UserError, match="the text is larger than"):
            read_log(write(tmp_path / name, raw_log(400)))


def test_the_commands_write_and_draw(tmp_path, capsys):
    log = write(tmp_path / "robot.log", raw_log(12))
    main(["import", str(log), "--out", str(tmp_path / "robot.csv"), "--num-rays", "3"])
    assert "motorspace train --data" in capsys.readouterr().out
    report = json.loads((tmp_path / "robot.csv.report.json").read_text())
    assert report["scans"] == 12 and report["options"] == {"num_rays": 3}
    main(["inspect", str(tmp_path / "robot.csv"), "--out", str(tmp_path / "seen")])
    assert (tmp_path / "seen" / "path.png").read_bytes().startswith(b"\x89PNG")
    described = json.loads((tmp_path / "seen" / "inspection.json").read_text())
    assert described["scans per second (median)"] == 1.0
    for out, message in (("robot.csv", "the file exists already"), ("robot.npz", "cannot end in")):
        with pytest.raises(SystemExit) as error:
            main(["import", str(log), "--out", str(tmp_path / out)])
        assert error.value.code == 2 and message in capsys.readouterr().err


def test_angles_on_the_command_line_are_in_units_of_pi(tmp_path, capsys):
    log = write(tmp_path / "robot.log", raw_log(6))
    out = tmp_path / "robot.csv"
    main(["import", str(log), "--out", str(out), "--field-of-view", "0.5"])
    capsys.readouterr()
    narrow = read_log(log, field_of_view=np.pi / 2)
    np.testing.assert_array_equal(read_log(out).sensors, narrow.sensors)
