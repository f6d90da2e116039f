"""The node round the finder: one sensor in, outlines for the controller and points for the gate out."""

from __future__ import annotations

import time
from typing import Any

import diagnostic_updater
import rospy
import tf2_ros
from diagnostic_msgs.msg import DiagnosticStatus

from seater_common.files.docks import read_content
from seater_common.geometry import Chair, Dock
from seater_common.params import ParameterError, load
from seater_msgs.msg import DockInUse, ObstacleArray, ObstaclePoints
from seater_obstacles.finder import Found, ObstacleFinder
from seater_obstacles.ros import messages
from seater_obstacles.ros.frames import Frames, Where
from seater_obstacles.ros.sources import SOURCES, Source
from seater_obstacles.settings import ObstacleSettings
from seater_obstacles.watch import SensorWatch

_WARNING_PERIOD = 5.0  # [s] between two warnings


class ObstacleNode:
    """Private parameters: ~chair, ~dock, ~obstacles (the files in config/), ~source, ~lock_step, ~base_frame,
    ~odom_frame, ~dock_frame. Topics: docs/reference/interfaces.md."""

    def __init__(self) -> None:
        settings = load(ObstacleSettings, rospy.get_param("~obstacles", None), rospy.resolve_name("~obstacles"))
        chair = load(Chair, rospy.get_param("~chair", None), rospy.resolve_name("~chair"))
        dock = load(Dock, rospy.get_param("~dock", None), rospy.resolve_name("~dock"))
        lock_step = bool(rospy.get_param("~lock_step", False))
        names = {name: rospy.get_param(f"~{name}_frame", default) for name, default in _FRAMES.items()}
        self._frames = Frames(**names)
        self._finder = ObstacleFinder(settings, chair, dock)
        self._where = Where(self._frames, lock_step)
        self._watch = SensorWatch(settings.cluster.min_points)
        self._source = Source(_source_kind(), settings.sense, 10 if lock_step else 1)
        self._outlines = rospy.Publisher("obstacles", ObstacleArray, queue_size=10, tcp_nodelay=True)
        self._points = rospy.Publisher("obstacle_points", ObstaclePoints, queue_size=10, tcp_nodelay=True)
        self._found: Found | None = None
        self._trouble, self._duration = "nothing has come from the sensor yet", 0.0
        self._updater = diagnostic_updater.Updater()
        self._updater.setHardwareID("none")
        self._updater.add("obstacles", self._write)
        self._timer = rospy.Timer(rospy.Duration(1.0), lambda _: self._updater.update(), reset=True)
        self._dock = dock
        rospy.Subscriber("dock_in_use", DockInUse, self._on_dock, queue_size=1)
        self._source.subscribe(self._on_measurement)

    def _on_dock(self, message: DockInUse) -> None:
        """The docking node looks for another dock; until it is seen, no place is taken for one."""
        try:
            dock = read_content(message.content, message.source)
        except ParameterError as error:
            rospy.logerr("still exempts dock %s: %s", self._dock.name, error)
            return
        if dock != self._dock:
            self._dock, self._where.dock_since = dock, message.since
            self._finder.use_dock(dock)

    def _on_measurement(self, message: Any) -> None:
        """What cannot be used is told to the gate, which stops the chair."""
        begin, header, kind = time.monotonic(), message.header, self._source.kind
        try:
            places = self._where.at(header)
            sight = self._source.sight(message, places.T_base_sensor)
            near = kind != "scan" and self._finder.near_dock(sight, places.T_odom_base, places.T_odom_dock)
            self._watch.check(sight, self._source.measured(message), places.T_odom_base, too_near=near)
        except (tf2_ros.TransformException, ValueError) as error:
            self._trouble = str(error)
            rospy.logwarn_throttle(_WARNING_PERIOD, "obstacles cannot be seen: %s", error)
            self._points.publish(messages.blocked(header, kind, self._frames.base, str(error)))
            return
        found = self._finder.update(header.stamp.to_sec(), sight, places.T_odom_base, places.T_odom_dock)
        # The controller hears of it first: in lock-step the simulator goes on when the gate's message is out.
        self._outlines.publish(messages.obstacles(header, found, self._frames.odom))
        self._points.publish(messages.points(header, kind, self._frames.base, found))
        self._found, self._trouble, self._duration = found, "", time.monotonic() - begin

    def _write(self, status: diagnostic_updater.DiagnosticStatusWrapper) -> diagnostic_updater.DiagnosticStatusWrapper:
        if self._trouble:
            status.summary(DiagnosticStatus.WARN, self._trouble)
        else:
            status.summary(DiagnosticStatus.OK, f"sees by {self._source.kind}")
        if self._found is not None:
            status.add("outlines", str(len(self._found.outlines)))
            status.add("moving", str(self._found.moving))
            status.add("points remembered in blind areas", str(self._found.remembered))
            status.add("blind part of the full circle", f"{self._found.blind:.2f}")
            status.add("time for a measurement [ms]", f"{1e3 * self._duration:.1f}")
        return status


_FRAMES = {"base": "base_link", "odom": "odom", "dock": "dock"}


def _source_kind() -> str:
    kind = rospy.get_param("~source", None)
    if kind not in SOURCES:
        raise ParameterError(f"{rospy.resolve_name('~source')}: is {kind!r}, must be one of {', '.join(SOURCES)}")
    return str(kind)
