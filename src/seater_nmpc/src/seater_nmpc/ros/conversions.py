"""Messages to and from the types of the ROS-free core."""

from __future__ import annotations

import math

import numpy as np
import rospy
from geometry_msgs.msg import (
    Pose,
    PoseStamped,
    PoseWithCovarianceStamped,
    Quaternion,
    TransformStamped,
    Twist,
    TwistStamped,
)
from nav_msgs.msg import Odometry as OdometryMsg
from nav_msgs.msg import Path
from numpy.typing import ArrayLike, NDArray

from seater_common.geometry import planar_pose
from seater_common.messages import matrix_of_pose, quaternion_about_z
from seater_msgs.msg import (
    ControllerStatus,
    DockFeedback,
    DockInnovation,
    DockResult,
    MarkerDetectionArray,
    UndockFeedback,
    UndockResult,
)
from seater_nmpc.control.command import Command
from seater_nmpc.observe.innovation import Fusion
from seater_nmpc.observe.measurement import Hypothesis, MarkerSight
from seater_nmpc.observe.observer import DockEstimate
from seater_nmpc.observe.odometry.message import Odometry
from seater_nmpc.sequence.goal.results import Result, Step

Array = NDArray[np.float64]

SEEN_RECENTLY = 0.2  # [s] age up to which Dock.action says that the marker is seen


def pose_message(pose: ArrayLike) -> Pose:
    """A planar pose (x, y, heading) as a message."""
    x, y, heading = (float(value) for value in np.asarray(pose))
    message = Pose()
    message.position.x, message.position.y = x, y
    message.orientation = Quaternion(*quaternion_about_z(heading))
    return message


def odometry(message: OdometryMsg) -> Odometry:
    """Odometry of the core; not finite where the message is not."""
    twist = message.twist.twist
    pose = planar_pose(matrix_of_pose(message.pose.pose))
    return Odometry(message.header.stamp.to_sec(), pose, twist.linear.x, twist.angular.z)


def hypotheses(message: MarkerDetectionArray) -> list[Hypothesis]:
    """The dock's possible poses in one image."""
    return [
        Hypothesis(
            matrix_of_pose(seen.pose.pose), np.reshape(np.array(seen.pose.covariance, dtype=float), (6, 6)), seen.weight
        )
        for seen in message.dock
    ]


def marker_sights(message: MarkerDetectionArray) -> list[MarkerSight]:
    """The single markers of one image."""
    return [MarkerSight(seen.id, matrix_of_pose(seen.pose.pose)) for seen in message.markers]


def twist(v: float, omega: float) -> Twist:
    """Speeds as a message."""
    message = Twist()
    message.linear.x, message.angular.z = v, omega
    return message


def velocity_request(stamp: rospy.Time, frame: str, v: float, omega: float) -> TwistStamped:
    """Speeds with the stamp of the odometry that the cycle started from."""
    message = TwistStamped()
    message.header.stamp, message.header.frame_id = stamp, frame
    message.twist = twist(v, omega)
    return message


def path(stamp: rospy.Time, frame: str, poses: Array) -> Path:
    """Planned poses (n, 3) as a message."""
    message = Path()
    message.header.stamp, message.header.frame_id = stamp, frame
    for pose in poses:
        stamped = PoseStamped(header=message.header)
        stamped.pose = pose_message(pose)
        message.poses.append(stamped)
    return message


def status(stamp: rospy.Time, frame: str, command: Command, phase: str, fallbacks: int, age: float) -> ControllerStatus:
    """What the controller did in one cycle."""
    message = ControllerStatus()
    message.header.stamp, message.header.frame_id = stamp, frame
    message.solver, message.status = command.solver, int(command.status)
    message.status_text = f"{command.status.name} {command.text}".strip()
    message.phase, message.fallbacks, message.measurement_age = phase, fallbacks, age
    message.solve_time, message.iterations, message.cost = command.solve_time, command.iterations, command.cost
    message.constraint_violation = command.constraint_violation
    message.command = twist(command.v, command.omega)
    return message


def filtered_pose(stamp: rospy.Time, frame: str, estimate: DockEstimate) -> PoseWithCovarianceStamped:
    """The dock in odom; height, roll and pitch are zero by definition and certain."""
    message = PoseWithCovarianceStamped()
    message.header.stamp, message.header.frame_id = stamp, frame
    message.pose.pose = pose_message(estimate.pose)
    covariance = np.zeros((6, 6))
    covariance[np.ix_([0, 1, 5], [0, 1, 5])] = estimate.covariance
    message.pose.covariance = covariance.ravel().tolist()
    return message


def innovation(stamp: rospy.Time, frame: str, fusion: Fusion) -> DockInnovation:
    """What the observer made of the image taken at `stamp`; NaN where there was no estimate to compare with."""
    message = DockInnovation()
    message.header.stamp, message.header.frame_id = stamp, frame
    message.accepted, message.outcome = fusion.outcome.accepted, int(fusion.outcome)
    message.outcome_text = fusion.outcome.text
    found, nothing = fusion.innovation, [math.nan] * 3
    message.x, message.y, message.yaw = nothing if found is None else found.value.tolist()
    message.sd_x, message.sd_y, message.sd_yaw = nothing if found is None else found.sd.tolist()
    message.nis, message.gate_ratio = (math.nan, math.nan) if found is None else (found.nis, found.gate_ratio)
    return message


def transform(stamp: rospy.Time, frame: str, child: str, pose: ArrayLike) -> TransformStamped:
    """A planar pose as a transform."""
    message = TransformStamped()
    message.header.stamp, message.header.frame_id, message.child_frame_id = stamp, frame, child
    located = pose_message(pose)
    message.transform.translation.x, message.transform.translation.y = located.position.x, located.position.y
    message.transform.rotation = located.orientation
    return message


def dock_feedback(step: Step) -> DockFeedback:
    """Feedback of the action `dock`."""
    return DockFeedback(
        phase=int(step.phase),
        phase_text=step.phase.name,
        elapsed_time=step.elapsed,
        distance=step.distance,
        heading_error=step.heading_error,
        lateral_error=step.lateral_error,
        marker_seen=0.0 <= step.measurement_age <= SEEN_RECENTLY,
        num_retries=step.retries,
    )


def undock_feedback(step: Step) -> UndockFeedback:
    """Feedback of the action `undock`."""
    return UndockFeedback(
        phase=int(step.phase), phase_text=step.phase.name, elapsed_time=step.elapsed, distance=step.distance
    )


def dock_result(result: Result) -> DockResult:
    """Result of the action `dock`."""
    return DockResult(
        success=result.success,
        result_code=int(result.code),
        result_text=result.text,
        num_retries=result.retries,
        docking_time=result.duration,
        contact=result.contact,
        longitudinal_error=result.longitudinal_error,
        lateral_error=result.lateral_error,
        heading_error=result.heading_error,
        position_sd=result.position_sd,
        heading_sd=result.heading_sd,
    )


def undock_result(result: Result) -> UndockResult:
    """Result of the action `undock`."""
    return UndockResult(
        success=result.success,
        result_code=int(result.code),
        result_text=result.text,
        undocking_time=result.duration,
    )
