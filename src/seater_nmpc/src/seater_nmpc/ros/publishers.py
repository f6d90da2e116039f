"""What the docking node sends, but for its actions."""

from __future__ import annotations

import threading

import rospy
import tf2_ros
from geometry_msgs.msg import PoseWithCovarianceStamped, TwistStamped
from nav_msgs.msg import Path
from std_msgs.msg import Header

from seater_msgs.msg import ControllerStatus, DockInnovation, InputDone
from seater_nmpc.control.command import Command
from seater_nmpc.observe.innovation import Fusion
from seater_nmpc.observe.observer import DockEstimate
from seater_nmpc.ros import conversions


class Publishers:
    """Topics in docs/reference/interfaces.md. `stamp` and frames are those of the last odometry message."""

    def __init__(self, dock_frame: str, lock_step: bool) -> None:
        """`lock_step`: the simulator waits for `input_done`."""
        self._dock_frame = dock_frame
        self._request = rospy.Publisher("velocity_request", TwistStamped, queue_size=10)
        self._path = rospy.Publisher("predicted_path", Path, queue_size=10)
        self._filtered = rospy.Publisher("dock_pose_filtered", PoseWithCovarianceStamped, queue_size=10)
        self._innovations = rospy.Publisher("innovations", DockInnovation, queue_size=10)
        self._status = rospy.Publisher("controller_status", ControllerStatus, queue_size=10)
        self._done = rospy.Publisher("input_done", InputDone, queue_size=100) if lock_step else None
        self._tf = tf2_ros.TransformBroadcaster()
        self._sending, self._closing = threading.Lock(), False
        self._requested = rospy.Time(0)  # stamp of the last request
        self.stamp, self.odom_frame, self.base_frame = rospy.Time(0), "odom", "base_link"

    def request(self, v: float, omega: float) -> None:
        """The velocity request. After `close` nothing but zero goes out, whatever a worker is about to send."""
        with self._sending:
            v, omega = (0.0, 0.0) if self._closing else (v, omega)
            self._requested = self.stamp
            self._request.publish(conversions.velocity_request(self.stamp, self.base_frame, v, omega))

    def close(self) -> None:
        """From now on only zero is requested."""
        with self._sending:
            self._closing = True

    def report(self, command: Command, phase: str, fallbacks: int, age: float) -> None:
        """What the controller did in one cycle; `age` of the measurement [s], -1: never seen."""
        self._status.publish(conversions.status(self.stamp, self.odom_frame, command, phase, fallbacks, age))
        if len(command.path):
            self._path.publish(conversions.path(self.stamp, self.odom_frame, command.path))

    def innovation(self, stamp: rospy.Time, fusion: Fusion) -> None:
        """What the observer made of the image taken at `stamp`."""
        self._innovations.publish(conversions.innovation(stamp, self.odom_frame, fusion))

    def dock(self, stamp: rospy.Time, estimate: DockEstimate) -> None:
        """The dock in odom, with the stamp of the image behind it: a lost marker is silence."""
        self._filtered.publish(conversions.filtered_pose(stamp, self.odom_frame, estimate))
        self._tf.sendTransform(conversions.transform(stamp, self.odom_frame, self._dock_frame, estimate.pose))

    def done(self, kind: str, header: Header) -> None:
        """In lock-step: this input has been worked through."""
        if self._done is not None:
            requested = kind in ("odom", "detections") and self._requested == header.stamp
            self._done.publish(InputDone(header, rospy.get_name(), kind, requested))
