"""Bags as CSV, Parquet and MCAP."""

from __future__ import annotations

import csv
import math
import sys
from pathlib import Path

import pytest
from as_typed import run

rosbag = pytest.importorskip("rosbag")
import rospy  # noqa: E402
from nav_msgs.msg import Odometry  # noqa: E402
from sensor_msgs.msg import Image, LaserScan  # noqa: E402
from std_msgs.msg import Bool, Float64  # noqa: E402

from seater_msgs.msg import DockObservation, MarkerDetectionArray  # noqa: E402
from seater_tools.command import export  # noqa: E402


def bag(folder: Path) -> Path:
    path = folder / "run.bag"
    with rosbag.Bag(str(path), "w") as out:
        for i in range(3):
            odometry = Odometry()
            odometry.header.stamp = rospy.Time(1700000000, 5 + i)
            odometry.header.frame_id = "odom, of\nwheels"
            odometry.twist.twist.linear.x = 0.1 * i
            odometry.pose.covariance[35] = 4.0
            out.write("/odom", odometry, rospy.Time(1700000001, i))
        out.write("emergency_stop", Bool(True), rospy.Time(5))
        out.write("lost", Float64(math.nan), rospy.Time(5))
        out.write("camera/image", Image(height=10, width=10, encoding="mono8", data=bytes(100)), rospy.Time(5))
        out.write("scan", LaserScan(ranges=[1.0] * 500), rospy.Time(5))
        for count in (0, 6):
            out.write("detections", MarkerDetectionArray(dock=[DockObservation() for _ in range(count)]), rospy.Time(6))
    return path


def rows(path: Path) -> list[dict[str, str]]:
    with path.open(newline="") as file:
        return list(csv.DictReader(file))


def test_a_file_for_each_topic_with_all_numbers_and_exact_times(tmp_path: Path) -> None:
    done = run("bag_to_csv", bag(tmp_path))
    assert done.returncode == 0, done.stderr
    folder = tmp_path / "run"
    odometry = rows(folder / "odom.csv")
    assert [row["__time"] for row in odometry] == [f"1700000001.{i:09d}" for i in range(3)]
    assert odometry[2]["header.stamp"] == "1700000000.000000007" and odometry[2]["twist.twist.linear.x"] == "0.2"
    assert odometry[0]["header.frame_id"] == "odom, of wheels" and odometry[0]["pose.covariance.35"] == "4.0"
    assert rows(folder / "emergency_stop.csv") == [{"__time": "5.000000000", "data": "1"}]
    assert math.isnan(float(rows(folder / "lost.csv")[0]["data"]))


def test_what_is_long_is_left_out_and_lists_are_cut(tmp_path: Path) -> None:
    run("bag_to_csv", bag(tmp_path))
    assert "ranges.0" not in rows(tmp_path / "run" / "scan.csv")[0]
    assert rows(tmp_path / "run" / "scan.csv")[0]["ranges.size"] == "500"
    assert max(len(name) for name in rows(tmp_path / "run" / "camera_image.csv")[0].values()) < 30
    none, six = rows(tmp_path / "run" / "detections.csv")
    assert (none["dock.size"], six["dock.size"]) == ("0", "6") and none["dock.0.weight"] == ""
    assert "dock.3.weight" in six and "dock.4.weight" not in six


def test_parquet_has_types_exact_times_whole_arrays_and_the_definition(tmp_path: Path) -> None:
    parquet = pytest.importorskip("pyarrow.parquet")
    done = run("bag_export", bag(tmp_path), "--format", "parquet")
    assert done.returncode == 0, done.stderr
    table = parquet.read_table(tmp_path / "run" / "odom.parquet")
    assert table.column("__time").cast("int64").to_pylist() == [1700000001 * 10**9 + i for i in range(3)]
    assert table.column("header.stamp").cast("int64").to_pylist() == [1700000000 * 10**9 + 5 + i for i in range(3)]
    assert table.column("twist.twist.linear.x").to_pylist() == [0.0, 0.1, 0.2]
    assert table.column("header.frame_id").to_pylist() == ["odom, of\nwheels"] * 3
    about = {key.decode(): value.decode() for key, value in table.schema.metadata.items()}
    assert (about["topic"], about["type"]) == ("/odom", "nav_msgs/Odometry")
    assert about["message_definition"] == Odometry._full_text
    folder = tmp_path / "run"
    assert parquet.read_table(folder / "scan.parquet").column("ranges").to_pylist() == [[1.0] * 500]
    assert parquet.read_table(folder / "camera_image.parquet").column("data").to_pylist() == [bytes(100)]
    assert parquet.read_table(folder / "detections.parquet").column("dock.0.weight").to_pylist() == [None, 0.0]


def test_mcap_holds_every_message_byte_for_byte_with_its_definition(tmp_path: Path) -> None:
    reader, decoder = pytest.importorskip("mcap.reader"), pytest.importorskip("mcap_ros1.decoder")
    path = bag(tmp_path)
    with rosbag.Bag(str(path), "a") as out:  # a second sender of the topic, that latches
        header = {"callerid": "/other", "latching": "1", "type": "std_msgs/Bool", "md5sum": Bool._md5sum}
        header["message_definition"] = Bool._full_text
        out.write("emergency_stop", Bool(False), rospy.Time(7), connection_header=header)
    done = run("bag_export", path, "--format", "mcap")
    assert done.returncode == 0, done.stderr
    with rosbag.Bag(str(path)) as out:
        expected = [
            (topic, kind, data, at.to_nsec(), pytype._full_text)
            for topic, (kind, data, _, _, pytype), at in out.read_messages(raw=True)
        ]
        values = [message for _, message, _ in out.read_messages()]
    with (tmp_path / "run.mcap").open("rb") as file:
        found = list(reader.make_reader(file).iter_messages())
    exact = [(c.topic, s.name, m.data, m.log_time, s.data.decode()) for s, c, m in found]
    assert sorted(exact) == sorted(expected)
    assert {(s.encoding, c.message_encoding) for s, c, _ in found} == {("ros1msg", "ros1")}
    latched = [c.metadata["callerid"] for _, c, m in found if c.metadata.get("latching") == "1"]
    assert latched == ["/other"]
    # Read by the library, without the message classes of ROS.
    with (tmp_path / "run.mcap").open("rb") as file:
        decoded = [
            (c.topic, m.log_time, ros)
            for _, c, m, ros in reader.make_reader(
                file, decoder_factories=[decoder.DecoderFactory()]
            ).iter_decoded_messages()
        ]
    assert len(decoded) == len(values)
    speeds = [ros.twist.twist.linear.x for topic, _, ros in decoded if topic == "/odom"]
    assert speeds == [0.0, 0.1, 0.2]


@pytest.mark.parametrize(("kind", "library"), [("parquet", "pyarrow"), ("mcap", "mcap.writer")])
def test_a_library_that_is_missing_is_named(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str], kind: str, library: str
) -> None:
    monkeypatch.setitem(sys.modules, library, None)
    assert export.main("bag_export", argv=[str(bag(tmp_path)), "--format", kind]) == 2
    assert "tools/requirements_export.txt" in capsys.readouterr().err
    assert [file.name for file in tmp_path.iterdir()] == ["run.bag"]


def test_some_topics_only_and_nothing_is_overwritten(tmp_path: Path) -> None:
    path, folder = bag(tmp_path), tmp_path / "out"
    line = ["bag_to_csv", path, "--results", folder, "--topics", "/odom", "emergency_stop"]
    assert run(*line).returncode == 0
    assert sorted(file.name for file in folder.iterdir()) == ["emergency_stop.csv", "odom.csv"]
    again = run(*line)
    assert again.returncode == 2 and "--force" in again.stderr
    assert export.main("bag_to_csv", "csv", [str(word) for word in (*line[1:], "--force")]) == 0


def test_wrong_input_is_said(tmp_path: Path) -> None:
    done = run("bag_to_csv", bag(tmp_path), "--topics", "odometry")
    assert done.returncode == 2 and "has no odometry; it has camera/image" in done.stderr
    (tmp_path / "no.bag").write_text("no bag")
    for name in ("no.bag", "nowhere.bag"):
        for kind in ("csv", "mcap"):
            assert export.main("bag_export", argv=[str(tmp_path / name), "--format", kind]) == 2
