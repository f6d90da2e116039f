#!/usr/bin/env python3
"""The nodelet meets images and calibrations that it cannot use: an error, no output, no crash; a good one works."""

import math
import sys
import threading
import time
import unittest
from collections.abc import Callable

import cv2
import numpy as np
import rospy
import rostest
from sensor_msgs.msg import CameraInfo, Image

from seater_msgs.msg import MarkerDetectionArray

WIDTH, HEIGHT = 1280, 720


def scene() -> np.ndarray:
    """Marker 0 of the default dock, 200 px wide, in the middle of a grey image."""
    dictionary = cv2.aruco.getPredefinedDictionary(cv2.aruco.DICT_4X4_50)
    image = np.full((HEIGHT, WIDTH), 200, np.uint8)
    image[260:460, 540:740] = cv2.aruco.drawMarker(dictionary, 0, 200)
    return image


def image_message(data: np.ndarray, encoding: str) -> Image:
    message = Image(height=data.shape[0], width=data.shape[1], encoding=encoding)
    message.step = data.strides[0]
    message.data = data.tobytes()
    return message


def camera_info(**changes: object) -> CameraInfo:
    message = CameraInfo(width=WIDTH, height=HEIGHT, distortion_model="plumb_bob", D=[0.0] * 5)
    message.K = [640.0, 0.0, 639.5, 0.0, 640.0, 359.5, 0.0, 0.0, 1.0]
    message.R = [1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0]
    message.P = [640.0, 0.0, 639.5, 0.0, 0.0, 640.0, 359.5, 0.0, 0.0, 0.0, 1.0, 0.0]
    for name, value in changes.items():
        setattr(message, name, value)
    return message


class BadImages(unittest.TestCase):
    @classmethod
    def setUpClass(cls) -> None:
        rospy.init_node("bad_images")

    def setUp(self) -> None:
        self.received: list[MarkerDetectionArray] = []
        self.arrived = threading.Condition()
        self.images = rospy.Publisher("camera/color/image_raw", Image, queue_size=10)
        self.infos = rospy.Publisher("camera/color/camera_info", CameraInfo, queue_size=10)
        self.subscriber: rospy.Subscriber | None = None
        self.stamp = 0

    def tearDown(self) -> None:
        if self.subscriber is not None:
            self.subscriber.unregister()
        self.wait(lambda: not (self.images.get_num_connections() or self.infos.get_num_connections()))
        self.images.unregister()
        self.infos.unregister()

    def listen(self) -> None:
        self.subscriber = rospy.Subscriber("detections", MarkerDetectionArray, self.on_detections, queue_size=10)
        self.wait(lambda: self.images.get_num_connections() > 0 and self.infos.get_num_connections() > 0)

    def on_detections(self, message: MarkerDetectionArray) -> None:
        with self.arrived:
            self.received.append(message)
            self.arrived.notify_all()

    def wait(self, condition: Callable[[], bool], timeout: float = 20.0) -> None:
        end = time.monotonic() + timeout
        while not condition():
            self.assertLess(time.monotonic(), end, "waited too long")
            time.sleep(0.02)

    def send(self, image: Image, info: CameraInfo) -> rospy.Time:
        self.stamp += 1
        stamp = rospy.Time(1000 + self.stamp)
        for message in (image, info):
            message.header.stamp = stamp
            message.header.frame_id = "camera_color_optical_frame"
        self.infos.publish(info)
        self.images.publish(image)
        return stamp

    def find(self) -> MarkerDetectionArray:
        """A good image is answered, with its stamp and frame."""
        stamp = self.send(image_message(scene(), "mono8"), camera_info())
        self.wait(lambda: bool(self.received))
        message = self.received.pop()
        self.assertEqual(message.header.stamp, stamp)
        self.assertEqual(message.header.frame_id, "camera_color_optical_frame")
        self.assertEqual([m.id for m in message.markers], [0])
        return message

    def test_listens_to_the_camera_only_while_someone_listens(self) -> None:
        time.sleep(1.0)
        self.assertEqual(self.images.get_num_connections(), 0)
        self.listen()
        assert self.subscriber is not None
        self.subscriber.unregister()
        self.wait(lambda: self.images.get_num_connections() == 0)

    def test_good_image_in_several_encodings(self) -> None:
        self.listen()
        self.assertAlmostEqual(self.find().markers[0].pose.pose.position.z, 0.1 * 640 / 200, delta=0.002)
        grey = scene()
        colour = np.repeat(grey[:, :, None], 3, axis=2)
        chroma = np.full_like(grey, 128)
        deep = (16 * grey.astype(np.uint16)).astype("<u2")  # a sensor of 12 bits
        for encoding, image in (
            ("bgr8", colour), ("rgb8", colour), ("bgra8", np.dstack([colour, grey])), ("bayer_grbg8", grey),
            ("yuv422", np.dstack([chroma, grey])), ("yuv422_yuy2", np.dstack([grey, chroma])),
            ("mono16", deep), ("bayer_rggb16", deep), ("rgb16", np.repeat(deep[:, :, None], 3, axis=2)),
        ):  # fmt: skip
            with self.subTest(encoding):
                self.send(image_message(image, encoding), camera_info())
                self.wait(lambda: bool(self.received))
                self.assertEqual([m.id for m in self.received.pop().markers], [0])

    def test_nothing_is_made_of_what_cannot_be_used(self) -> None:
        self.listen()
        self.find()
        good = image_message(scene(), "mono8")
        nan = math.nan
        zero_k = camera_info(K=[0.0] * 9)
        nan_k = camera_info(K=[nan, 0.0, 639.5, 0.0, 640.0, 359.5, 0.0, 0.0, 1.0])
        nan_d = camera_info(D=[nan, 0.0, 0.0, 0.0, 0.0])
        other_size = camera_info(width=640, height=480)
        empty = Image(height=0, width=0, encoding="mono8", step=0)
        short = image_message(scene(), "mono8")
        short.data = short.data[:1000]
        float_nan = image_message(np.full((HEIGHT, WIDTH), nan, np.float32), "32FC1")
        unknown = image_message(scene(), "no_such_encoding")
        for name, image, info in (
            ("K = 0", good, zero_k), ("K = NaN", good, nan_k), ("D = NaN", good, nan_d), ("size", good, other_size),
            ("empty", empty, camera_info()), ("short", short, camera_info()),
            ("NaN", float_nan, camera_info()), ("encoding", unknown, camera_info()),
        ):  # fmt: skip
            with self.subTest(name):
                self.send(image, info)
                time.sleep(0.3)
                self.assertEqual(self.received, [])
                self.find()


if __name__ == "__main__":
    rostest.rosrun("seater_test", "bad_images", BadImages, sys.argv)
