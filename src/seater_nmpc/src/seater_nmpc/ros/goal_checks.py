"""Whether a goal can be worked on, and where it says that the dock is."""

from __future__ import annotations

from typing import Any

import numpy as np
import tf2_ros
from geometry_msgs.msg import PoseStamped
from numpy.typing import NDArray

from seater_common.files.docks import DockDatabase, UnknownDockError
from seater_common.geometry import planar_pose
from seater_common.messages import matrix_of_pose, matrix_of_transform
from seater_nmpc.ros.goals import valid_timeout
from seater_nmpc.sequence.goal.results import ResultCode


class RefusedError(Exception):
    """Why a goal is not worked on."""

    def __init__(self, code: ResultCode, text: str) -> None:
        super().__init__(text)
        self.code, self.text = code, text


def dock_of(kind: str, goal: Any, docks: DockDatabase, in_use: str) -> str:
    """The name of the dock that the goal is about: `undock` is about the one in use.

    Raises:
        RefusedError: the goal names none of these docks.
    """
    try:
        return docks.entry(goal.dock_id).dock.name if kind == "dock" else in_use
    except UnknownDockError as error:
        raise RefusedError(ResultCode.DOCK_NOT_IN_DB, str(error)) from None


def check_goal(kind: str, goal: Any, transforms: tf2_ros.Buffer, odom_frame: str) -> NDArray[np.float64] | None:
    """The rough dock pose (x, y, heading) in odom that a `dock` goal gives; None if it gives none, or for `undock`.

    Raises:
        RefusedError: bad time-out, a pose that is not finite or has no transform at its stamp.
    """
    if not valid_timeout(goal.timeout):
        raise RefusedError(ResultCode.DOCK_NOT_VALID, f"timeout is {goal.timeout}")
    if kind != "dock" or goal.use_dock_id or goal.dock_pose == PoseStamped():
        return None
    try:
        return _prior(goal.dock_pose, transforms, odom_frame)
    except (tf2_ros.TransformException, ValueError) as error:
        raise RefusedError(ResultCode.DOCK_NOT_VALID, f"dock_pose: {error}") from error


def _prior(stamped: Any, transforms: tf2_ros.Buffer, odom_frame: str) -> NDArray[np.float64]:
    """The goal's dock pose in odom, by TF at the stamp that it carries."""
    T = matrix_of_pose(stamped.pose)
    if not np.all(np.isfinite(T)):
        raise ValueError("is not finite, or its quaternion is no rotation")
    found = transforms.lookup_transform(odom_frame, stamped.header.frame_id, stamped.header.stamp).transform
    return planar_pose(matrix_of_transform(found) @ T)
