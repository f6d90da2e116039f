"""From the answers' messages to the rows of a replay's log."""

from __future__ import annotations

import math

import numpy as np
import rospy

from seater_common.geometry import planar_pose, pose_matrix, rotation_matrix
from seater_eval.docking.recording import pose_at
from seater_eval.docking.replay_log import CycleRow, ImageRow
from seater_msgs.msg import ControllerStatus, MarkerDetectionArray


def image_row(message: MarkerDetectionArray, poses: np.ndarray | None, T_base_optical: np.ndarray) -> ImageRow:
    """`poses`: (n, 4) time, x, y, heading of base_link in odom; None: the dock is given in base_link."""
    stamp = message.header.stamp.to_sec()
    row = ImageRow(stamp, len(message.markers), int(bool(message.dock)), None, None, None, None,
                     1e3 * message.processing_time)  # fmt: skip
    if not message.dock:
        return row
    estimate = message.dock[0].pose
    p, q = estimate.pose.position, estimate.pose.orientation
    T_optical_dock = np.eye(4)
    T_optical_dock[:3, :3] = rotation_matrix(q.x, q.y, q.z, q.w)
    T_optical_dock[:3, 3] = [p.x, p.y, p.z]
    T_frame_base = np.eye(4) if poses is None else pose_matrix(pose_at(poses, stamp))
    pose = planar_pose(T_frame_base @ T_base_optical @ T_optical_dock)
    row.dock_x, row.dock_y, row.dock_heading = (float(v) for v in pose)
    row.position_sd = math.sqrt(sum(estimate.covariance[i * 7] for i in range(3)))
    return row


def cycle_row(message: ControllerStatus, recorded: dict[rospy.Time, tuple[float, float]]) -> CycleRow:
    v, omega = recorded.get(message.header.stamp, (None, None))
    return CycleRow(
        message.header.stamp.to_sec(), message.phase, message.status, 1e3 * message.solve_time, message.iterations,
        message.command.linear.x, message.command.angular.z, v, omega,
    )  # fmt: skip
