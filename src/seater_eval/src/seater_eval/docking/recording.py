"""One recorded docking as arrays, read from its bag.

Times are ROS seconds of the message's own stamp; poses are (x [m], y [m], heading [rad]).
"""

from __future__ import annotations

import math
from collections.abc import Iterable
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from seater_common.bags import open_bag
from seater_common.se2 import compose, inverse

Array = NDArray[np.float64]


class RecordingError(RuntimeError):
    """The bag cannot be read or lacks what a report needs."""


def _empty(columns: int) -> Any:
    return field(default_factory=lambda: np.zeros((0, columns)))


@dataclass
class Recording:
    """What the reports use. Empty arrays where a topic was not recorded."""

    truth: Array = _empty(6)  # (n, 6): time, x, y, heading of base_link in the true dock frame, v [m/s], omega [rad/s]
    odom: Array = _empty(6)  # (n, 6): the same in odom, from the wheels
    dock_in_odom: Array = _empty(4)  # (n, 4): time, x, y, heading of the estimated dock in odom
    images: Array = _empty(4)  # (n, 4): time, markers seen, dock seen (0 or 1), processing time [s]
    control: Array = _empty(6)  # (n, 6): time, solve time [s], iterations, status, asked v, asked omega
    commands: Array = _empty(3)  # (n, 3): time, v, omega as sent to the motors
    obstacles: list[Array] = field(default_factory=list)  # (n, 2) each [m], the last ones published in the dock's frame
    phases: list[tuple[float, str]] = field(default_factory=list)  # (time, phase) at each change
    goal_time: float | None = None
    result_time: float | None = None
    result: Any = None  # seater_msgs/DockResult
    missing: tuple[str, ...] = ()  # topics without a message of those that the report uses

    @property
    def judged_by(self) -> str:
        """What `path` comes from: "truth", "estimate" (of the dock, and odometry), or "nothing"."""
        if len(self.truth):
            return "truth"
        return "estimate" if len(self.odom) and len(self.dock_in_odom) else "nothing"

    @property
    def path(self) -> Array:
        """(n, 6) as `truth`, in the dock's frame. Without it as the chair believed at each time, by the newest estimate
        of the dock; before the first one, by that. Empty: neither was recorded."""
        if self.judged_by != "estimate":
            return self.truth
        newest = np.searchsorted(self.dock_in_odom[:, 0], self.odom[:, 0], side="right") - 1
        docks = self.dock_in_odom[np.maximum(newest, 0), 1:4]
        poses = [compose(inverse(dock), pose) for dock, pose in zip(docks, self.odom[:, 1:4], strict=True)]
        return np.column_stack([self.odom[:, 0], np.array(poses), self.odom[:, 4:6]])

    @property
    def motion(self) -> Array:
        """(n, 6) whose times and speeds are those of the chair: the truth, else the odometry; may be empty."""
        return self.truth if len(self.truth) else self.odom

    @property
    def span(self) -> tuple[float, float]:
        """First and last time of what is drawn [s]."""
        rows = [r for r in (self.motion, self.commands, self.control, self.images, self.dock_in_odom) if len(r)]
        first = rows[0]
        return float(first[0, 0]), float(first[-1, 0])


def read_recording(path: str | Path) -> Recording:
    """Raises RecordingError when the bag is unreadable, or has nothing of a docking."""
    rows: dict[str, list[list[float]]] = {k: [] for k in ("truth", "odom", "dock", "images", "control", "commands")}
    recording = Recording()
    with open_bag(path, RecordingError) as bag:
        for topic, message, _ in bag.messages(_READERS):
            _READERS[topic](message, rows, recording)
        recording.missing = tuple(name for name in _READERS if name not in bag.topics and name not in _OPTIONAL)
    if not any(rows.values()):
        raise RecordingError(f"{path}: has no messages on any of {', '.join(_READERS)}; was a docking recorded?")
    recording.truth = _sorted(rows["truth"], 6)
    recording.odom = _sorted(rows["odom"], 6)
    recording.dock_in_odom = _sorted(rows["dock"], 4)
    recording.images = _sorted(rows["images"], 4)
    recording.control = _sorted(rows["control"], 6)
    recording.commands = _sorted(rows["commands"], 3)
    return recording


def pose_at(trajectory: Array, time: float) -> Array:
    """The pose (3,) at a time within a trajectory whose columns begin with time, x, y, heading; linear in between."""
    heading = np.unwrap(trajectory[:, 3])
    columns = [trajectory[:, 1], trajectory[:, 2], heading]
    x, y, angle = (float(np.interp(time, trajectory[:, 0], column)) for column in columns)
    return np.array([x, y, math.remainder(angle, 2.0 * math.pi)])


def heading_of(orientation: Any) -> float:
    """Heading [rad] of a geometry_msgs/Quaternion that turns about z only."""
    return math.atan2(
        2.0 * (orientation.w * orientation.z + orientation.x * orientation.y),
        1.0 - 2.0 * (orientation.y**2 + orientation.z**2),
    )


def _sorted(rows: Iterable[list[float]], columns: int) -> Array:
    return np.array(sorted(rows), dtype=float).reshape(-1, columns)


def _pose_row(message: Any) -> list[float]:
    pose = message.pose.pose
    return [message.header.stamp.to_sec(), pose.position.x, pose.position.y, heading_of(pose.orientation)]


def _read_odometry(key: str) -> Any:
    def read(message: Any, rows: dict[str, list[list[float]]], _: Recording) -> None:
        twist = message.twist.twist
        rows[key].append([*_pose_row(message), twist.linear.x, twist.angular.z])

    return read


def _read_dock(message: Any, rows: dict[str, list[list[float]]], _: Recording) -> None:
    rows["dock"].append(_pose_row(message))


def _read_detections(message: Any, rows: dict[str, list[list[float]]], _: Recording) -> None:
    stamp = message.header.stamp.to_sec()
    rows["images"].append([stamp, len(message.markers), float(bool(message.dock)), message.processing_time])


def _read_status(message: Any, rows: dict[str, list[list[float]]], recording: Recording) -> None:
    if message.status == message.IDLE:
        return
    command = message.command
    stamp = message.header.stamp.to_sec()
    rows["control"].append(
        [stamp, message.solve_time, message.iterations, message.status, command.linear.x, command.angular.z]
    )


def _read_command(message: Any, rows: dict[str, list[list[float]]], _: Recording) -> None:
    rows["commands"].append([message.header.stamp.to_sec(), message.twist.linear.x, message.twist.angular.z])


def _read_obstacles(message: Any, _: dict[str, list[list[float]]], recording: Recording) -> None:
    if message.header.frame_id == "dock":  # as the simulator publishes them
        recording.obstacles = [
            np.array([[point.x, point.y] for point in polygon.points]) for polygon in message.polygons
        ]


def _read_goal(message: Any, _: dict[str, list[list[float]]], recording: Recording) -> None:
    recording.goal_time = message.header.stamp.to_sec()


def _read_feedback(message: Any, _: dict[str, list[list[float]]], recording: Recording) -> None:
    phase = message.feedback.phase_text
    if not recording.phases or recording.phases[-1][1] != phase:
        recording.phases.append((message.header.stamp.to_sec(), phase))


def _read_result(message: Any, _: dict[str, list[list[float]]], recording: Recording) -> None:
    recording.result_time = message.header.stamp.to_sec()
    recording.result = message.result


_READERS: dict[str, Any] = {
    "ground_truth": _read_odometry("truth"),
    "odom": _read_odometry("odom"),
    "dock_pose_filtered": _read_dock,
    "detections": _read_detections,
    "controller_status": _read_status,
    "cmd_vel_stamped": _read_command,
    "obstacles": _read_obstacles,
    "dock/goal": _read_goal,
    "dock/feedback": _read_feedback,
    "dock/result": _read_result,
}
_OPTIONAL = ("ground_truth", "obstacles")  # said otherwise; there may be none
