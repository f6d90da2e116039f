"""Watches a running system for the doctor: messages to the ROS-free watcher, names and parameters from the master."""

from __future__ import annotations

import math
import threading
import time
from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Any

import cv2
import numpy as np
import rosgraph
import rospy
import tf2_ros
from cv_bridge import CvBridge, CvBridgeError
from diagnostic_msgs.msg import DiagnosticArray, DiagnosticStatus
from geometry_msgs.msg import Twist
from nav_msgs.msg import Odometry
from sensor_msgs.msg import CameraInfo, CompressedImage, Image
from std_msgs.msg import Bool

from seater_common.geometry import Dock, planar_pose
from seater_common.messages import matrix_of_pose, matrix_of_transform, names_of
from seater_common.params import ParameterError
from seater_msgs.msg import GateState, MarkerDetectionArray, ObstaclePoints
from seater_nmpc.ros.camera import from_message, info_topic
from seater_nmpc.ros.conversions import hypotheses
from seater_nmpc.ros.transforms import TransformBuffer
from seater_tools.doctor.gather.watcher import Watcher
from seater_tools.doctor.observations import TOPICS, GateSeen, Live, MarkerSeen, Sight, Traffic

BASE = "base_link"  # where the odometry does not name it
# Which node was told what, by the names that docking.launch gives them.
TOLD = {
    "chair": "marker_detector/chair",
    "dock": "marker_detector/dock",
    "controller": "docking/controller",
    "camera": "docking/camera",
    "perception": "marker_detector/perception",
    "safety": "safety_gate/safety",
    "obstacles": "obstacle_finder/obstacles",
}
FINDER = "obstacle_finder"  # and what it listens to beside its sensor
BESIDE = ("/tf", "/tf_static", "/clock", "dock_in_use")
STATES = names_of(GateState)


@dataclass(frozen=True)
class Names:
    """Topics that are called differently from chair to chair."""

    image: str = "camera/color/image_raw"
    odom: str = "odom"
    cmd_vel: str = "cmd_vel"
    compressed: bool = False

    def of(self, role: str) -> str:
        """The resolved name of a topic."""
        image = rospy.resolve_name(self.image)
        if role == "image":
            return f"{image}/compressed" if self.compressed else image
        return info_topic(image) if role == "camera_info" else rospy.resolve_name(getattr(self, role, role))


class SystemWatch:
    """Listens from its construction on; `live` says what it has heard so far."""

    def __init__(self, names: Names) -> None:
        self.watcher = Watcher()
        self.on_odometry: Callable[[float, Any], None] = lambda stamp, pose: None  # of whoever drives
        self._names, self._begun, self._bridge = names, time.monotonic(), CvBridge()
        self._tf = TransformBuffer()
        self._tf_in = tf2_ros.TransformListener(self._tf)
        self._subscribe("odom", Odometry, self._take_odometry)
        self._subscribe("image", CompressedImage if names.compressed else Image, self._take_image)
        self._subscribe("camera_info", CameraInfo, self._take_info)
        self._subscribe("detections", MarkerDetectionArray, self._take_detections)
        self._subscribe("gate_state", GateState, self._take_gate)
        self._subscribe("user_cmd_vel", Twist, lambda m: self.watcher.joystick(m.linear.x, m.angular.z))
        self._subscribe("emergency_stop", Bool, lambda m: setattr(self.watcher.newest, "emergency_stop", m.data))
        self._subscribe("charging_contact", Bool, lambda m: setattr(self.watcher.newest, "contact", m.data))
        self._subscribe("obstacle_points", ObstaclePoints, lambda m: setattr(self.watcher.newest, "blocked", m.blocked))
        rospy.Subscriber("/diagnostics", DiagnosticArray, self._take_diagnostics, queue_size=20)

    def live(self, dock: Dock | None) -> Live:
        """What was heard; `dock`: as in the file. Raises rosgraph.MasterException, OSError: the master has gone."""
        duration = time.monotonic() - self._begun
        told = {role: rospy.get_param(name) for role, name in TOLD.items() if rospy.has_param(name)}
        base = Live(
            duration=duration,
            simulated_time=bool(rospy.get_param("/use_sim_time", False)),
            lock_step=bool(rospy.get_param("safety_gate/lock_step", False)),
            require_contact=bool(rospy.get_param("docking/require_contact", False)),
            told=told,
        )
        live = self.watcher.live(base, self._traffic(), dock)
        kind = rospy.get_param(f"{FINDER}/source", None)
        obstacles = None if kind is None else self.watcher.obstacles(str(kind), self._sensors())
        mount = self._mount(live.frames[1] or BASE, live.pictures.frame)
        return replace(live, T_base_optical=mount, obstacles=obstacles)

    def end(self) -> None:
        """The node has done its work."""
        rospy.signal_shutdown("done")

    def _subscribe(self, role: str, kind: Any, take: Callable[[Any], object]) -> None:
        def heard(message: Any) -> None:
            stamp = message.header.stamp.to_sec() if hasattr(message, "header") else math.nan
            self.watcher.arrived(role, stamp, rospy.get_time())
            take(message)

        rospy.Subscriber(self._names.of(role), kind, heard, queue_size=50, buff_size=2**25, tcp_nodelay=True)

    def _take_odometry(self, message: Odometry) -> None:
        pose, twist = planar_pose(matrix_of_pose(message.pose.pose)), message.twist.twist
        stamp = message.header.stamp.to_sec()
        self.watcher.newest.frames = (message.header.frame_id, message.child_frame_id)
        self.watcher.odometry((stamp, *pose.tolist(), twist.linear.x, twist.angular.z))
        self.on_odometry(stamp, pose)

    def _take_image(self, message: Any) -> None:
        self.watcher.newest.image_frame = message.header.frame_id
        try:
            if isinstance(message, CompressedImage):
                grey = cv2.imdecode(np.frombuffer(message.data, np.uint8), cv2.IMREAD_GRAYSCALE)
            else:
                grey = self._bridge.imgmsg_to_cv2(message, "mono8")
        except CvBridgeError:  # of another kind: perception's diagnostics say so
            return
        if grey is not None:
            self.watcher.image(message.header.stamp.to_sec(), grey)

    def _take_info(self, message: CameraInfo) -> None:
        newest = self.watcher.newest
        try:
            newest.info, newest.info_error = from_message(message), ""
        except ParameterError as error:
            newest.info, newest.info_error = None, str(error)

    def _take_detections(self, message: MarkerDetectionArray) -> None:
        markers = tuple(
            MarkerSeen(
                seen.id,
                seen.size,
                np.array([[corner.x, corner.y] for corner in seen.corners]),
                matrix_of_pose(seen.pose.pose),
                np.reshape(np.array(seen.pose.covariance, dtype=float), (6, 6)),
            )
            for seen in message.markers
        )
        self.watcher.sight(Sight(message.header.stamp.to_sec(), markers, tuple(hypotheses(message))))

    def _take_gate(self, message: GateState) -> None:
        state = STATES.get(message.state, str(message.state))
        self.watcher.newest.gate = GateSeen(state, message.reason, message.emergency_stop)

    def _take_diagnostics(self, message: DiagnosticArray) -> None:
        for status in message.status:
            if status.level == DiagnosticStatus.ERROR:
                self.watcher.complaint(status.name, status.message)

    def _traffic(self) -> dict[str, Traffic]:
        master, me = rosgraph.Master(rospy.get_name()), rospy.get_name()
        publishers, subscribers, _ = (dict(part) for part in master.getSystemState())

        def others(nodes: list[str]) -> tuple[str, ...]:
            return tuple(sorted(node for node in nodes if node != me))

        names = {role: self._names.of(role) for role in TOPICS}
        return {
            role: Traffic(name, others(publishers.get(name, [])), others(subscribers.get(name, [])))
            for role, name in names.items()
        }

    def _sensors(self) -> tuple[Traffic, ...]:
        """What obstacle_finder was told to listen to for its measurements, whatever it is called."""
        publishers, subscribers, _ = (dict(part) for part in rosgraph.Master(rospy.get_name()).getSystemState())
        finder, beside = rospy.resolve_name(FINDER), {rospy.resolve_name(name) for name in BESIDE}
        mine = sorted(topic for topic, nodes in subscribers.items() if finder in nodes and topic not in beside)
        return tuple(Traffic(topic, tuple(publishers.get(topic, ()))) for topic in mine)

    def _mount(self, base: str, optical: str) -> Any:
        try:
            return matrix_of_transform(self._tf.lookup_transform(base, optical, rospy.Time()).transform)
        except (tf2_ros.TransformException, ValueError):
            return None


def begin(names: Names) -> SystemWatch:
    """The doctor's own node. Signals stay with the program, which has to send zero before it ends."""
    rospy.init_node("doctor", anonymous=True, disable_signals=True)
    return SystemWatch(names)


def wait(seconds: float) -> None:
    """On the computer's clock: ROS time may stand."""
    threading.Event().wait(seconds)
