"""From the core's results to ROS messages."""

from __future__ import annotations

import math

import cv2
import numpy as np
import rospy
from geometry_msgs.msg import Point32, Polygon, Quaternion, TransformStamped
from nav_msgs.msg import Odometry
from numpy.typing import ArrayLike, NDArray
from sensor_msgs.msg import CameraInfo, CompressedImage, Image, LaserScan

from seater_common.camera_model import CameraModel
from seater_common.geometry import CameraMount, quaternion_of, rotation_rpy
from seater_common.messages import camera_info_of, quaternion_about_z
from seater_msgs.msg import ObstacleArray
from seater_sim.chair.covariance import VARIANCE_FLOOR
from seater_sim.chair.interface import OdometrySample
from seater_sim.loop.simulator import SimulatedImage, Truth
from seater_sim.ranging.sensor import RangeSensor
from seater_sim.ranging.taken import SimulatedRange
from seater_sim.settings import NANOSECONDS, SCAN, CameraSettings, Obstacle

OPTICAL_FRAME = "camera_color_optical_frame"
LASER_FRAME = "laser"


def stamp(time_ns: int) -> rospy.Time:
    """Nanoseconds as a ROS time."""
    return rospy.Time(time_ns // NANOSECONDS, time_ns % NANOSECONDS)


def odometry_message(sample: OdometrySample) -> Odometry:
    """Pose of base_link in odom, twist in base_link. What a chair on a flat floor cannot do has the variance's
    floor."""
    message = Odometry()
    message.header.stamp = stamp(sample.time_ns)
    message.header.frame_id = "odom"
    message.child_frame_id = sample.frame
    _set_pose(message, sample.pose, sample.v, sample.omega)
    pose = VARIANCE_FLOOR * np.eye(6)
    pose[np.ix_([0, 1, 5], [0, 1, 5])] = sample.pose_covariance
    twist = VARIANCE_FLOOR * np.eye(6)
    twist[np.ix_([0, 5], [0, 5])] = sample.twist_covariance
    message.pose.covariance = pose.reshape(-1).tolist()
    message.twist.covariance = twist.reshape(-1).tolist()
    return message


def truth_message(truth: Truth) -> Odometry:
    """True pose of base_link in dock_truth; it is exact, so the covariances are zero."""
    message = Odometry()
    message.header.stamp = stamp(truth.time_ns)
    message.header.frame_id = "dock_truth"
    message.child_frame_id = "base_link"
    _set_pose(message, truth.pose, truth.v, truth.omega)
    return message


def obstacles_message(obstacles: list[Obstacle], time_ns: int) -> ObstacleArray:
    """What stands in the way, in the frame of the dock: where it truly is, seen from where the dock truly is."""
    message = ObstacleArray()
    message.header.stamp, message.header.frame_id = stamp(time_ns), "dock"
    message.polygons = [
        Polygon([Point32(float(x), float(y), 0.0) for x, y in obstacle.polygon()]) for obstacle in obstacles
    ]
    return message


def _set_pose(message: Odometry, pose: ArrayLike, v: float, omega: float) -> None:
    x, y, heading = map(float, np.asarray(pose))
    message.pose.pose.position.x, message.pose.pose.position.y = x, y
    message.pose.pose.orientation = Quaternion(*quaternion_about_z(heading))
    message.twist.twist.linear.x, message.twist.twist.angular.z = v, omega


def odometry_transform(message: Odometry) -> TransformStamped:
    """odom -> base_link."""
    transform = TransformStamped(header=message.header, child_frame_id=message.child_frame_id)
    position = message.pose.pose.position
    transform.transform.translation.x, transform.transform.translation.y = position.x, position.y
    transform.transform.rotation = message.pose.pose.orientation
    return transform


def camera_transforms(mount: CameraMount, time_ns: int) -> list[TransformStamped]:
    """base_link -> camera_link -> optical frame."""
    body = TransformStamped(child_frame_id="camera_link")
    body.header.frame_id = "base_link"
    t = body.transform.translation
    t.x, t.y, t.z = mount.x, mount.y, mount.z
    body.transform.rotation = Quaternion(*quaternion_of(rotation_rpy(mount.roll, mount.pitch, mount.yaw)))
    optical = TransformStamped(child_frame_id=OPTICAL_FRAME)
    optical.header.frame_id = "camera_link"
    optical.transform.rotation = Quaternion(*quaternion_of(rotation_rpy(-0.5 * math.pi, 0.0, -0.5 * math.pi)))
    for transform in (body, optical):
        transform.header.stamp = stamp(time_ns)
    return [body, optical]


def camera_info_message(model: CameraModel, image: SimulatedImage) -> CameraInfo:
    """Of one image; in its mode "nan_camera_info" the matrices are NaN."""
    message = CameraInfo(**camera_info_of(model))
    message.header.stamp = stamp(image.stamp_ns)
    message.header.frame_id = OPTICAL_FRAME
    if not image.camera_info_valid:
        message.K, message.P = [math.nan] * 9, [math.nan] * 12
    return message


def image_message(image: SimulatedImage, pixels: NDArray[np.generic]) -> Image:
    """Raw image; `pixels` as `image.render` gives them."""
    message = Image(height=pixels.shape[0], width=pixels.shape[1], encoding=image.encoding, is_bigendian=0)
    message.header.stamp = stamp(image.stamp_ns)
    message.header.frame_id = OPTICAL_FRAME
    message.step = pixels.strides[0]
    message.data = pixels.tobytes()
    return message


def compressed_message(image: SimulatedImage, pixels: NDArray[np.generic], settings: CameraSettings) -> CompressedImage:
    """As compressed_image_transport names it. A NaN image cannot be compressed: its data are empty."""
    message = CompressedImage()
    message.header.stamp = stamp(image.stamp_ns)
    message.header.frame_id = OPTICAL_FRAME
    target = " bgr8" if image.encoding == "rgb8" else ""
    message.format = f"{image.encoding}; {settings.compressed_format} compressed{target}"
    if image.encoding != "32FC1":
        jpeg = settings.compressed_format == "jpeg"
        options = [cv2.IMWRITE_JPEG_QUALITY, settings.jpeg_quality] if jpeg else [cv2.IMWRITE_PNG_COMPRESSION, 1]
        bgr = pixels[:, :, ::-1] if pixels.ndim == 3 else pixels
        message.data = cv2.imencode(".jpg" if jpeg else ".png", bgr, options)[1].tobytes()
    return message


def laser_transform(sensor: RangeSensor, time_ns: int) -> TransformStamped:
    """base_link -> laser."""
    transform = TransformStamped(child_frame_id=LASER_FRAME)
    transform.header.frame_id, transform.header.stamp = "base_link", stamp(time_ns)
    t = transform.transform.translation
    t.x, t.y, t.z = sensor.T_base_sensor[:3, 3].tolist()
    transform.transform.rotation = Quaternion(*quaternion_of(sensor.T_base_sensor[:3, :3]))
    return transform


def range_message(taken: SimulatedRange) -> LaserScan | Image:
    """A scan in the frame of the laser, or a depth image (32FC1) in the optical frame."""
    values, sensor = taken.measure(), taken.sensor
    if sensor.kind == SCAN:
        scan = sensor.settings.scan
        first, last = float(sensor.angles[0]), float(sensor.angles[-1])
        message = LaserScan(
            angle_min=first, angle_max=last, angle_increment=scan.step, scan_time=sensor.settings.period
        )
        message.range_min, message.range_max, message.ranges = scan.min_range, scan.max_range, values.tolist()
        message.header.frame_id = LASER_FRAME
    else:
        rows, columns = values.shape
        message = Image(height=rows, width=columns, encoding="32FC1", is_bigendian=0, step=4 * columns)
        message.data = values.astype("<f4").tobytes()
        message.header.frame_id = OPTICAL_FRAME
    message.header.stamp = stamp(taken.stamp_ns)
    return message


def depth_info_message(taken: SimulatedRange) -> CameraInfo:
    """Of a depth image, which is rectified."""
    depth, K = taken.sensor.settings.depth, taken.sensor.K
    message = CameraInfo(height=depth.rows, width=depth.columns, distortion_model="plumb_bob", D=[0.0] * 5)
    message.header.stamp, message.header.frame_id = stamp(taken.stamp_ns), OPTICAL_FRAME
    message.K, message.R = K.reshape(-1).tolist(), np.eye(3).reshape(-1).tolist()
    message.P = np.hstack([K, np.zeros((3, 1))]).reshape(-1).tolist()
    return message
