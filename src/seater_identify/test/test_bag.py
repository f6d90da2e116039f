"""A bag gives the recording that was put into it."""

from __future__ import annotations

import math
import runpy
import sys
from pathlib import Path
from unittest import mock

import numpy as np
import pytest

from seater_common.files.installation import SHIPPED, Installation
from seater_common.geometry import Chair
from seater_identify.record.bag import Topics, read_bag
from seater_identify.record.recording import RecordingError

rosbag = pytest.importorskip("rosbag")

NODES = Path(__file__).resolve().parents[1] / "nodes"


def write(path: Path, odometry: bool = True) -> None:
    import rospy
    from geometry_msgs.msg import PoseWithCovarianceStamped, Twist
    from nav_msgs.msg import Odometry

    with rosbag.Bag(str(path), "w") as bag:
        for i in range(40):
            now = rospy.Time.from_sec(10.0 + 0.05 * i)
            command = Twist()
            command.linear.x, command.angular.z = 0.01 * i, -0.02 * i
            bag.write("/cmd_vel", command, now)
            if odometry:
                message = Odometry()
                message.header.stamp = now - rospy.Duration(0.01)
                message.pose.pose.position.x = 0.1 * i
                message.pose.pose.orientation.z, message.pose.pose.orientation.w = math.sin(0.1), math.cos(0.1)
                bag.write("/odom", message, now)
            dock = PoseWithCovarianceStamped()
            dock.header.stamp = now
            dock.pose.pose.position.z = 2.0  # ahead of the camera
            # Optical axes x right, y down, z forward; a dock that faces as the chair does.
            q = (0.5, -0.5, 0.5, 0.5)
            o = dock.pose.pose.orientation
            o.x, o.y, o.z, o.w = q
            dock.pose.covariance = np.diag([4e-6, 1.0, 9e-6, 1.0, 2.5e-5, 1.0]).ravel().tolist()
            bag.write("/dock_pose", dock, now)


def test_a_bag_is_read(tmp_path: Path) -> None:
    write(tmp_path / "a.bag")
    recording = read_bag(tmp_path / "a.bag", Chair(), Topics())
    assert recording.commands[3] == pytest.approx([10.15, 0.03, -0.06])
    assert recording.odometry[3] == pytest.approx([10.14, 0.3, 0.0, 0.2])
    # The camera is 0.45 m ahead of the axle; its z axis is the chair's x axis, its x axis the chair's -y.
    assert recording.dock[0, 1:3] == pytest.approx([2.45, 0.0], abs=1e-9)
    assert np.diag(recording.dock_covariance[0]) == pytest.approx([9e-6, 4e-6, 2.5e-5])


def test_a_bag_without_odometry_is_refused(tmp_path: Path) -> None:
    write(tmp_path / "b.bag", odometry=False)
    with pytest.raises(RecordingError, match="has no messages on odom"):
        read_bag(tmp_path / "b.bag", Chair(), Topics())


def test_a_file_that_is_no_bag_is_refused(tmp_path: Path) -> None:
    (tmp_path / "c.bag").write_text("no bag")
    with pytest.raises(RecordingError, match="cannot read"):
        read_bag(tmp_path / "c.bag", Chair(), Topics())


def test_the_command_replaces_the_files_of_an_installation(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """By a recording, never by a simulated drive."""
    write(tmp_path / "a.bag")
    config, here = NODES.parents[2] / "config", tmp_path / "here"
    Installation(here).create({role: config / name for role, name in SHIPPED.items()})
    assert identify("--installation", here) == 2
    assert "--installation: needs --bag" in capsys.readouterr().err
    assert not list(here.glob("*.yaml.2*"))
    assert identify("--installation", here, "--bag", tmp_path / "a.bag") == 0
    assert "controller.yaml is new; the one before is kept" in capsys.readouterr().out
    text = (here / "controller.yaml").read_text()
    assert text.startswith("# Identified: 20") and "a.bag; not shown, as before: " in text.partition("\n")[0]
    assert (here / "chair.yaml").read_text() == (here / "identify" / "chair.yaml").read_text()


def identify(*words: str | Path) -> object:
    """The exit status of the program, as a person types it."""
    with mock.patch.object(sys, "argv", ["identify", *map(str, words)]), pytest.raises(SystemExit) as end:
        runpy.run_path(str(NODES / "identify"), run_name="__main__")
    return end.value.code
