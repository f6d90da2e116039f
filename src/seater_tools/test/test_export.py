"""Bags as CSV."""

from __future__ import annotations

import csv
import math
from pathlib import Path

import pytest
from as_typed import run

rosbag = pytest.importorskip("rosbag")
import rospy  # noqa: E402
from nav_msgs.msg import Odometry  # noqa: E402
from sensor_msgs.msg import Image, LaserScan  # noqa: E402
from std_msgs.msg import Bool, Float64  # noqa: E402

from seater_msgs.msg import DockObservation, MarkerDetectionArray  # noqa: E402


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


def test_some_topics_only_and_nothing_is_overwritten(tmp_path: Path) -> None:
    path, folder = bag(tmp_path), tmp_path / "out"
    line = ["bag_to_csv", path, "--results", folder, "--topics", "/odom", "emergency_stop"]
    assert run(*line).returncode == 0
    assert sorted(file.name for file in folder.iterdir()) == ["emergency_stop.csv", "odom.csv"]
    again = run(*line)
    assert again.returncode == 2 and "--force" in again.stderr
    assert run(*line, "--force").returncode == 0


def test_wrong_input_is_said(tmp_path: Path) -> None:
    done = run("bag_to_csv", bag(tmp_path), "--topics", "odometry")
    assert done.returncode == 2 and "has no odometry; it has camera/image" in done.stderr
    (tmp_path / "no.bag").write_text("no bag")
    assert run("bag_to_csv", tmp_path / "no.bag").returncode == 2
    assert run("bag_to_csv", tmp_path / "nowhere.bag").returncode == 2
