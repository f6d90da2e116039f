"""Where sensor, chair and dock are at the time of a measurement, by TF."""

from __future__ import annotations

import time
from dataclasses import dataclass

import numpy as np
import rospy
import tf2_ros
from numpy.typing import NDArray
from std_msgs.msg import Header

from seater_common.geometry import planar_pose
from seater_common.messages import matrix_of_transform
from seater_nmpc.ros.transforms import TransformBuffer

Array = NDArray[np.float64]

PATIENCE = 0.3  # [s] of wall time for the odometry of the measurement's time to arrive
DOCK_DELAY = rospy.Duration(0.2)  # in lock-step: by then the transform has arrived everywhere, whoever is faster
_POLL = 0.002  # [s]


@dataclass(frozen=True)
class Frames:
    """Names in TF."""

    base: str
    odom: str
    dock: str


@dataclass(frozen=True)
class Places:
    """At the stamp of one measurement."""

    T_base_sensor: Array  # 4x4
    T_odom_base: Array  # (3,)
    T_odom_dock: Array | None  # (3,); None: not known


class Where:
    """Looks up in TF."""

    def __init__(self, frames: Frames, lock_step: bool) -> None:
        self._frames, self._lock_step = frames, lock_step
        self.dock_since = rospy.Time()  # older transforms are of another dock
        self._tf = TransformBuffer()
        self._listener = tf2_ros.TransformListener(self._tf)

    def at(self, header: Header) -> Places:
        """Raises tf2_ros.TransformException: sensor or odometry cannot be placed, with the reason."""
        frames, stamp = self._frames, header.stamp
        sensor = self._wait(frames.base, header.frame_id, stamp)
        return Places(sensor, planar_pose(self._wait(frames.odom, frames.base, stamp)), self._dock(stamp))

    def _wait(self, target: str, source: str, stamp: rospy.Time) -> Array:
        """By wall time, as simulated time may stand meanwhile."""
        end = time.monotonic() + PATIENCE
        while True:
            try:
                return matrix_of_transform(self._tf.lookup_transform(target, source, stamp).transform)
            except tf2_ros.TransformException:
                if time.monotonic() >= end or rospy.is_shutdown():
                    raise
            time.sleep(_POLL)

    def _dock(self, stamp: rospy.Time) -> Array | None:
        """Where it is taken to be; a lost marker moves no dock."""
        times = [stamp - DOCK_DELAY] if self._lock_step and stamp > rospy.Time() + DOCK_DELAY else []
        for at in [*times, rospy.Time()]:
            try:
                found = self._tf.lookup_transform(self._frames.odom, self._frames.dock, at)
                if found.header.stamp >= self.dock_since:
                    return planar_pose(matrix_of_transform(found.transform))
            except tf2_ros.TransformException:
                continue
        return None
