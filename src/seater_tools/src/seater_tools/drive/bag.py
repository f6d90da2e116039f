"""A drive from a bag: odometry, camera_info, and the markers that perception has seen."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from seater_common.bags import BagFile, open_bag
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
    with open_bag(path, DriveError) as bag:
        if camera is None:
            camera = _camera(bag, path, topics)
        wanted = {topics.detections: take_detections, topics.odometry: take_odometry}
        bag.require(wanted)
        gatherer = Gatherer(camera)
        for topic, message, _ in bag.messages(wanted):
            wanted[topic](gatherer, message)
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


def _camera(bag: BagFile, path: Path, topics: Topics) -> CameraModel:
    topic = topics.camera_info
    _, message, _ = next(bag.messages([topic]), (None, None, None))
    if message is None:
        raise DriveError(f"{path}: has no messages on {topic}; name the topic, or give the calibration")
    try:
        return camera_of(message)
    except ParameterError as error:
        raise DriveError(f"{path}: {topic}: {error}") from error
