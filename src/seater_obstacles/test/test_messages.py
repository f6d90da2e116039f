"""Between ROS messages and arrays, whatever the driver packs beside them."""

import struct
from typing import Any

import numpy as np
import pytest
import rospy
from sensor_msgs.msg import CameraInfo, Image, LaserScan, PointCloud2, PointField
from std_msgs.msg import Header

from seater_obstacles.finder import Found
from seater_obstacles.ros import messages
from seater_obstacles.ros.sources import Source
from seater_obstacles.settings import SenseSettings

DEPTH = np.array([[1.0, 2.0, 3.0], [4.0, 5.0, 6.0]])


def image(encoding: str, kind: str, big: bool = False, pad: int = 0) -> Image:
    order = ">" if big else "<"
    rows = [row.astype(order + kind).tobytes() + bytes(pad) for row in DEPTH]
    return Image(height=2, width=3, encoding=encoding, is_bigendian=big, step=len(rows[0]), data=b"".join(rows))


@pytest.mark.parametrize(("big", "pad"), [(False, 0), (True, 0), (False, 5), (True, 3)])
@pytest.mark.parametrize(("encoding", "kind"), [("32FC1", "f4"), ("16UC1", "u2"), ("mono16", "u2")])
def test_depth_images_of_every_layout(encoding: str, kind: str, big: bool, pad: int) -> None:
    pixels = messages.depth_pixels(image(encoding, kind, big, pad))
    assert pixels.dtype == np.dtype(kind) and np.array_equal(pixels, DEPTH)


def test_other_or_cut_depth_images_are_refused() -> None:
    with pytest.raises(ValueError, match="encoding is 'rgb8'"):
        messages.depth_pixels(Image(encoding="rgb8"))
    cut = image("32FC1", "f4")
    cut.data = cut.data[:-1]
    with pytest.raises(ValueError, match="fewer data"):
        messages.depth_pixels(cut)


def calibration(width: int, height: int) -> CameraInfo:
    return CameraInfo(width=width, height=height, K=[2.0, 0.0, 1.0, 0.0, 2.0, 0.5, 0.0, 0.0, 1.0])


def test_a_calibration_of_another_size_than_the_depth_image_is_refused() -> None:
    source = Source("depth", SenseSettings(stride=1), 1)
    for size in ((3, 2), (0, 0)):
        source._on_info(calibration(*size))
        assert source.sight(image("32FC1", "f4"), np.eye(4)).met == 6
    source._on_info(calibration(6, 4))
    with pytest.raises(ValueError, match="is 3 x 2, its camera_info of 6 x 4 pixels"):
        source.sight(image("32FC1", "f4"), np.eye(4))


def test_what_a_sensor_measured_is_the_same_whatever_its_stamp() -> None:
    source = Source("scan", SenseSettings(), 1)
    one, other = LaserScan(ranges=[1.0, np.nan]), LaserScan(ranges=[1.0, np.nan])
    other.header.stamp.secs = 7
    assert source.measured(one) == source.measured(other) != source.measured(LaserScan(ranges=[1.0, 2.0]))


def test_measurements_of_two_sensors_in_turns_are_refused(monkeypatch: pytest.MonkeyPatch) -> None:
    """One sees somebody, the other does not."""
    callbacks: list[Any] = []
    monkeypatch.setattr(rospy, "Subscriber", lambda *words, **_: callbacks.append(words[2]))
    source, taken = Source("scan", SenseSettings(), 1), []
    source.subscribe(taken.append)
    message = LaserScan(ranges=[1.0], angle_increment=0.1, range_max=10.0)
    for sender in ("/front", "/front", "/another"):
        message._connection_header = {"callerid": sender}
        callbacks[0](message)
        assert source.sight(message, np.eye(4)).met == 1
    message._connection_header = {"callerid": "/front"}
    callbacks[0](message)
    assert len(taken) == 4
    with pytest.raises(ValueError, match="2 nodes publish /scan in turns, /another and /front"):
        source.sight(message, np.eye(4))


def cloud(big: bool = False) -> PointCloud2:
    """x and z in an order of their own, an intensity between, two rows with a gap after each."""
    order = ">" if big else "<"
    fields = [
        PointField("z", 0, PointField.FLOAT32, 1),
        PointField("intensity", 4, PointField.UINT8, 1),
        PointField("x", 8, PointField.FLOAT64, 1),
        PointField("y", 16, PointField.FLOAT32, 1),
    ]
    rows = [
        b"".join(struct.pack(order + "fB3xdf", z, 7, x, y) for x, y, z in row) + bytes(3)
        for row in (((1, 2, 3), (4, 5, 6)), ((7, 8, 9), (np.nan, 0, 0)))
    ]
    return PointCloud2(
        height=2, width=2, fields=fields, is_bigendian=big, point_step=20, row_step=len(rows[0]), data=b"".join(rows)
    )


@pytest.mark.parametrize("big", [False, True])
def test_clouds_of_every_layout(big: bool) -> None:
    points = messages.cloud_points(cloud(big))
    assert points[:3].tolist() == [[1.0, 2.0, 3.0], [4.0, 5.0, 6.0], [7.0, 8.0, 9.0]] and np.isnan(points[3, 0])


def test_clouds_without_coordinates_or_data_are_refused() -> None:
    lacking = cloud()
    lacking.fields = lacking.fields[:3]
    with pytest.raises(ValueError, match="no float field y"):
        messages.cloud_points(lacking)
    cut = cloud()
    cut.data = cut.data[:-1]
    with pytest.raises(ValueError, match="fewer data"):
        messages.cloud_points(cut)


def test_controller_and_gate_are_told_the_same_in_their_frames() -> None:
    outline = np.array([[0.0, 0.0], [1.0, 0.0], [0.0, 1.0]])
    found = Found(outlines=[outline], points=np.array([[1.5, -0.5]]), moving=0, remembered=0, blind=0.3)
    header = Header(frame_id="laser")
    header.stamp.secs = 7
    for_controller = messages.obstacles(header, found, "odom")
    assert for_controller.header.frame_id == "odom" and for_controller.header.stamp.secs == 7
    assert [(p.x, p.y) for p in for_controller.polygons[0].points] == [(0.0, 0.0), (1.0, 0.0), (0.0, 1.0)]
    for_gate = messages.points(header, "scan", "base_link", found)
    assert (for_gate.header.frame_id, for_gate.source, for_gate.x, for_gate.y) == ("base_link", "scan", [1.5], [-0.5])
    assert messages.blocked(header, "scan", "base_link", "why").blocked == "why"
