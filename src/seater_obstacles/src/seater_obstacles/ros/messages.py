"""Between the core and ROS messages."""

from __future__ import annotations

import numpy as np
from geometry_msgs.msg import Point32, Polygon
from numpy.typing import NDArray
from sensor_msgs.msg import Image, PointCloud2, PointField
from std_msgs.msg import Header

from seater_msgs.msg import ObstacleArray, ObstaclePoints
from seater_obstacles.finder import Found

Array = NDArray[np.float64]

_PIXELS = {"32FC1": np.float32, "16UC1": np.uint16, "mono16": np.uint16}
_NUMBERS = {PointField.FLOAT32: "f4", PointField.FLOAT64: "f8"}


def depth_pixels(message: Image) -> NDArray[np.generic]:
    """(height, width) of a depth image.

    Raises:
        ValueError: another encoding, or fewer data than height and step say.
    """
    if message.encoding not in _PIXELS:
        raise ValueError(f"depth image: encoding is {message.encoding!r}, must be 32FC1 or 16UC1")
    kind = np.dtype(_PIXELS[message.encoding])
    if len(message.data) < message.height * message.step or message.step < message.width * kind.itemsize:
        raise ValueError("depth image: has fewer data than its height, width and step say")
    rows = np.frombuffer(message.data, np.uint8, message.height * message.step).reshape(message.height, -1)
    packed = np.ascontiguousarray(rows[:, : message.width * kind.itemsize])
    return packed.view(kind.newbyteorder(">" if message.is_bigendian else "<")).astype(kind)


def cloud_points(message: PointCloud2) -> Array:
    """(n, 3) [m] of a cloud with the fields x, y and z.

    Raises:
        ValueError: a field is missing or no float, or there are fewer data than its size says.
    """
    fields = {field.name: field for field in message.fields}
    lacking = [name for name in "xyz" if name not in fields or fields[name].datatype not in _NUMBERS]
    if lacking:
        raise ValueError(f"cloud: has no float field {', '.join(lacking)}")
    if len(message.data) < message.height * message.row_step or message.row_step < message.width * message.point_step:
        raise ValueError("cloud: has fewer data than its height, width and step say")
    order = ">" if message.is_bigendian else "<"
    kind = np.dtype(
        {
            "names": list("xyz"),
            "formats": [order + _NUMBERS[fields[name].datatype] for name in "xyz"],
            "offsets": [fields[name].offset for name in "xyz"],
            "itemsize": message.point_step,
        }
    )
    rows = np.frombuffer(message.data, np.uint8, message.height * message.row_step).reshape(message.height, -1)
    packed = np.ascontiguousarray(rows[:, : message.width * message.point_step]).reshape(-1)
    points = packed.view(kind)
    return np.column_stack([points[name] for name in "xyz"]).astype(float)


def obstacles(header: Header, found: Found, odom_frame: str) -> ObstacleArray:
    """For the controller."""
    message = ObstacleArray()
    message.header.stamp, message.header.frame_id = header.stamp, odom_frame
    message.polygons = [Polygon([Point32(x, y, 0.0) for x, y in outline.tolist()]) for outline in found.outlines]
    return message


def points(header: Header, source: str, base_frame: str, found: Found) -> ObstaclePoints:
    """For the safety gate."""
    message = _about(header, source, base_frame)
    message.x, message.y = found.points[:, 0].tolist(), found.points[:, 1].tolist()
    return message


def blocked(header: Header, source: str, base_frame: str, reason: str) -> ObstaclePoints:
    """For the safety gate: the chair has to stop."""
    message = _about(header, source, base_frame)
    message.blocked = reason
    return message


def _about(header: Header, source: str, base_frame: str) -> ObstaclePoints:
    message = ObstaclePoints(source=source)
    message.header.stamp, message.header.frame_id = header.stamp, base_frame
    return message
