"""A drive from a bag, from a file, and what is refused."""

from __future__ import annotations

import dataclasses
from pathlib import Path

import cv2
import numpy as np
import pytest
from drive_by_hand import CAMERA, K, Truth, make_drive

from seater_tools.drive.bag import Topics, read_bag
from seater_tools.drive.drive import Drive, DriveError
from seater_tools.drive.gather import FLOOR, corner_covariance

rosbag = pytest.importorskip("rosbag")


def write_bag(path: Path, camera_info: bool = True, odometry: bool = True) -> None:
    """40 images and odometries, marker 3 of 0.2 m straight ahead at 1 m, the chair driving 0.1 m per message."""
    import rospy
    from geometry_msgs.msg import Point
    from nav_msgs.msg import Odometry
    from sensor_msgs.msg import CameraInfo

    from seater_msgs.msg import MarkerDetection, MarkerDetectionArray

    with rosbag.Bag(str(path), "w") as bag:
        for i in range(60):
            now = rospy.Time.from_sec(10.0 + 0.05 * i)
            seen, marker = MarkerDetectionArray(), MarkerDetection()
            seen.header.stamp = now
            marker.id, marker.size = 3, 0.2
            marker.corners = [Point(600.0 + x, 300.0 + y, 0.0) for x, y in ((0, 0), (9, 0), (9, 9), (0, 9))]
            marker.pose.pose.position.z = 1.0
            marker.pose.pose.orientation.x = 1.0  # the print faces the camera
            marker.pose.covariance = np.diag([1e-6, 1e-6, 4e-6, 1e-4, 1e-4, 1e-6]).ravel().tolist()
            seen.markers = [marker]
            bag.write("/detections", seen, now)
            if odometry:
                message = Odometry()
                message.header.stamp = now
                message.pose.pose.position.x = 0.1 * i
                message.pose.pose.orientation.z, message.pose.pose.orientation.w = np.sin(0.1), np.cos(0.1)
                bag.write("/odom", message, now)
            if camera_info:
                info = CameraInfo(
                    width=1280, height=720, distortion_model="plumb_bob", K=K.ravel().tolist(), D=[0.0] * 5
                )
                bag.write("/camera/color/camera_info", info, now)


def test_a_bag_is_read(tmp_path: Path) -> None:
    write_bag(tmp_path / "a.bag")
    drive, camera = read_bag(tmp_path / "a.bag", Topics(), None)
    assert pytest.approx(K) == camera.K
    assert len(drive.stamps) == 60 and set(drive.ids) == {3}
    assert drive.odometry[4] == pytest.approx([10.2, 0.4, 0.0, 0.2])
    assert drive.corners[0] == pytest.approx(np.array([[600, 300], [609, 300], [609, 309], [600, 309]]))
    # A pixel is 1 / 640 m at 1 m: 1e-3 m are 0.64 px; corners are 64 px off the middle.
    x = np.sqrt(drive.covariance[0][0, 0])
    assert x == pytest.approx(np.hypot(0.64, FLOOR), rel=0.05)


@pytest.mark.parametrize(
    ("missing", "problem"), [("camera_info", "camera_info; name the topic"), ("odometry", "no messages on odom")]
)
def test_a_bag_without_a_topic_is_refused(tmp_path: Path, missing: str, problem: str) -> None:
    write_bag(tmp_path / "b.bag", **{missing: False})
    with pytest.raises(DriveError, match=problem):
        read_bag(tmp_path / "b.bag", Topics(), None)


def test_what_is_no_bag_is_refused(tmp_path: Path) -> None:
    (tmp_path / "c.bag").write_text("no bag")
    with pytest.raises(DriveError, match="cannot read"):
        read_bag(tmp_path / "c.bag", Topics(), None)


def test_corners_are_as_uncertain_as_the_pose() -> None:
    """Against the corners of poses that scatter as the covariance says."""
    rng = np.random.default_rng(3)
    T = np.eye(4)
    T[:3, :3], T[:3, 3] = cv2.Rodrigues(np.array([2.9, 0.2, 0.1]))[0], [0.1, -0.05, 1.2]
    root = np.diag([1e-3, 1e-3, 3e-3, 0.01, 0.01, 2e-3]) @ (np.eye(6) + 0.3 * rng.standard_normal((6, 6)))
    square = 0.075 * np.array([[-1, 1, 0], [1, 1, 0], [1, -1, 0], [-1, -1, 0]])
    seen = []
    for d in rng.standard_normal((4000, 6)) @ root.T:
        points = square @ (cv2.Rodrigues(d[3:])[0] @ T[:3, :3]).T + T[:3, 3] + d[:3]
        seen.append(CAMERA.project(points).ravel())
    expected = np.cov(np.array(seen).T) + FLOOR**2 * np.eye(8)
    found = corner_covariance(CAMERA, 0.15, T, root @ root.T)
    assert np.abs(found - expected).max() < 0.08 * np.abs(expected).max()  # 4000 draws: 2 % of each, 4 sd


def test_a_file_gives_the_drive_back(tmp_path: Path) -> None:
    drive = make_drive(Truth())
    drive.save(tmp_path / "new" / "drive.npz")
    again = Drive.load(tmp_path / "new" / "drive.npz")
    for field in dataclasses.fields(Drive):
        assert np.array_equal(getattr(again, field.name), getattr(drive, field.name))
    (tmp_path / "x.npz").write_text("no drive")
    with pytest.raises(DriveError, match=r"cannot read .*x\.npz"):
        Drive.load(tmp_path / "x.npz")


@pytest.mark.parametrize(
    ("change", "problem"),
    [
        ({"odometry": np.zeros((3, 4))}, "odometry: 3 messages, at least 50"),
        ({"corners": np.zeros((3, 4, 2))}, "wrong shapes"),
        ({"stamps": np.arange(900.0, 1000.0)}, "0 images that show a marker within the odometry's time"),
    ],
)
def test_a_drive_that_is_too_little_is_refused(change: dict[str, np.ndarray], problem: str) -> None:
    with pytest.raises(DriveError, match=problem):
        dataclasses.replace(make_drive(Truth()), **change)


def test_numbers_that_are_not_finite_are_refused() -> None:
    drive = make_drive(Truth())
    corners = drive.corners.copy()
    corners[5, 2, 1] = np.nan
    with pytest.raises(DriveError, match="not finite"):
        dataclasses.replace(drive, corners=corners)
