"""ROS bags and MCAP files: good ones, odd ones and broken ones."""

import math
import random
import sqlite3

import numpy as np
import pytest

from motorspace import UserError
from motorspace._files import file_hash
from motorspace.recordings.catalog import reader_for
from motorspace.recordings.readers.base import read_log
from motorspace.recordings.readers.ros import RosReader
from motorspace.testing.reader import check_reader
from tests.recordings.bags import BEAMS, EXPECTED, START, Bag, bag_files, driving, place_at

pytest.importorskip("rosbags", reason="ROS bags need the extra ros")

KINDS = ("bag", "db3", "mcap")


@pytest.fixture
def write(tmp_path):
    """A function from a bag and its kind to the path of its file."""

    def writing(bag, kind="db3", name="robot"):
        if kind == "bag":
            return bag.write(tmp_path / f"{name}.bag")
        return bag.write(tmp_path / name, "mcap" if kind == "mcap" else "sqlite3")

    return writing


def version(kind):
    return 1 if kind == "bag" else 2


def moves_along_the_arc(recording, num=29):
    assert len(recording) == num
    assert recording.planar and recording.usable.all()
    moved = np.array([place_at(t - START) for t in recording.time])
    np.testing.assert_allclose(recording.poses[:, :2], moved[:, :2], atol=1e-3)
    turn = np.bincount(recording.interval, recording.increments[:, 2])
    np.testing.assert_allclose(turn, EXPECTED.turn, atol=1e-3)


@pytest.mark.parametrize("motion", ["odometry", "transforms", "commands"])
@pytest.mark.parametrize("kind", KINDS)
def test_every_kind_of_bag_and_of_motion(write, kind, motion):
    path = write(driving(version(kind), motion=motion), kind)
    assert reader_for(path) == "ros"
    recording = read_log(path)
    moves_along_the_arc(recording)
    np.testing.assert_allclose(recording.sensors[0], np.arange(1, BEAMS + 1), atol=0.01)
    assert recording.sensor_scale == (10.0,) * 9
    assert not any("skipped" in note for note in recording.notes)


@pytest.mark.parametrize("kind", KINDS)
def test_the_reader_passes_the_checks(write, kind):
    path = write(driving(version(kind)), kind)
    check_reader(RosReader(), path if path.is_file() else bag_files(path))


@pytest.mark.parametrize("kind", ["db3", "mcap"])
def test_a_folder_is_its_file(write, kind):
    folder = write(driving(), kind)
    whole, part = read_log(folder), read_log(bag_files(folder))
    np.testing.assert_array_equal(whole.sensors, part.sensors)
    before = file_hash(folder)
    bag_files(folder).rename(folder / f"other.{kind}")
    assert file_hash(folder) != before
    with pytest.raises(UserError, match="a file of the bag is missing"):
        read_log(folder)
    (folder / "metadata.yaml").unlink()
    moves_along_the_arc(read_log(folder))


def test_topics_are_chosen_by_name_where_there_are_several(write):
    bag = driving()
    for k in range(8):
        bag.scan(START + 0.1 * k, ranges=np.full(BEAMS, 2.0), topic="/rear")
    path = write(bag)
    with pytest.raises(UserError, match=r"LaserScan: /rear \(8\), /scan \(29\); choose one with"):
        read_log(path)
    assert (read_log(path, scan_topic="/rear").sensors == 2.0).all()
    moves_along_the_arc(read_log(path, scan_topic="/scan"))
    with pytest.raises(UserError, match="no messages of LaserScan in /odom; its topics are /odom"):
        read_log(path, scan_topic="/odom")


def test_what_a_bag_lacks_is_named_with_what_it_has(write):
    bag = Bag()
    bag.text(START)
    with pytest.raises(UserError, match=r"no laser scans \(LaserScan\).*/chatter \(String\)"):
        read_log(write(bag))
    bag.scan(START)
    with pytest.raises(UserError, match="no motion: no Odometry, no transforms of odom, no Twist"):
        read_log(write(bag, name="b"))
    bag.transform(START, "map", "robot", (0.0, 0.0, 0.0))
    with pytest.raises(UserError, match=r"no transform leads from odom.*there are map to robot"):
        read_log(write(bag, name="c"), motion_topic="/tf")
    found = read_log(write(driving(motion="commands", scans=6), name="d"))
    assert any("was asked to do, not what it did" in note for note in found.notes)


def test_a_robot_that_hears_nothing_stands_still(write):
    bag = driving(motion="", scans=30)
    bag.command(START, 0.5, 0.0)
    bag.command(START + 2.5, 0.0, 0.0)
    path = write(bag)
    assert read_log(path).increments[:, 0].sum() == pytest.approx(0.5 * 2.4, abs=0.01)
    stopped = read_log(path, command_timeout=1.0).increments[:, 0].sum()
    assert stopped == pytest.approx(0.5 * 0.97, abs=0.01)


def test_scans_outside_of_the_motion_and_pauses_of_it_are_left_out(write):
    bag = driving(scans=30)
    kept = [m for m in bag.written if m[1] != "/odom" or not 1.2e9 < m[0] - START * 1e9 < 2e9]
    bag.written = kept
    bag.scan(START + 9.0)
    found = read_log(write(bag))
    assert len(found) == 29
    assert any(
        note.startswith("1 of 30 scans are from before the first or") for note in found.notes
    )
    assert any("the odometry is missing 1 times, for up to" in note for note in found.notes)
    assert 8 <= (~found.usable).sum() <= 10


def test_a_full_turn_begins_behind_the_robot_however_the_laser_is_mounted(write):
    num = 36
    step = 2 * math.pi / num
    seen = {}
    for name, (yaw, roll) in {
        "a": (0.0, 0.0),
        "b": (math.pi / 2, 0.0),
        "c": (1.0, math.pi),
    }.items():
        bag = driving(scans=6, mounted=False, motion="odometry")
        bag.written = [m for m in bag.written if m[1] != "/scan"]
        bag.transform(START, "base_link", "laser", (0.0, 0.0, yaw), topic="/tf_static", roll=roll)
        # What stands at an angle from the robot's heading is that angle, plus 4, metres away.
        angles = np.arange(num) * step
        world = yaw + (-angles if roll else angles)
        ranges = 4 + (world + math.pi) % (2 * math.pi) - math.pi
        for k in range(5):
            bag.scan(
                START + 0.1 * k, ranges, angle_min=0.0, angle_max=angles[-1], angle_increment=step
            )
        seen[name] = read_log(write(bag, name=name), num_rays=5)
        expected = 4 + np.linspace(-math.pi / 2, math.pi / 2, 5)
        np.testing.assert_allclose(seen[name].sensors[0], expected, atol=step)
    assert any("turned by 90.0 degrees" in note for note in seen["b"].notes)
    assert any("upside down" in note for note in seen["c"].notes)


def test_a_laser_whose_beams_run_clockwise(write):
    bag = driving(scans=4, motion="odometry")
    bag.written = [m for m in bag.written if m[1] != "/scan"]
    for k in range(3):
        bag.scan(START + 0.1 * k, angle_min=math.pi / 2, angle_increment=-math.pi / (BEAMS - 1))
    assert read_log(write(bag)).sensors[0].tolist() == list(range(BEAMS, 0, -1))


def test_an_unknown_mount_is_said_and_can_be_given(write):
    path = write(driving(scans=5, mounted=False))
    assert any("taken to look ahead; set laser_yaw" in note for note in read_log(path).notes)
    assert not any("laser_yaw" in note for note in read_log(path, laser_yaw=0.0).notes)


def test_odd_readings(write):
    bag = driving(scans=4, motion="odometry")
    bag.written = [m for m in bag.written if m[1] != "/scan"]
    odd = [math.inf, math.nan, 0.0, 30.0, -1.0, 0.05, 9.0, 31.0, 2.0]
    bag.scan(START, odd)
    bag.scan(START + 0.1, [1.0, 2.0, 3.0])
    bag.scan(START + 0.2)
    found = read_log(write(bag))
    assert found.sensors[0].tolist() == [10, 10, 10, 10, 10, 10, 9, 10, 2]
    assert found.sensors[1].tolist() == [1, 1, 2, 2, 2, 2, 2, 3, 3]
    assert any("the number of beams varies" in note for note in found.notes)
    assert any("1 readings of /scan are below range_min" in note for note in found.notes)
    with pytest.raises(UserError, match="3 readings are invalid"):
        read_log(write(bag, name="b"), invalid="refuse")


def test_headers_that_run_back_give_way_to_the_bags_own_time(write):
    bag = Bag()
    for k in range(20):
        header = START + 0.1 * (k % 10)
        bag.odometry(header, (0.05 * k, 0.0, 0.0), bag_time=START + 0.1 * k)
        bag.scan(header, bag_time=START + 0.1 * k + 0.01)
    found = read_log(write(bag))
    assert any(note.startswith("time goes back by 0.9 s") for note in found.notes) is False
    bag.written = []
    for k in range(40):
        header = START + 0.1 * (k % 20)
        bag.odometry(header, (0.05 * k, 0.0, 0.0), bag_time=START + 0.1 * k)
        bag.scan(header, bag_time=START + 0.1 * k + 0.01)
    found = read_log(write(bag, name="b"))
    assert any(note.startswith("time goes back by 1.9 s after message 20") for note in found.notes)
    assert len(found) == 39 and found.usable.all()
    assert np.allclose(np.diff(found.time), 0.1)


def test_repeated_and_late_messages_are_counted(write):
    bag = driving(scans=10)
    odometry = [m for m in bag.written if m[1] == "/odom"]
    bag.written.insert(0, odometry[3])
    found = read_log(write(bag))
    assert any("1 messages of /odom repeat a time stamp" in note for note in found.notes)
    assert any("messages of /odom are out of order" in note for note in found.notes)


def test_true_poses_are_for_evaluation_alone(write):
    bag = driving()
    for k in range(60):
        x, y, angle = place_at(k / 20)
        bag.odometry(START + k / 20, (x + 3, y - 0.01 * k, angle), topic="/truth")
    path = write(bag)
    with pytest.raises(UserError, match=r"several topics of Odometry: /odom \(61\), /truth \(60\)"):
        read_log(path)
    found = read_log(path, motion_topic="/odom", truth_topic="/truth")
    plain = read_log(path, motion_topic="/odom")
    np.testing.assert_array_equal(found.increments, plain.increments)
    assert found.poses[0, 0] == pytest.approx(3 + plain.poses[0, 0], abs=1e-2)


# Broken bags


@pytest.mark.parametrize("kind", KINDS)
def test_a_cut_bag_is_one_sentence_or_read_up_to_there(write, kind):
    path = write(driving(version(kind), scans=400), kind)
    path = path if path.is_file() else bag_files(path)
    content = path.read_bytes()
    path = path.rename(path.parent.parent / f"cut{path.suffix}")
    path.write_bytes(content[: int(len(content) * 0.6)])
    with pytest.raises(
        UserError, match=r"(cut off or damaged|a chunk cannot be read).*skip_bad"
    ) as error:
        read_log(path)
    assert str(path) in str(error.value)
    found = read_log(path, skip_bad=True)
    assert 100 < len(found) < 399
    assert any(note.startswith("skipped 1 broken: ") for note in found.notes)


@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.parametrize("seed", range(12))
def test_noise_in_a_bag_never_ends_in_a_traceback(write, kind, seed):
    path = write(driving(version(kind), scans=20), kind)
    path = path if path.is_file() else bag_files(path)
    content = bytearray(path.read_bytes())
    shuffled = random.Random(seed)
    for _ in range(shuffled.choice([1, 8, 200])):
        content[shuffled.randrange(len(content))] = shuffled.randrange(256)
    if seed % 3 == 0:
        del content[shuffled.randrange(len(content)) :]
    path.write_bytes(bytes(content))
    for skip in (False, True):
        try:
            found = read_log(path, reader="ros", skip_bad=skip)
        except UserError as error:
            assert len(str(error)) < 900
        else:
            assert np.isfinite(found.sensors).all()


@pytest.mark.parametrize(
    "content",
    [b"#ROSBAG V2.0\n", b"SQLite format 3\0", b"\x89MCAP0\r\n"],
    ids=["bag", "sqlite", "mcap"],
)
@pytest.mark.parametrize("rest", [b"", b"\xff" * 5000, bytes(5000)], ids=["cut", "ones", "zeros"])
def test_sizes_that_a_file_claims_are_not_believed(tmp_path, content, rest):
    path = tmp_path / "robot.bag"
    path.write_bytes(content + rest)
    for skip in (False, True):
        with pytest.raises(UserError):
            read_log(path, skip_bad=skip)


def test_fewer_messages_than_the_metadata_count(write):
    folder = write(driving())
    with sqlite3.connect(bag_files(folder)) as connection:
        connection.execute("DELETE FROM messages WHERE id % 7 = 3")
    connection.close()
    with pytest.raises(UserError, match="topic /odom holds 53 of the 61 messages that the bag"):
        read_log(folder)
    found = read_log(folder, skip_bad=True)
    assert any("/scan holds" in note and note.startswith("skipped 1") for note in found.notes)


def test_broken_messages_are_named_or_counted(write):
    bag = driving(scans=20)
    scans = [i for i, m in enumerate(bag.written) if m[1] == "/scan"]
    for index in scans[3:6]:
        time, topic, message = bag.written[index]
        content = bytes(bag.store.serialize_cdr(message, bag.types[topic]))
        bag.written[index] = (time, topic, content[:40])
    path = bag_files(write(bag))
    with pytest.raises(UserError, match=r"message \d+: a LaserScan message cannot be read"):
        read_log(path)
    found = read_log(path, skip_bad=True)
    assert len(found) == 16
    assert any("skipped 3 broken: a LaserScan message" in note for note in found.notes)


@pytest.mark.parametrize(
    "text",
    ["", "[", "rosbag2_bagfile_information: 3", "rosbag2_bagfile_information: {a: &a [*a]}"],
)
def test_broken_metadata(write, text):
    folder = write(driving(scans=4))
    (folder / "metadata.yaml").write_text(text)
    with pytest.raises(UserError, match=r"metadata|the file is empty"):
        read_log(folder, reader="ros")


def test_metadata_name_files_of_their_folder_alone(write, tmp_path):
    folder = write(driving(scans=4))
    secret = tmp_path / "secret.db3"
    secret.write_bytes(b"SQLite format 3\0")
    path = folder / "metadata.yaml"
    path.write_text(path.read_text().replace(bag_files(folder).name, "../secret.db3"))
    with pytest.raises(UserError, match=r"robot/secret\.db3: a file of the bag is missing"):
        read_log(folder)


def test_packed_bags(write, tmp_path):
    bz2 = driving(1)
    from rosbags.rosbag1 import Writer

    for name in ("BZ2", "LZ4"):
        path = tmp_path / f"{name}.bag"
        with_writer = Writer(path)
        with_writer.set_compression(Writer.CompressionFormat[name])
        with with_writer as writer:
            bz2._write(writer, bz2.store.serialize_ros1)
        moves_along_the_arc(read_log(path))
    from rosbags.rosbag2 import CompressionFormat, CompressionMode
    from rosbags.rosbag2 import Writer as Writer2

    for mode in (CompressionMode.MESSAGE, CompressionMode.FILE):
        folder = tmp_path / mode.name
        packed = Writer2(folder, version=9)
        packed.set_compression(mode, CompressionFormat.ZSTD)
        bag = driving()
        with packed as writer:
            bag._write(writer, bag.store.serialize_cdr)
        if mode is CompressionMode.MESSAGE:
            moves_along_the_arc(read_log(folder))
        else:
            with pytest.raises(UserError, match="the file is packed; unpack it with: zstd -d"):
                read_log(folder)
