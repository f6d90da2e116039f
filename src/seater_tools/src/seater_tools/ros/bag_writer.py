"""A bag as record.launch writes it, from a simulation without ROS."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from types import TracebackType
from typing import Any

import cv2
import numpy as np
import rosbag
from geometry_msgs.msg import Point, PoseWithCovariance, PoseWithCovarianceStamped, Quaternion, Twist
from numpy.typing import NDArray
from sensor_msgs.msg import CameraInfo

import seater_perception as sp
from seater_common.camera_model import CameraModel
from seater_common.geometry import quaternion_of
from seater_common.messages import camera_info_of
from seater_msgs.msg import DockObservation, MarkerDetection, MarkerDetectionArray
from seater_sim.chair.interface import OdometrySample
from seater_sim.ros.messages import OPTICAL_FRAME, odometry_message, stamp

Array = NDArray[np.float64]


class BagWriter:
    """A context manager; `now`: [ns] when a message arrives."""

    def __init__(self, path: Path) -> None:
        path.parent.mkdir(parents=True, exist_ok=True)
        self._bag = rosbag.Bag(str(path), "w")

    def __enter__(self) -> BagWriter:
        return self

    def __exit__(self, kind: type | None, error: BaseException | None, trace: TracebackType | None) -> None:
        self._bag.close()

    def odometry(self, now: int, sample: OdometrySample) -> None:
        self._bag.write("odom", odometry_message(sample), stamp(now))

    def command(self, now: int, v: float, omega: float) -> None:
        message = Twist()
        message.linear.x, message.angular.z = v, omega
        self._bag.write("cmd_vel", message, stamp(now))

    def camera_info(self, now: int, lens: CameraModel) -> None:
        """What the camera's driver has been told."""
        message = CameraInfo(**camera_info_of(lens))
        message.header.stamp, message.header.frame_id = stamp(now), OPTICAL_FRAME
        self._bag.write("camera/color/camera_info", message, stamp(now))

    def detections(self, now: int, stamp_ns: int, found: sp.DetectionResult) -> None:
        """As the nodelet publishes them: `detections`, and `dock_pose` where the dock is seen."""
        message = MarkerDetectionArray()
        message.header.stamp, message.header.frame_id = stamp(stamp_ns), OPTICAL_FRAME
        message.markers = [_marker(marker) for marker in found.markers]
        message.dock = [DockObservation(_pose(d.pose, d.covariance), d.weight, d.marker_ids) for d in found.dock]
        self._bag.write("detections", message, stamp(now))
        if message.dock:
            pose = _pose(found.dock[0].pose, mixture_covariance(found.dock))  # this topic knows no other hypotheses
            self._bag.write("dock_pose", PoseWithCovarianceStamped(message.header, pose), stamp(now))


def mixture_covariance(hypotheses: Sequence[Any]) -> Array:
    """(6, 6) about the first pose: second moment of all by their weights, as seater_perception::mixtureCovariance."""
    first, total = hypotheses[0].pose, np.zeros((6, 6))
    for h in hypotheses:
        turn = cv2.Rodrigues(h.pose[:3, :3] @ first[:3, :3].T)[0].ravel()
        off = np.concatenate([h.pose[:3, 3] - first[:3, 3], turn])
        total += h.weight * (h.covariance + np.outer(off, off))
    return total / sum(h.weight for h in hypotheses)


def _marker(marker: Any) -> MarkerDetection:
    best = marker.hypotheses[0]
    message = MarkerDetection(id=marker.id, size=marker.size, ambiguity=marker.ambiguity)
    message.corners = [Point(float(x), float(y), 0.0) for x, y in np.reshape(marker.corners, (4, 2))]
    message.pose = _pose(best.pose, marker.covariance)
    message.reprojection_error = best.error
    return message


def _pose(T: Array, covariance: Array) -> PoseWithCovariance:
    message = PoseWithCovariance(covariance=np.ravel(covariance).tolist())
    message.pose.position = Point(*map(float, T[:3, 3]))
    message.pose.orientation = Quaternion(*quaternion_of(T[:3, :3]))
    return message
