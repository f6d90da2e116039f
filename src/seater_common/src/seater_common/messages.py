"""Transforms and names out of ROS messages, by their fields alone: no ROS is needed."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
from numpy.typing import NDArray

from seater_common.geometry import rotation_matrix

Array = NDArray[np.float64]


def matrix_of_pose(pose: Any) -> Array:
    """4x4 of a geometry_msgs/Pose; all NaN when its quaternion is no rotation."""
    return _matrix(pose.position, pose.orientation)


def matrix_of_transform(transform: Any) -> Array:
    """The same of a geometry_msgs/Transform."""
    return _matrix(transform.translation, transform.rotation)


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
