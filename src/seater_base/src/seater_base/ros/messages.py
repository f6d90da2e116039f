"""Odometry as messages."""

from __future__ import annotations

import numpy as np
import rospy
from geometry_msgs.msg import Quaternion, TransformStamped
from nav_msgs.msg import Odometry
from numpy.typing import NDArray

from seater_base.odometry import Driven
from seater_common.messages import quaternion_about_z

_PLANE = np.ix_([0, 1, 5], [0, 1, 5])


def odometry_message(stamp: rospy.Time, frames: tuple[str, str], driven: Driven) -> Odometry:
    """`frames`: odom, base_link. Height, roll and pitch are zero by definition."""
    message = Odometry()
    message.header.stamp = stamp
    message.header.frame_id, message.child_frame_id = frames
    pose = message.pose.pose
    pose.position.x, pose.position.y = float(driven.pose[0]), float(driven.pose[1])
    pose.orientation = Quaternion(*quaternion_about_z(float(driven.pose[2])))
    message.twist.twist.linear.x, message.twist.twist.angular.z = driven.v, driven.omega
    covariance, speeds = np.zeros((6, 6)), np.zeros((6, 6))
    covariance[_PLANE] = driven.pose_covariance
    speeds[0, 0], speeds[5, 5] = np.square(driven.speed_sd)
    message.pose.covariance, message.twist.covariance = covariance.ravel().tolist(), speeds.ravel().tolist()
    return message


def transform_message(stamp: rospy.Time, frames: tuple[str, str], pose: NDArray[np.float64]) -> TransformStamped:
    """The pose (3,) of base_link in odom."""
    message = TransformStamped()
    message.header.stamp = stamp
    message.header.frame_id, message.child_frame_id = frames
    message.transform.translation.x, message.transform.translation.y = float(pose[0]), float(pose[1])
    message.transform.rotation = Quaternion(*quaternion_about_z(float(pose[2])))
    return message
