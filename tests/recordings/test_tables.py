"""Tables as robots and spreadsheets export them."""

import numpy as np
import pytest

from motorspace import UserError
from motorspace.recordings.readers.base import read_log
from motorspace.recordings.recording import describe
from tests.recordings.logs import write

TABLE = "time,motor_a,sensor_a,sensor_b\n0,0.5,1,2\n1,0.25,3,4\n2,0.1,5,-6\n"


@pytest.fixture
def read(tmp_path):
    """A function from the text of a table to its recording."""

    def reading(text, name="robot.csv", encoding="utf-8", **options):
        return read_log(write(tmp_path / name, text, encoding), **options)

    return reading


def means_the_same(recording):
    assert recording.time.tolist() == [0, 1, 2]
    assert recording.increments.tolist() == [[0.5], [0.25]]
    assert recording.sensors.tolist() == [[1, 2], [3, 4], [5, -6]]
    assert recording.sensor_scale == (5.0, 6.0)
    assert recording.usable.all()
    assert np.isnan(recording.poses[:, :3]).all()


def comma(text):
    return text.replace(",", ";").replace(".", ",")


WRITTEN = {
    "as documented": TABLE,
    "semicolons and decimal commas": comma(TABLE),
    "tabs": TABLE.replace(",", "\t"),
    "spaces": TABLE.replace(",", "  "),
    "bars": TABLE.replace(",", " | "),
    "quoted decimal commas": TABLE.replace("0.5", '"0,5"')
    .replace("0.25", '"0,25"')
    .replace("0.1", '"0,1"'),
    "digits in groups": TABLE.replace("0,0.5", '0,"0.5"'),
    "CRLF": TABLE.replace("\n", "\r\n"),
    "old Macintosh": TABLE.replace("\n", "\r"),
    "upper case": TABLE.upper(),
    "spaces around names": TABLE.replace(",", " , "),
    "units in brackets": TABLE.replace("time", "time [s]").replace("sensor_a", "Sensor_A (m)"),
    "a row of units": TABLE.replace("_b\n", "_b\ns,m/s,m,-\n"),
    "trailing separators": TABLE.replace("\n", ",\n"),
    "trailing separators without a name": TABLE.replace("2\n", "2,,\n"),
    "blank lines": TABLE.replace("\n", "\n\n") + "\n,,,\n",
    "comments": "# from a robot\n" + TABLE.replace("\n1,", "\n# half way\n1,"),
    "names in a comment": "# exported\n#" + TABLE,
    "a hint for spreadsheets": "sep=,\n" + TABLE,
    "names repeated": TABLE.replace("2,0.1", "time,motor_a,sensor_a,sensor_b\n2,0.1"),
    "an index": TABLE.replace("\n", "\n7,").replace("time", ",time", 1).removesuffix("7,"),
    "text beside": TABLE.replace("\n", ",base_link\n").replace("base_link", "frame_id", 1),
    "empty columns beside": TABLE.replace("\n", ",,\n").replace("_b,,", "_b,note,"),
    "no motors in the last row": TABLE.replace("2,0.1", "2,"),
    "nan motors in the last row": TABLE.replace("2,0.1", "2,NaN"),
    "other spellings": TABLE.replace("motor_a", "motor1").replace("sensor_a", "sensor.a"),
    "indices in brackets": TABLE.replace("sensor_a", "sensor[0]").replace("sensor_b", "sensor[1]"),
    "infinite last motor": TABLE.replace("2,0.1", "2,inf"),
}


@pytest.mark.parametrize("case", WRITTEN)
def test_all_of_these_say_the_same(read, case):
    means_the_same(read(WRITTEN[case]))


@pytest.mark.parametrize("encoding", ["utf-8", "utf-8-sig", "utf-16", "latin-1"])
def test_encodings(read, encoding):
    means_the_same(read(TABLE.replace("\n", ",größe\n"), encoding=encoding))


@pytest.mark.parametrize("name", ["a.CSV", "a.txt", "a.tsv", "a.csv.gz", "a.dat", "a"])
def test_names(read, name):
    means_the_same(read(TABLE, name=name))


def test_notes_say_what_was_left_aside(read):
    notes = read("# x\n" + WRITTEN["a row of units"].replace("\n", ",frame\n")).notes
    assert "line 3 holds units (s, m/s, m, -)" in notes
    assert any("columns that are not read" in note for note in notes)


def test_dates_become_seconds(read):
    text = TABLE.replace("\n0,", "\n2024-02-29T23:59:59.5Z,").replace(
        "\n1,", "\n2024-03-01 00:00:00.5+00:00,"
    )
    recording = read(text.replace("\n2,", "\n2024-03-01T02:00:01.5+02:00,"))
    assert np.diff(recording.time).tolist() == [1, 1]
    assert recording.time[0] == 1709251199.5


@pytest.mark.parametrize(("unit", "factor"), [("ms", 1e3), ("us", 1e6), ("ns", 1e9)])
def test_the_unit_of_time_is_an_option(read, unit, factor):
    rows = "".join(f"{factor * step:.0f},0.5,{step}\n" for step in range(4))
    recording = read(f"time,motor_a,sensor_a\n{rows}", time_unit=unit)
    assert recording.time.tolist() == [0, 1, 2, 3]


def test_missing_values_leave_out_the_transitions_that_need_them(read):
    rows = "".join(f"{step},0.5,{step}\n" for step in range(8))
    text = f"time,motor_a,sensor_a\n{rows}".replace("2,0.5", "2,").replace("5,0.5,5", "5,0.5,nan")
    recording = read(text)
    assert recording.usable.tolist() == [True, True, False, True, False, False, True]
    assert np.isfinite(recording.sensors).all() and np.isfinite(recording.increments).all()
    assert any("motor_a is missing in 1 rows (the first: " in note for note in recording.notes)
    with pytest.raises(UserError, match="line 4: motor_a is missing"):
        read(text, missing="refuse")


def test_infinite_readings_are_no_return(read):
    text = TABLE.replace("3,4", "inf,4")
    recording = read(text)
    assert recording.sensors[:, 0].tolist() == [1, 5, 5]
    assert (
        "1 readings are no return: their column's largest reading stands for them"
        in recording.notes
    )
    assert read(text, max_range=4.5).sensors[:, 0].tolist() == [1, 4.5, 4.5]
    assert read(TABLE.replace("3,4", "-inf,4")).usable.tolist() == [False, False]


def test_poses_are_optional_and_need_all_three(read):
    posed = TABLE.replace("sensor_b\n", "sensor_b,x,y,Theta\n").replace("2\n", "2,0,0,0\n")
    posed = posed.replace(",4\n", ",4,3,4,1\n").replace("-6\n", "-6,3,,1\n")
    recording = read(posed)
    assert recording.poses[1].tolist() == [3, 4, 1, 0]
    assert np.isnan(recording.poses[2, :3]).all()
    assert "the true pose is unknown in 1 rows" in recording.notes
    partly = read(
        TABLE.replace("_b\n", "_b,x\n")
        .replace("2\n", "2,1\n")
        .replace("4\n", "4,1\n")
        .replace("6\n", "6,1\n")
    )
    assert "a pose needs x, y, theta; the table has x alone" in partly.notes
    degrees = read(posed.replace("4,1\n", "4,180\n"))
    assert any("in radians" in note for note in degrees.notes)


def test_description_gives_the_median_step(read):
    rows = "0,0,1,0,0,0\n1,0,1,3,4,0\n2,0,1,3,5,0\n3,0,1,3,7,0\n"
    described = describe(read(f"time,motor_a,sensor_a,x,y,theta\n{rows}"))
    assert described["step between scans (median)"] == 2.0
    assert described["path length"] == 8.0


BROKEN = {
    "no motors": ("time,sensor_a\n0,1\n1,2\n", "at least one motor_*"),
    "no names": ("0,1,2\n1,2,3\n", "the columns are 0, 1, 2; a table needs time"),
    "too few values": (
        TABLE.replace("1,0.25,3,4", "1,3"),
        "line 3: 2 values for 4 columns; complete",
    ),
    "too many values": (
        comma(TABLE).replace(";", ","),
        "line 2: 5 values for 4 columns; if its numbers have decimal commas, put semicolons",
    ),
    "text": (
        TABLE.replace("0.25", "fast"),
        "line 3: 'fast' is not a number (column motor_a); corr",
    ),
    "text in a sensor": (
        TABLE.replace("3,4", "3,base"),
        "line 3: 'base' is not a number (column s",
    ),
    "two decimal signs": (
        comma(TABLE).replace("0,25", "0.25"),
        "the decimal sign is not clear: there are 0,5 and 0.25; set decimal to comma or point",
    ),
    "a sensor of nothing": (
        TABLE.replace(",2\n", ",\n").replace(",4\n", ",\n").replace(",-6", ","),
        "sensor_b holds no number",
    ),
    "one row": ("time,motor_a,sensor_a\n0,1,1\n", "the table holds 1 rows"),
    "empty": ("", "the file is empty"),
    "columns of one name": ("time,motor_a,Motor_A,sensor_a\n0,1,5,1\n1,2,6,2\n", "named motor_a"),
    "too large": (TABLE.replace("0.25", "1e39"), "line 3: motor_a is 1e+39, too large for 32-bit"),
    "too large a sensor": (TABLE.replace("3,4", "3,-1e300"), "line 3: sensor_b is -1e+300, too"),
    "endless quotes": (TABLE.replace("0.25", '"0.25'), "line 4: the row cannot be split"),
}


@pytest.mark.parametrize("case", BROKEN)
def test_broken_tables_are_one_sentence(read, tmp_path, case):
    text, message = BROKEN[case]
    with pytest.raises(UserError) as error:
        read(text)
    assert message in str(error.value)
    assert str(tmp_path) in str(error.value)


def test_lines_are_still_numbered_after_a_blank_one(read):
    with pytest.raises(UserError, match="line 5: 'fast' is not a number"):
        read(
            "time,motor_a,sensor_a\n\n0,0.5,1\n1,0.25,3\n2,fast,4\n3,1,1\n".replace(
                "0.25,3\n2", "0.25,3\n2"
            )
        )


def test_a_last_line_cut_off_is_left_out(read):
    recording = read(TABLE + "3,0.")
    means_the_same(recording)
    assert "line 5, the last one, is cut off: left out" in recording.notes


def test_a_decimal_sign_can_be_named(read):
    text = "time;motor_a;sensor_a\n0;1.5;1\n1;1,5;2\n2;0;3\n"
    for decimal, wrong in (("comma", "1.5"), ("point", "1,5")):
        with pytest.raises(UserError, match=f"'{wrong}' is not a number"):
            read(text, decimal=decimal)
    grouped = text.replace("1.5", "1.500").replace("1,5", "1.500,5")
    assert read(grouped, decimal="comma").increments.ravel().tolist() == [1500, 1500.5]
    grouped = text.replace("1,5", "1,500.5").replace("0;1.5", "0;1,500")
    assert read(grouped, decimal="point").increments.ravel().tolist() == [1500, 1500.5]


pyarrow = pytest.importorskip("pyarrow")


@pytest.fixture
def read_parquet(tmp_path):
    """A function from columns to the recording of their Parquet file."""
    parquet = pytest.importorskip("pyarrow.parquet")

    def reading(columns, name="robot.parquet", **options):
        parquet.write_table(pyarrow.table(columns), tmp_path / name)
        return read_log(tmp_path / name, **options)

    return reading


COLUMNS = {
    "time": [0.0, 1.0, 2.0],
    "motor_a": [0.5, 0.25, 0.1],
    "sensor_a": [1, 3, 5],
    "sensor_b": [2.0, 4.0, -6.0],
}


@pytest.mark.parametrize("name", ["robot.parquet", "robot.PQ", "robot"])
def test_parquet_says_the_same(read_parquet, name):
    means_the_same(read_parquet(COLUMNS, name))


def test_parquet_with_columns_beside(read_parquet):
    recording = read_parquet(COLUMNS | {"frame": ["a", "b", None], "__index_level_0__": [4, 5, 6]})
    means_the_same(recording)
    assert "columns that are not read: frame, __index_level_0__" in recording.notes


@pytest.mark.parametrize("unit", ["s", "ms", "us", "ns"])
@pytest.mark.parametrize("zone", [None, "Europe/Zurich"])
def test_parquet_time_stamps_have_a_unit_and_a_zone(read_parquet, unit, zone):
    per_second = {"s": 1, "ms": 10**3, "us": 10**6, "ns": 10**9}[unit]
    stamps = [1_700_000_000 * per_second + step * per_second for step in range(3)]
    time = pyarrow.array(stamps, pyarrow.timestamp(unit, zone))
    recording = read_parquet(COLUMNS | {"time": time}, time_unit="ms")
    assert recording.time.tolist() == [1.7e9, 1.7e9 + 1, 1.7e9 + 2]
    unit = "ms" if unit == "s" else unit  # Parquet has no seconds
    assert f"time is in {unit}" + (f", zone {zone}" if zone else "") in recording.notes


def test_parquet_lists_become_a_column_for_each_value(read_parquet):
    columns = {name: COLUMNS[name] for name in ("time", "motor_a")}
    means_the_same(read_parquet(columns | {"sensor_ranges": [[1, 2], [3, 4], [5, -6]]}))
    missing = read_parquet(columns | {"sensors": [[1.0, 2.0], None, [5.0, -6.0]]})
    assert missing.usable.tolist() == [False, False]
    for ragged in ([[1.0], [1.0, 2.0], [1.0]], [["a"], ["b"], ["c"]]):
        with pytest.raises(UserError, match="column sensors"):
            read_parquet(columns | {"sensors": ragged})


def test_parquet_gaps_text_and_other_types(read_parquet):
    assert read_parquet(COLUMNS | {"motor_a": [None, 0.25, 0.1]}).usable.tolist() == [False, True]
    assert read_parquet(COLUMNS | {"motor_a": [0.5, 0.25, None]}).usable.all()
    means_the_same(read_parquet(COLUMNS | {"motor_a": ["0.5", "0.25", "0.1"]}))
    words = pyarrow.array(["0.5", "0.25", "x"]).dictionary_encode()
    with pytest.raises(UserError, match="column motor_a, row 2: 'x' is not a number"):
        read_parquet(COLUMNS | {"motor_a": words})
    bumper = read_parquet(COLUMNS | {"sensor_b": [True, False, True]})
    assert bumper.sensors[:, 1].tolist() == [1, 0, 1]
    dates = read_parquet(COLUMNS | {"time": ["2024-01-01", "2024-01-02", "2024-01-03"]})
    assert np.diff(dates.time).tolist() == [86400, 86400]


def test_damaged_parquet_is_one_sentence(tmp_path):
    path = tmp_path / "robot.parquet"
    path.write_bytes(b"PAR1 and nothing else")
    with pytest.raises(UserError, match=r"robot\.parquet: the Parquet file cannot be read"):
        read_log(path)
