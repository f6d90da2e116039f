"""Obstacle messages into odom (or the dock's frame) by TF; what counts of them is kept in ObstacleMemory."""

from __future__ import annotations

import numpy as np
import rospy
import tf2_ros
from geometry_msgs.msg import Polygon
from numpy.typing import ArrayLike, NDArray

from seater_common.messages import matrix_of_transform
from seater_msgs.msg import ObstacleArray
from seater_nmpc.plan.obstacles import ObstacleMemory, usable_outlines

Array = NDArray[np.float64]

_WARNING_PERIOD = 5.0  # [s] between two warnings of one kind


class Obstacles:
    """The obstacles of the last message that could be transformed."""

    def __init__(self, transforms: tf2_ros.Buffer, dock_frame: str, timeout: float) -> None:
        """`timeout` [s] of message time: how long a message holds; 0: until the next."""
        self._tf, self._dock_frame, self._timeout = transforms, dock_frame, timeout
        self._memory = ObstacleMemory(timeout)
        self._waiting: ObstacleArray | None = None  # the transform of its frame has not arrived yet

    def take(self, message: ObstacleArray, odom_frame: str) -> None:
        """Replaces what held before, as soon as its frame can be transformed: now or in one of the next cycles."""
        self._waiting = message
        self._transform(odom_frame)

    def now(self, stamp: float, odom_frame: str, T_odom_dock: ArrayLike | None) -> list[Array]:
        """Outlines (n, 2) in the dock's frame [m] for the control cycle at message time `stamp` [s]."""
        self._transform(odom_frame)
        if self._memory.forget_stale(stamp):
            rospy.logwarn("obstacles dropped: nothing new for more than %.1f s", self._timeout)
        return self._memory.in_dock(T_odom_dock)

    def _transform(self, odom_frame: str) -> None:
        message = self._waiting
        if message is None:
            return
        header = message.header
        bound = header.frame_id == self._dock_frame
        T = np.eye(4)
        if not bound and header.frame_id != odom_frame:
            try:
                found = self._tf.lookup_transform(odom_frame, header.frame_id, header.stamp)
            except tf2_ros.TransformException as error:
                rospy.logwarn_throttle(_WARNING_PERIOD, "obstacles in %r not used yet: %s", header.frame_id, error)
                return
            T = matrix_of_transform(found.transform)
        self._waiting = None
        outlines, complaints = usable_outlines(_corners(polygon, T) for polygon in message.polygons)
        if complaints:
            rospy.logwarn_throttle(_WARNING_PERIOD, "obstacles dropped: %s", "; ".join(complaints))
        self._memory.replace(outlines, bound_to_dock=bound)


def _corners(polygon: Polygon, T: Array) -> Array:
    """Corners (n, 2) after the transform, seen from above; z of the message is not used."""
    points = np.array([(point.x, point.y) for point in polygon.points], dtype=float).reshape(-1, 2)
    return np.asarray(points @ T[:2, :2].T + T[:2, 3])
