"""The annotated image of the detector as JPEG, as often as a page needs it, and only while one looks."""

from __future__ import annotations

import threading
import time
from collections.abc import Callable

import cv2
import numpy as np
import rospy
from numpy.typing import NDArray
from sensor_msgs.msg import Image

LOOK_PERIOD = 0.25  # [s] between two looks whether a page wants images
FRAME_PERIOD = 0.12  # [s]: about 8 images per second
WIDEST = 800  # [px]: what a phone shows
QUALITY = 70
BUFFER = 1 << 24  # bytes: more than an image, else rospy reads it in pieces and falls behind


def to_jpeg(image: NDArray[np.uint8]) -> bytes:
    """A colour image (h, w, 3), BGR, at most WIDEST wide."""
    height, width = image.shape[:2]
    if width > WIDEST:
        image = cv2.resize(image, (WIDEST, round(height * WIDEST / width)), interpolation=cv2.INTER_AREA)
    return bytes(cv2.imencode(".jpg", image, [cv2.IMWRITE_JPEG_QUALITY, QUALITY])[1])


def pixels(message: Image) -> NDArray[np.uint8] | None:
    """(h, w, 3) BGR of an annotated image; None: not one."""
    if message.encoding != "bgr8" or message.step < 3 * message.width or not message.width * message.height:
        return None
    if len(message.data) < message.step * message.height:
        return None
    rows = np.frombuffer(message.data, np.uint8, message.step * message.height).reshape(message.height, message.step)
    return rows[:, : 3 * message.width].reshape(message.height, message.width, 3)


class ImageFeed:
    """Subscribes to `detections/image` while `wanted()`; the detector draws only while somebody listens.

    In a thread of its own, as subscribing waits for the ROS master.
    """

    def __init__(self, wanted: Callable[[], bool], offer: Callable[[bytes], None]) -> None:
        self._wanted, self._offer = wanted, offer
        self._subscriber: rospy.Subscriber | None = None
        self._last = float("-inf")
        threading.Thread(target=self._look, name="images", daemon=True).start()

    def _look(self) -> None:
        while not rospy.is_shutdown():
            self._follow()
            rospy.rostime.wallsleep(LOOK_PERIOD)

    def _follow(self) -> None:
        if self._wanted() and self._subscriber is None:
            self._subscriber = rospy.Subscriber(
                "detections/image", Image, self._on_image, queue_size=1, buff_size=BUFFER, tcp_nodelay=True
            )
        elif not self._wanted() and self._subscriber is not None:
            self._subscriber.unregister()
            self._subscriber = None

    def _on_image(self, message: Image) -> None:
        now = time.monotonic()
        image = pixels(message) if now - self._last >= FRAME_PERIOD else None
        if image is not None:
            self._last = now
            self._offer(to_jpeg(image))
