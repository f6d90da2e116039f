"""A recording from a bag: of a docking, of a drive by joystick, of anything that commanded the chair."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from seater_common.bags import open_bag
from seater_common.geometry import Chair, planar_pose
from seater_common.messages import matrix_of_pose
from seater_identify.record.recording import Recording, RecordingError

Array = NDArray[np.float64]


@dataclass(frozen=True)
class Topics:
    """Names in the bag, without a leading slash."""

    command: str = "cmd_vel"  # geometry_msgs/Twist or TwistStamped, as the motors got it
    odometry: str = "odom"  # nav_msgs/Odometry
    dock: str = "dock_pose"  # geometry_msgs/PoseWithCovarianceStamped, in the camera's optical frame


def read_bag(path: Path, chair: Chair, topics: Topics) -> Recording:
    """Commands count from when they were recorded: they carry no time of their own, or that of the odometry they follow
    from. Odometry and images count from their stamps.

    Raises RecordingError when the bag cannot be read, or holds too few commands or too little odometry.
    """
    rows: dict[str, list[Any]] = {"command": [], "odometry": [], "dock": [], "covariance": []}
    names = {getattr(topics, kind).lstrip("/"): kind for kind in ("command", "odometry", "dock")}
    with open_bag(path, RecordingError) as bag:
        for topic, message, time in bag.messages(names):
            _take(names[topic], message, time.to_sec(), chair, rows)
    missing = [getattr(topics, kind) for kind in ("command", "odometry") if not rows[kind]]
    if missing:
        raise RecordingError(f"{path}: has no messages on {' and '.join(missing)}")
    return make_recording(rows)


def make_recording(rows: Mapping[str, list[Any]]) -> Recording:
    """Of lists of rows under the names command, odometry, dock, covariance. Raises RecordingError."""
    return Recording(
        np.array(rows["command"], dtype=float).reshape(-1, 3),
        np.array(rows["odometry"], dtype=float).reshape(-1, 4),
        np.array(rows["dock"], dtype=float).reshape(-1, 4),
        np.array(rows["covariance"], dtype=float).reshape(-1, 3, 3),
    )


def dock_row(stamp: float, T_optical_dock: Array, covariance: Array, chair: Chair) -> tuple[Array, Array]:
    """((4,) stamp and the dock in base_link, (3, 3) its covariance) from the pose in the optical frame, (4, 4), and its
    covariance (6, 6): position, rotation about the axes of that frame."""
    T_base_optical = chair.camera.T_base_optical()
    R = T_base_optical[:3, :3]
    rotation = np.zeros((6, 6))
    rotation[:3, :3] = rotation[3:, 3:] = R
    in_base = rotation @ covariance @ rotation.T
    return np.array([stamp, *planar_pose(T_base_optical @ T_optical_dock)]), in_base[np.ix_([0, 1, 5], [0, 1, 5])]


def _take(kind: str, message: Any, time: float, chair: Chair, rows: dict[str, list[Any]]) -> None:
    if kind == "command":
        twist = getattr(message, "twist", message)
        rows["command"].append([time, twist.linear.x, twist.angular.z])
    elif kind == "odometry":
        T = matrix_of_pose(message.pose.pose)
        rows["odometry"].append([message.header.stamp.to_sec(), *planar_pose(T)])
    else:
        covariance = np.reshape(np.array(message.pose.covariance, dtype=float), (6, 6))
        row, planar = dock_row(message.header.stamp.to_sec(), matrix_of_pose(message.pose.pose), covariance, chair)
        if np.all(np.isfinite(row)) and np.all(np.linalg.eigvalsh(planar) > 0.0):
            rows["dock"].append(row)
            rows["covariance"].append(planar)
