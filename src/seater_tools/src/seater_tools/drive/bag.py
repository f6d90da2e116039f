"""A drive from a bag: odometry, camera_info, and the markers that perception has seen."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from seater_common.camera_model import CameraModel
from seater_common.geometry import planar_pose
from seater_common.messages import matrix_of_pose
from seater_common.params import ParameterError
from seater_tools.drive.drive import Drive, DriveError
from seater_tools.drive.gather import Gatherer

Array = NDArray[np.float64]


@dataclass(frozen=True)
class Topics:
    """Names in the bag, without a leading slash."""

    detections: str = "detections"  # seater_msgs/MarkerDetectionArray
    odometry: str = "odom"  # nav_msgs/Odometry
    camera_info: str = "camera/color/camera_info"  # sensor_msgs/CameraInfo, read when no calibration is given


def read_bag(path: Path, topics: Topics, camera: CameraModel | None) -> tuple[Drive, CameraModel]:
    """`camera`: None takes the first camera_info of the bag.

    Raises DriveError when the bag cannot be read, or holds too little; it names the topic.
    """
    import rosbag

    try:
        with rosbag.Bag(str(path)) as bag:
            known = {t.lstrip("/"): t for t in bag.get_type_and_topic_info().topics}
            if camera is None:
                camera = _camera(bag, known.get(topics.camera_info), path, topics)
            missing = [name for name in (topics.detections, topics.odometry) if name not in known]
            if missing:
                raise DriveError(f"{path}: has no messages on {' and '.join(missing)}")
            gatherer = Gatherer(camera)
            wanted = {known[topics.detections]: take_detections, known[topics.odometry]: take_odometry}
            for topic, message, _ in bag.read_messages(topics=list(wanted)):
                wanted[topic](gatherer, message)
    except (OSError, rosbag.ROSBagException) as error:
        raise DriveError(f"cannot read {path}: {error}") from error
    return gatherer.drive(), camera


def take_odometry(gatherer: Gatherer, message: Any) -> None:
    """A nav_msgs/Odometry."""
    gatherer.odometry(message.header.stamp.to_sec(), planar_pose(matrix_of_pose(message.pose.pose)))


def take_detections(gatherer: Gatherer, message: Any) -> None:
    """A seater_msgs/MarkerDetectionArray."""
    for marker in message.markers:
        corners = np.array([[corner.x, corner.y] for corner in marker.corners])
        covariance = np.reshape(np.array(marker.pose.covariance, dtype=float), (6, 6))
        T = matrix_of_pose(marker.pose.pose)
        gatherer.pose(message.header.stamp.to_sec(), marker.id, marker.size, corners, T, covariance)


def camera_of(message: Any) -> CameraModel:
    """Of a sensor_msgs/CameraInfo. Raises ParameterError: it is not calibrated."""
    values = {"image_width": message.width, "image_height": message.height}
    values["distortion_model"] = message.distortion_model
    for key, data in (("camera_matrix", message.K), ("distortion_coefficients", message.D)):
        values[key] = {"data": [float(value) for value in data]}
    return CameraModel.from_mapping(values, "camera_info")


def _camera(bag: Any, topic: str | None, path: Path, topics: Topics) -> CameraModel:
    if topic is None:
        raise DriveError(f"{path}: has no messages on {topics.camera_info}; name the topic, or give the calibration")
    _, message, _ = next(bag.read_messages(topics=[topic]))
    try:
        return camera_of(message)
    except ParameterError as error:
        raise DriveError(f"{path}: {topic}: {error}") from error
