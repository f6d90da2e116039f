"""What is said on the public topics, kept as plain values. Whatever is not finite is dropped here."""

from __future__ import annotations

import math
import threading
import time
from dataclasses import replace
from typing import Any

import numpy as np
import rospy
import tf2_ros
from geometry_msgs.msg import PoseWithCovarianceStamped
from nav_msgs.msg import Odometry, Path
from numpy.typing import NDArray

from seater_common.files.docks import read_content
from seater_common.geometry import CameraMount, planar_pose
from seater_common.messages import matrix_of_pose, matrix_of_transform, names_of
from seater_common.params import ParameterError
from seater_msgs.msg import (
    DockActionFeedback,
    DockActionResult,
    DockInUse,
    DockResult,
    GateState,
    MarkerDetectionArray,
    ObstacleArray,
    ObstaclePoints,
    UndockActionFeedback,
    UndockActionResult,
)
from seater_nmpc.ros.transforms import TransformBuffer
from seater_panel.view.heard import Gate, Heard, Motion, Outlines, Planned, Points, Progress, Result, Sight, Sights

Array = NDArray[np.float64]

RESULTS, STATES = names_of(DockResult), names_of(GateState)


class Listener:
    """Subscribes to everything but images."""

    def __init__(self, mount: CameraMount, dock_frame: str = "dock") -> None:
        """`mount`: of the camera, as the docking node has it."""
        self._lock, self._heard = threading.Lock(), Heard()
        self._T_base_optical = mount.T_base_optical()
        self._dock_frame, self._odom_frame, self._base_frame = dock_frame, "odom", "base_link"
        self._tf = TransformBuffer()
        self._tf_in = tf2_ros.TransformListener(self._tf)
        for topic, kind, callback in (
            ("gate_state", GateState, self._on_gate),
            ("dock_in_use", DockInUse, self._on_dock_in_use),
            ("odom", Odometry, self._on_odometry),
            ("dock_pose_filtered", PoseWithCovarianceStamped, self._on_dock),
            ("predicted_path", Path, self._on_path),
            ("detections", MarkerDetectionArray, self._on_detections),
            ("obstacles", ObstacleArray, self._on_obstacles),
            ("obstacle_points", ObstaclePoints, self._on_points),
        ):
            rospy.Subscriber(topic, kind, callback, queue_size=1, tcp_nodelay=True)
        for action, feedback, result in (
            ("dock", DockActionFeedback, DockActionResult),
            ("undock", UndockActionFeedback, UndockActionResult),
        ):
            rospy.Subscriber(f"{action}/feedback", feedback, self._on_feedback, action, queue_size=1)
            rospy.Subscriber(f"{action}/result", result, self._on_result, action, queue_size=10)

    def heard(self) -> Heard:
        """All of it, as of now."""
        with self._lock:
            return self._heard

    def note(self, **values: Any) -> None:
        """These are newer."""
        with self._lock:
            self._heard = replace(self._heard, **values)

    def _on_gate(self, message: GateState) -> None:
        state = STATES.get(message.state, str(message.state))
        self.note(gate=Gate(time=time.monotonic(), state=state, reason=message.reason))

    def _on_dock_in_use(self, message: DockInUse) -> None:
        try:
            dock = read_content(message.content, message.source)
        except ParameterError as error:
            rospy.logwarn("dock %r is not shown: %s", message.name, error)
            return
        with self._lock:
            known = self._heard.dock if self._heard.in_use in (None, dock) else None  # where it is
            self._heard = replace(self._heard, in_use=dock, docks=tuple(message.known), dock=known)

    def _on_odometry(self, message: Odometry) -> None:
        pose, twist = planar_pose(matrix_of_pose(message.pose.pose)), message.twist.twist
        if np.all(np.isfinite([*pose, twist.linear.x])):
            self._odom_frame = message.header.frame_id or self._odom_frame
            self._base_frame = message.child_frame_id or self._base_frame
            self.note(motion=Motion(time=time.monotonic(), pose=pose, v=twist.linear.x))

    def _on_dock(self, message: PoseWithCovarianceStamped) -> None:
        pose = planar_pose(matrix_of_pose(message.pose.pose))
        if np.all(np.isfinite(pose)):
            self.note(dock=pose)

    def _on_path(self, message: Path) -> None:
        path = np.array([(p.pose.position.x, p.pose.position.y) for p in message.poses], dtype=float).reshape(-1, 2)
        self.note(planned=Planned(time=time.monotonic(), path=path))

    def _on_detections(self, message: MarkerDetectionArray) -> None:
        T_odom_base = self._to_odom(self._base_frame, message.header.stamp)
        if T_odom_base is None:
            return
        T = T_odom_base @ self._T_base_optical
        markers = tuple(sight for seen in message.markers if (sight := _sight(seen, T)) is not None)
        docks = [(planar_pose(T @ matrix_of_pose(seen.pose.pose)), float(seen.weight)) for seen in message.dock]
        candidates = tuple((pose, weight) for pose, weight in docks if np.all(np.isfinite([*pose, weight])))
        self.note(sights=Sights(time=time.monotonic(), markers=markers, candidates=candidates))

    def _on_obstacles(self, message: ObstacleArray) -> None:
        frame = message.header.frame_id
        in_dock = frame == self._dock_frame
        T = np.eye(4) if in_dock else self._to_odom(frame, message.header.stamp)
        if T is None:
            rospy.logwarn_throttle(5.0, "obstacles not shown: no transform from %r", frame)
            return
        corners = [np.array([(c.x, c.y) for c in p.points], dtype=float).reshape(-1, 2) for p in message.polygons]
        polygons = tuple(each @ T[:2, :2].T + T[:2, 3] for each in corners)
        self.note(outlines=Outlines(in_dock=in_dock, polygons=polygons))

    def _on_points(self, message: ObstaclePoints) -> None:
        points = np.column_stack([message.x, message.y]) if len(message.x) == len(message.y) else np.empty((0, 2))
        self.note(points=Points(time=time.monotonic(), points=points.reshape(-1, 2)))

    def _on_feedback(self, message: Any, action: str) -> None:
        said = message.feedback
        self.note(
            progress=Progress(
                time=time.monotonic(),
                action=action,
                phase=said.phase_text,
                distance=said.distance if math.isfinite(said.distance) else -1.0,
                elapsed=said.elapsed_time,
                retries=getattr(said, "num_retries", 0),
                marker_seen=getattr(said, "marker_seen", None),
            )
        )

    def _on_result(self, message: Any, action: str) -> None:
        said = message.result
        verified = getattr(said, "position_sd", 0.0) > 0.0
        self.note(
            result=Result(
                time=time.monotonic(),
                action=action,
                code=said.result_code,
                name=RESULTS.get(said.result_code, str(said.result_code)),
                text=said.result_text,
                success=said.success,
                error=(said.longitudinal_error, said.lateral_error, said.heading_error) if verified else None,
            )
        )

    def _to_odom(self, frame: str, stamp: rospy.Time) -> Array | None:
        """T_odom_frame (4, 4) at the stamp; None: TF does not know it (yet)."""
        try:
            T = matrix_of_transform(self._tf.lookup_transform(self._odom_frame, frame, stamp).transform)
        except tf2_ros.TransformException:
            return None
        return T if np.all(np.isfinite(T)) else None


def _sight(seen: Any, T: Array) -> Sight | None:
    place = (T @ matrix_of_pose(seen.pose.pose))[:2, 3]
    R = T[:3, :3]
    covariance = R @ np.reshape(np.array(seen.pose.covariance, dtype=float), (6, 6))[:3, :3] @ R.T
    if not (np.all(np.isfinite(place)) and np.all(np.isfinite(covariance))):
        return None
    return Sight(id=seen.id, place=place, covariance=covariance[:2, :2])
