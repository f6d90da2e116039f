"""The node that teaches the docked pose.

Topics in: `odom` (nav_msgs/Odometry), `detections` (seater_msgs/MarkerDetectionArray).
Services (std_srvs/Trigger): `~confirm` stores the pose in which the chair stands now; `~check` says how far it stands
from the docked pose of the file, and changes nothing. It moves nothing.
"""

from __future__ import annotations

import datetime
import threading
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import rospy
from nav_msgs.msg import Odometry
from std_srvs.srv import Trigger, TriggerRequest, TriggerResponse

from seater_common.geometry import Chair, Dock, planar_pose
from seater_common.messages import matrix_of_pose
from seater_common.params import ParameterError, load, read_yaml
from seater_msgs.msg import MarkerDetectionArray
from seater_tools.teach.dock import remarks, taught_text
from seater_tools.teach.measure import Measurement, Standing, TeachError
from seater_tools.teach.store import store

DETECTOR = "marker_detector/dock"  # what perception was told, if it runs under its usual name


@dataclass(frozen=True)
class Files:
    """`target`: where the taught dock file goes; it may be `dock` itself."""

    dock: Path
    chair: Path
    target: Path


class TeachNode:
    """One lock round the measurements. Raises ParameterError: a file is wrong, or perception was told another dock."""

    def __init__(self, files: Files) -> None:
        self._files, self._lock, self._standing = files, threading.Lock(), Standing()
        self._dock = load(Dock, read_yaml(files.dock), str(files.dock))
        self._T_base_optical = load(Chair, read_yaml(files.chair), str(files.chair)).camera.T_base_optical()
        self._taught = False
        _compare_with_perception(self._dock, files.dock)
        rospy.Subscriber("odom", Odometry, self._on_odometry, queue_size=100, tcp_nodelay=True)
        rospy.Subscriber("detections", MarkerDetectionArray, self._on_detections, queue_size=20)
        rospy.Service("~confirm", Trigger, self._on_confirm)
        rospy.Service("~check", Trigger, self._on_check)

    def state(self) -> str:
        """One line for a person who drives the chair in."""
        with self._lock:
            try:
                return f"ready: {_words(self._dock, self._standing.measure())}"
            except TeachError as error:
                return str(error)

    def confirm(self) -> TriggerResponse:
        """Store where the chair stands."""
        with self._lock:
            try:
                if self._taught:
                    raise TeachError("it is taught; restart this and perception with the new dock file to teach again")
                measured, now = self._standing.measure(), datetime.datetime.now(datetime.UTC)
                text = taught_text(self._files.dock.read_text(), str(self._files.dock), self._dock, measured, now)
                written = store(text, self._files.target, now)
            except (TeachError, ParameterError, OSError) as error:
                return TriggerResponse(False, str(error))
            self._taught = True
            kept = f"; the one before is kept as {written[1]}" if len(written) > 1 else ""
            lines = [f"{_words(self._dock, measured)}; taught in {written[0]}{kept}", *remarks(self._dock, measured)]
        return TriggerResponse(True, ". ".join(lines))

    def check(self) -> TriggerResponse:
        """Success: the chair stands docked, within the tolerance of the dock file."""
        with self._lock:
            try:
                measured = self._standing.measure()
            except TeachError as error:
                return TriggerResponse(False, str(error))
        x, y, heading = self._dock.docking_error(measured.pose)
        tolerance = self._dock.tolerance
        docked = float(np.hypot(x, y)) <= tolerance.position and abs(heading) <= tolerance.heading
        return TriggerResponse(docked, f"{_words(self._dock, measured)}: {'docked' if docked else 'not docked'}")

    def _on_confirm(self, _: TriggerRequest) -> TriggerResponse:
        return self.confirm()

    def _on_check(self, _: TriggerRequest) -> TriggerResponse:
        return self.check()

    def _on_odometry(self, message: Odometry) -> None:
        pose = planar_pose(matrix_of_pose(message.pose.pose))
        with self._lock:
            self._standing.odometry(message.header.stamp.to_sec(), pose)

    def _on_detections(self, message: MarkerDetectionArray) -> None:
        if not message.dock:
            return
        best = message.dock[0]
        R = self._T_base_optical[:3, :3]
        rotation = np.zeros((6, 6))
        rotation[:3, :3] = rotation[3:, 3:] = R
        covariance = rotation @ np.reshape(np.array(best.pose.covariance, dtype=float), (6, 6)) @ rotation.T
        pose = planar_pose(self._T_base_optical @ matrix_of_pose(best.pose.pose))
        planar = covariance[np.ix_([0, 1, 5], [0, 1, 5])]
        with self._lock:
            self._standing.dock(message.header.stamp.to_sec(), pose, planar, best.weight)


def _words(dock: Dock, measured: Measurement) -> str:
    x, y, heading = dock.docking_error(measured.pose)
    return (
        f"the chair stands {1000 * x:.1f} mm ahead, {1000 * y:.1f} mm left, {np.degrees(heading):.2f} deg off the "
        f"docked pose of the file ({measured.count} measurements)"
    )


def _compare_with_perception(dock: Dock, path: Path) -> None:
    """The dock that perception sees has to be the one that is changed."""
    told = rospy.get_param(DETECTOR, None)
    if told is not None and load(Dock, told, DETECTOR).markers != dock.markers:
        raise ParameterError(f"{path}: its markers are not those that perception was told ({DETECTOR})")
