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
_PATIENCE = 0.5  # [s] of message time for the transform of a frame


class Obstacles:
    """The obstacles of the last message that could be transformed."""

    def __init__(self, transforms: tf2_ros.Buffer, dock_frame: str, timeout: float) -> None:
        """`timeout` [s] of message time: how old a message may become; 0: any age."""
        self._tf, self._dock_frame, self._timeout = transforms, dock_frame, timeout
        self._memory = ObstacleMemory(timeout)
        self._waiting: ObstacleArray | None = None  # the transform of its frame has not arrived yet
        self._waiting_since: float | None = None
        self._why_waiting = self._complaint = ""

    def take(self, message: ObstacleArray, odom_frame: str) -> None:
        """Replaces what held before, as soon as its frame can be transformed: now or in one of the next cycles."""
        if self._waiting is None:
            self._waiting_since = None
        self._waiting = message
        self._transform(odom_frame)

    def trouble(self, stamp: float) -> str:
        """Why it is not known what is in the way at message time `stamp` [s], in words; empty: it is."""
        if self._waiting is not None:
            if self._waiting_since is None or stamp < self._waiting_since:
                self._waiting_since = stamp
            if stamp - self._waiting_since > _PATIENCE:
                return f"obstacles are told in a frame that cannot be resolved: {self._why_waiting}"
        if self._complaint:
            return f"obstacles are told that are none: {self._complaint}"
        return f"nothing new on `obstacles` for {self._timeout:.1f} s" if self._memory.stale(stamp) else ""

    def now(self, odom_frame: str, T_odom_dock: ArrayLike | None) -> list[Array]:
        """Outlines (n, 2) in the dock's frame [m] for this control cycle."""
        self._transform(odom_frame)
        return self._memory.in_dock(T_odom_dock)

    def leave_dock(self, T_odom_dock: ArrayLike | None) -> None:
        """Another dock is looked for; the one before was at this pose (None: not known)."""
        self._memory.leave_dock(T_odom_dock)

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
                self._why_waiting = f"{header.frame_id!r} ({error})"
                return
            T = matrix_of_transform(found.transform)
        self._waiting = None
        outlines, complaints = usable_outlines(_corners(polygon, T) for polygon in message.polygons)
        self._complaint = "; ".join(complaints)
        if complaints:
            rospy.logwarn_throttle(_WARNING_PERIOD, "obstacles that are none: %s", self._complaint)
        self._memory.replace(outlines, bound_to_dock=bound)


def _corners(polygon: Polygon, T: Array) -> Array:
    """Corners (n, 2) after the transform, seen from above; z of the message is not used."""
    points = np.array([(point.x, point.y) for point in polygon.points], dtype=float).reshape(-1, 2)
    return np.asarray(points @ T[:2, :2].T + T[:2, 3])
