"""The node that draws for rviz. It only listens; nothing here can move the chair.

Topics out: `scene/dock`, `scene/seen`, `scene/obstacles`, `scene/points` (visualization_msgs/MarkerArray),
`scene/footprint` (geometry_msgs/PolygonStamped). `predicted_path` and `detections/image` rviz shows as they are.
"""

from __future__ import annotations

import threading

import rospy
from geometry_msgs.msg import Point32, PolygonStamped
from nav_msgs.msg import Odometry
from std_msgs.msg import Header
from visualization_msgs.msg import Marker, MarkerArray

from seater_common.files.docks import read_content
from seater_common.geometry import Chair, Dock
from seater_common.params import ParameterError
from seater_msgs.msg import DockInUse, MarkerDetectionArray, ObstacleArray, ObstaclePoints
from seater_panel.ros import drawing

FOOTPRINT_PERIOD = rospy.Duration(0.1)  # of message time
REPEAT_PERIOD = 1.0  # [s] of wall time


class SceneNode:
    """Draws only what somebody looks at."""

    def __init__(self, chair: Chair, dock: Dock, dock_frame: str) -> None:
        self._chair, self._dock, self._base_frame = chair, dock, "base_link"
        self._T_base_optical = chair.camera.T_base_optical()
        self._drawn = rospy.Time(0)  # of the footprint
        self._dock_frame = dock_frame
        self._fixed = drawing.dock_markers(dock_frame, chair, dock)
        self._obstacles: MarkerArray | None = None
        self._dock_out = rospy.Publisher("scene/dock", MarkerArray, queue_size=1, latch=True)
        self._seen_out = rospy.Publisher("scene/seen", MarkerArray, queue_size=1)
        self._obstacles_out = rospy.Publisher("scene/obstacles", MarkerArray, queue_size=5, latch=True)
        self._points_out = rospy.Publisher("scene/points", MarkerArray, queue_size=1)
        self._footprint_out = rospy.Publisher("scene/footprint", PolygonStamped, queue_size=1)
        rospy.Subscriber("dock_in_use", DockInUse, self._on_dock, queue_size=1)
        rospy.Subscriber("odom", Odometry, self._on_odometry, queue_size=1)
        rospy.Subscriber("detections", MarkerDetectionArray, self._on_detections, queue_size=1)
        rospy.Subscriber("obstacles", ObstacleArray, self._on_obstacles, queue_size=1)
        rospy.Subscriber("obstacle_points", ObstaclePoints, self._on_points, queue_size=1)
        threading.Thread(target=self._repeat, name="repeat", daemon=True).start()

    def _repeat(self) -> None:
        """Again and again: rviz drops what comes before the dock's frame is known."""
        while not rospy.is_shutdown():
            self._dock_out.publish(self._fixed)
            if self._obstacles is not None:
                self._obstacles_out.publish(self._obstacles)
            rospy.rostime.wallsleep(REPEAT_PERIOD)

    def _on_dock(self, message: DockInUse) -> None:
        try:
            dock = read_content(message.content, message.source)
        except ParameterError as error:
            rospy.logwarn("dock %r is not drawn: %s", message.name, error)
            return
        if dock != self._dock:
            self._dock, self._fixed = dock, drawing.dock_markers(self._dock_frame, self._chair, dock)
            self._dock_out.publish(MarkerArray([Marker(action=Marker.DELETEALL)]))  # it may have fewer walls

    def _on_odometry(self, message: Odometry) -> None:
        self._base_frame = message.child_frame_id or self._base_frame
        stamp = message.header.stamp
        if self._drawn <= stamp < self._drawn + FOOTPRINT_PERIOD:
            return
        self._drawn = stamp
        footprint = PolygonStamped(header=Header(stamp=stamp, frame_id=self._base_frame))
        footprint.polygon.points = [Point32(float(x), float(y), 0.0) for x, y in self._chair.corners()]
        self._footprint_out.publish(footprint)

    def _on_detections(self, message: MarkerDetectionArray) -> None:
        if self._seen_out.get_num_connections() > 0:
            header = Header(stamp=message.header.stamp, frame_id=self._base_frame)
            self._seen_out.publish(drawing.seen_markers(header, self._T_base_optical, message, self._dock))

    def _on_obstacles(self, message: ObstacleArray) -> None:
        self._obstacles = drawing.obstacle_markers(message, self._dock_frame)
        self._obstacles_out.publish(self._obstacles)

    def _on_points(self, message: ObstaclePoints) -> None:
        if self._points_out.get_num_connections() > 0:
            self._points_out.publish(MarkerArray([drawing.point_marker(message)]))
