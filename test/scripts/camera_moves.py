#!/usr/bin/env python3
"""The nodelet follows the dock with TF's odometry, does without it and never waits for it; both poses go out while an
image has not decided."""

import math
import sys
import threading
import time
import unittest
from collections.abc import Callable
from typing import ClassVar

import cv2
import numpy as np
import rospy
import rostest
import tf2_ros
from diagnostic_msgs.msg import DiagnosticArray
from geometry_msgs.msg import TransformStamped
from sensor_msgs.msg import CameraInfo, Image

from seater_msgs.msg import MarkerDetectionArray

WIDTH, HEIGHT, F = 1280, 720, 640.0
CX, CY = 0.5 * (WIDTH - 1), 0.5 * (HEIGHT - 1)
OPTICAL = "camera_color_optical_frame"
SIZE, FINE = 0.1, 4  # [m] side of marker 0; samples across a pixel


def image(distance: float, bearing: float, yaw: float = 0.0) -> np.ndarray:
    """Marker 0 at the camera's height, `distance` [m] ahead and turned by `yaw` [rad], seen by a camera that is turned
    left by `bearing` [rad]."""
    dictionary = cv2.aruco.getPredefinedDictionary(cv2.aruco.DICT_4X4_50)
    sheet = cv2.copyMakeBorder(cv2.aruco.drawMarker(dictionary, 0, 240), 40, 40, 40, 40, cv2.BORDER_CONSTANT, value=255)
    half = 0.5 * SIZE * 320 / 240
    corners = np.array([[-half, -half, 0.0], [half, -half, 0.0], [half, half, 0.0], [-half, half, 0.0]])
    corners = corners @ cv2.Rodrigues(np.array([0.0, yaw, 0.0]))[0].T + [0.0, 0.0, distance]
    turned = corners @ cv2.Rodrigues(np.array([0.0, bearing, 0.0]))[0].T
    pixels = F * turned[:, :2] / turned[:, 2:] + [CX, CY]
    source = np.array([[0, 0], [320, 0], [320, 320], [0, 320]], np.float32) - 0.5
    target = ((pixels + 0.5) * FINE - 0.5).astype(np.float32)
    H = cv2.getPerspectiveTransform(source, target)
    fine = cv2.warpPerspective(sheet, H, (WIDTH * FINE, HEIGHT * FINE), flags=cv2.INTER_LINEAR, borderValue=160)
    small = cv2.resize(fine, (WIDTH, HEIGHT), interpolation=cv2.INTER_AREA).astype(np.float32)
    noise = np.random.default_rng(1).standard_normal(small.shape, dtype=np.float32)
    grey = cv2.GaussianBlur(40.0 + 0.7 * small, (0, 0), 0.7) + 2.0 * noise
    return np.asarray(np.clip(np.rint(grey), 0, 255), dtype=np.uint8)


def transform(parent: str, child: str, stamp: rospy.Time, heading: float = 0.0) -> TransformStamped:
    message = TransformStamped(child_frame_id=child)
    message.header.frame_id, message.header.stamp = parent, stamp
    message.transform.rotation.z, message.transform.rotation.w = math.sin(0.5 * heading), math.cos(0.5 * heading)
    return message


class CameraMoves(unittest.TestCase):
    answers = 0  # of the nodelet, since it started
    diagnostics: ClassVar[dict[str, str]] = {}  # the last ones

    @classmethod
    def setUpClass(cls) -> None:
        rospy.init_node("camera_moves")
        rospy.Subscriber("/diagnostics", DiagnosticArray, cls.on_diagnostics, queue_size=10)

    def setUp(self) -> None:
        self.received: list[MarkerDetectionArray] = []
        self.arrived = threading.Condition()
        self.odometry, self.mount = tf2_ros.TransformBroadcaster(), tf2_ros.StaticTransformBroadcaster()
        optical = transform("base_link", OPTICAL, rospy.Time(0))
        rotation = optical.transform.rotation
        rotation.x, rotation.y, rotation.z, rotation.w = -0.5, 0.5, -0.5, 0.5
        self.mount.sendTransform(optical)
        self.images = rospy.Publisher("camera/color/image_raw", Image, queue_size=10)
        self.infos = rospy.Publisher("camera/color/camera_info", CameraInfo, queue_size=10)
        self.subscriber = rospy.Subscriber("detections", MarkerDetectionArray, self.on_detections, queue_size=10)
        publishers = (self.images, self.infos, self.odometry.pub_tf, self.mount.pub_tf)
        ends = (*publishers, self.subscriber)
        self.wait(lambda: all(end.get_num_connections() > 0 for end in ends), "the detector does not listen")

    def tearDown(self) -> None:
        self.subscriber.unregister()
        ends = (self.images, self.infos)
        self.wait(lambda: not any(end.get_num_connections() for end in ends), "the detector still listens")
        for end in ends:
            end.unregister()

    def wait(self, condition: Callable[[], bool], otherwise: str) -> None:
        end = time.monotonic() + 20.0
        while not condition():
            self.assertLess(time.monotonic(), end, otherwise)
            time.sleep(0.02)

    def on_detections(self, message: MarkerDetectionArray) -> None:
        with self.arrived:
            self.received.append(message)
            self.arrived.notify_all()

    @classmethod
    def on_diagnostics(cls, message: DiagnosticArray) -> None:
        for status in message.status:
            if status.name.endswith("detector: detection"):
                cls.diagnostics = {v.key: v.value for v in status.values}

    def counted(self, key: str) -> int:
        """A count since the start, of diagnostics that know of every answer so far."""
        counts = CameraMoves
        known = "images since start"
        self.wait(lambda: int(counts.diagnostics.get(known, -1)) >= counts.answers, f"too few {known}")
        return int(counts.diagnostics[key])

    def find(self, image: np.ndarray, stamp: rospy.Time) -> MarkerDetectionArray:
        """The answer to an image; at most a second may pass."""
        message = Image(height=HEIGHT, width=WIDTH, encoding="mono8", step=WIDTH, data=image.tobytes())
        info = CameraInfo(width=WIDTH, height=HEIGHT, distortion_model="plumb_bob", D=[0.0] * 5)
        info.K = [F, 0.0, CX, 0.0, F, CY, 0.0, 0.0, 1.0]
        info.R = [1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0]
        info.P = [F, 0.0, CX, 0.0, 0.0, F, CY, 0.0, 0.0, 0.0, 1.0, 0.0]
        for part in (message, info):
            part.header.stamp, part.header.frame_id = stamp, OPTICAL
        self.infos.publish(info)
        self.images.publish(message)
        with self.arrived:
            self.assertTrue(self.arrived.wait_for(lambda: bool(self.received), timeout=5.0), "no answer")
            answer = self.received.pop()
        CameraMoves.answers += 1
        self.assertEqual(answer.header.stamp, stamp)
        self.assertLess(answer.processing_time, 1.0)
        return answer

    def turn(self, start: float, with_odometry: bool) -> int:
        """Two images; between them the chair turns by 0.25 rad (160 px, far beyond the tracker's margin). How many
        searches of the whole image that took."""
        before = self.counted("full searches since start")
        for t, heading in ((start, 0.0), (start + 0.5, 0.25)):
            if with_odometry:
                for around in (-0.01, 0.01):
                    stamp = rospy.Time.from_sec(t + around)
                    self.odometry.sendTransform(transform("odom", "base_link", stamp, heading))
                time.sleep(0.5)
            answer = self.find(image(1.2, heading), rospy.Time.from_sec(t))
            self.assertEqual([m.id for m in answer.markers], [0])
            self.assertAlmostEqual(answer.markers[0].pose.pose.position.x, 1.2 * math.sin(heading), delta=0.01)
        return self.counted("full searches since start") - before

    def test_odometry_tells_where_to_look(self) -> None:
        self.assertEqual(self.turn(1000.0, with_odometry=True), 1, "the first image only")

    def test_without_odometry_the_whole_image_is_searched(self) -> None:
        self.assertEqual(self.turn(2000.0, with_odometry=False), 2)

    def test_both_poses_go_out_while_the_image_has_not_decided(self) -> None:
        # At the camera's height, +yaw and -yaw look the same from afar, and both are upright.
        answer = self.find(image(2.8, 0.0, 0.05), rospy.Time.from_sec(3000.0))
        weights = [h.weight for h in answer.dock]
        self.assertEqual(len(weights), 2)
        self.assertAlmostEqual(sum(weights), 1.0)
        self.assertGreaterEqual(weights[0], weights[1])
        for hypothesis in answer.dock:
            covariance = np.array(hypothesis.pose.covariance).reshape(6, 6)
            self.assertGreater(float(np.linalg.eigvalsh(covariance).min()), 0.0)


if __name__ == "__main__":
    rostest.rosrun("seater_test", "camera_moves", CameraMoves, sys.argv)
