"""A chair that obeys, its odometry and its camera, round the docking node on the stand."""

from __future__ import annotations

from typing import Any

import hostile
import numpy as np
import rospy
from nav_msgs.msg import Odometry
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation
from stand import Stand

from seater_common.geometry import pose_matrix
from seater_common.se2 import arc_step, inverse
from seater_msgs.msg import DockGoal, DockObservation, GateState, MarkerDetection, MarkerDetectionArray
from seater_nmpc.ros import conversions

STEP, IMAGE_EVERY = 0.02, 3  # [s] of odometry; steps between two images
BEGIN = 1000.0  # [s] of every episode: time jumps backward between two of them, so that nothing of the last one counts
START = (-1.6, 0.1, 0.05)  # base_link in the dock's frame [m, m, rad]
DRIVES = 0.03  # [m/s] or [rad/s] from which on the chair counts as driving
COVARIANCE = np.diag([0.002**2] * 3 + [0.003**2] * 3).ravel().tolist()


class Drive:
    """One episode after the other. odom and dock coincide."""

    def __init__(self, stand: Stand) -> None:
        self.stand = stand
        self._noise = np.random.default_rng(1)
        self.begin()

    def begin(self) -> None:
        """A new episode, from the start pose."""
        self._steps, self._pose, self._speed = 0, np.array(START), (0.0, 0.0)
        self.stand.sent.clear()
        self.advance(0.1)

    @property
    def stamp(self) -> rospy.Time:
        return rospy.Time.from_sec(BEGIN + STEP * self._steps)

    def advance(self, duration: float) -> None:
        """Good messages for so long [s]."""
        for _ in range(round(duration / STEP)):
            self.step()

    def step(self) -> None:
        """20 ms: the chair moves as it was told to last, and says so."""
        self._steps += 1
        told = self.stand.sent.get("velocity_request")
        self._speed = (told[-1].twist.linear.x, told[-1].twist.angular.z) if told and self.stand.active else (0.0, 0.0)
        self._pose = arc_step(self._pose, *self._speed, STEP)
        self.stand.deliver("gate_state", self.gate_state())
        if self._steps % IMAGE_EVERY == 0:
            self.stand.deliver("detections", self.detections())
        self.stand.deliver("odom", self.odometry())

    def docks(self, duration: float) -> bool:
        """Whether a goal that is given now brings the chair to drive within so long [s]."""
        if not self.stand.active:
            self.stand.give("dock", DockGoal(use_dock_id=True))
        for _ in range(round(duration / STEP)):
            self.step()
            if max(map(abs, self._speed)) > DRIVES:
                return True
        return False

    def standing(self, duration: float) -> list[Odometry]:
        """Odometry of a chair that stands for so long [s]; not delivered."""
        self._speed, messages = (0.0, 0.0), []
        for _ in range(round(duration / STEP)):
            self._steps += 1
            messages.append(self.odometry())
        return messages

    def odometry(self) -> Odometry:
        message = Odometry(child_frame_id="base_link")
        message.header.stamp, message.header.frame_id = self.stamp, "odom"
        message.pose.pose = conversions.pose_message(self._pose)
        message.twist.twist = conversions.twist(*self._speed)
        return message

    def detections(self) -> MarkerDetectionArray:
        core = self.stand.node._core
        T_optical_base = np.linalg.inv(core.vehicle.chair.camera.T_base_optical())
        T_base_dock = pose_matrix(inverse(self._pose) + self._noise.normal(size=3) * [0.002, 0.002, 0.003])
        message = MarkerDetectionArray()
        message.header.stamp, message.header.frame_id = self.stamp, "camera_color_optical_frame"
        dock = DockObservation(weight=1.0, marker_ids=[marker.id for marker in core.dock.markers])
        _fill(dock.pose, T_optical_base @ T_base_dock)
        message.dock = [dock]
        for marker in core.dock.markers:
            seen = MarkerDetection(id=marker.id, size=marker.size)
            _fill(seen.pose, T_optical_base @ T_base_dock @ marker.T_dock_marker())
            message.markers.append(seen)
        return hostile.as_received(message)

    def gate_state(self) -> GateState:
        return GateState(consent=self.stand.consent, motion_allowed=True, state=GateState.REQUEST)


def _fill(message: Any, T: NDArray[np.float64]) -> None:
    position, orientation = message.pose.position, message.pose.orientation
    position.x, position.y, position.z = T[:3, 3]
    orientation.x, orientation.y, orientation.z, orientation.w = Rotation.from_matrix(T[:3, :3]).as_quat()
    message.covariance = COVARIANCE
