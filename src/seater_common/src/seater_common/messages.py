"""Between ROS messages and what they mean, by their fields alone: no ROS is needed."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
from numpy.typing import NDArray

from seater_common.camera_model import CameraModel
from seater_common.geometry import rotation_matrix

Array = NDArray[np.float64]


def matrix_of_pose(pose: Any) -> Array:
    """4x4 of a geometry_msgs/Pose; all NaN when its quaternion is no rotation."""
    return _matrix(pose.position, pose.orientation)


def matrix_of_transform(transform: Any) -> Array:
    """The same of a geometry_msgs/Transform."""
    return _matrix(transform.translation, transform.rotation)


def quaternion_about_z(heading: float) -> tuple[float, float, float, float]:
    """x, y, z, w of a heading [rad] on the floor."""
    return 0.0, 0.0, math.sin(0.5 * heading), math.cos(0.5 * heading)


def camera_info_of(camera: CameraModel) -> dict[str, Any]:
    """The fields of a sensor_msgs/CameraInfo but for its header."""
    return {
        "width": camera.width,
        "height": camera.height,
        "distortion_model": camera.distortion_model,
        "D": camera.D.tolist(),
        "K": camera.K.ravel().tolist(),
        "R": camera.R.ravel().tolist(),
        "P": camera.P.ravel().tolist(),
    }


def names_of(message: Any) -> dict[int, str]:
    """Number -> name of the constants of a generated message class."""
    found = {name: getattr(message, name) for name in dir(message) if name.isupper()}
    return {value: name for name, value in found.items() if isinstance(value, int)}


def _matrix(place: Any, quaternion: Any) -> Array:
    q = np.array([quaternion.x, quaternion.y, quaternion.z, quaternion.w])
    norm = float(np.linalg.norm(q))
    if not 0.9 < norm < 1.1:
        return np.full((4, 4), math.nan)
    T = np.eye(4)
    T[:3, :3] = rotation_matrix(*(q / norm))
    T[:3, 3] = [place.x, place.y, place.z]
    return T
