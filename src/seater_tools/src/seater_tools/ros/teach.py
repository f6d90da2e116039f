"""The node that teaches the docked pose.

Topics in: `odom` (nav_msgs/Odometry), `detections` (seater_msgs/MarkerDetectionArray).
Services (std_srvs/Trigger): `~confirm` stores the pose in which the chair stands now; `~check` says how far it stands
from the docked pose of the file, and changes nothing. It moves nothing.
"""

from __future__ import annotations

import threading
from pathlib import Path

import rospy
from nav_msgs.msg import Odometry
from std_srvs.srv import Trigger, TriggerRequest, TriggerResponse

from seater_common.geometry import Dock
from seater_common.params import ParameterError, load
from seater_msgs.msg import MarkerDetectionArray
from seater_tools.teach.teacher import Answer, Files, Teacher

DETECTOR = "marker_detector/dock"  # what perception was told, if it runs under its usual name


class TeachNode:
    """One lock round the measurements. Raises ParameterError: a file is wrong, or perception was told another dock."""

    def __init__(self, files: Files) -> None:
        self._lock, self._teacher = threading.Lock(), Teacher(files)
        _compare_with_perception(self._teacher.dock, files.dock)
        rospy.Subscriber("odom", Odometry, self._on_odometry, queue_size=100, tcp_nodelay=True)
        rospy.Subscriber("detections", MarkerDetectionArray, self._on_detections, queue_size=20)
        rospy.Service("~confirm", Trigger, self._on_confirm)
        rospy.Service("~check", Trigger, self._on_check)

    def state(self) -> str:
        """One line for a person who drives the chair in."""
        with self._lock:
            return self._teacher.state()

    def confirm(self) -> Answer:
        """Store where the chair stands."""
        with self._lock:
            return self._teacher.confirm()

    def _on_confirm(self, _: TriggerRequest) -> TriggerResponse:
        answer = self.confirm()
        return TriggerResponse(answer.success, answer.text)

    def _on_check(self, _: TriggerRequest) -> TriggerResponse:
        with self._lock:
            answer = self._teacher.check()
        return TriggerResponse(answer.success, answer.text)

    def _on_odometry(self, message: Odometry) -> None:
        with self._lock:
            self._teacher.odometry(message)

    def _on_detections(self, message: MarkerDetectionArray) -> None:
        with self._lock:
            self._teacher.detections(message)


def _compare_with_perception(dock: Dock, path: Path) -> None:
    """The dock that perception sees has to be the one that is changed."""
    told = rospy.get_param(DETECTOR, None)
    if told is not None and load(Dock, told, DETECTOR).markers != dock.markers:
        raise ParameterError(f"{path}: its markers are not those that perception was told ({DETECTOR})")
