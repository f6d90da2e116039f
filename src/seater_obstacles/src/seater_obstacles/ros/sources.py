"""The three kinds of sensor: subscribes, and makes sights of their messages."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
import rospy
from numpy.typing import NDArray
from sensor_msgs.msg import CameraInfo, Image, LaserScan, PointCloud2

from seater_common.inputs.senders import Senders, sender_of
from seater_obstacles.depth import DepthImages, cloud_sight
from seater_obstacles.ros import messages
from seater_obstacles.scan import scan_sight
from seater_obstacles.settings import SenseSettings
from seater_obstacles.sight import Sight

Array = NDArray[np.float64]

SOURCES = ("scan", "cloud", "depth")
TOPICS = {"scan": ("scan", LaserScan), "cloud": ("points", PointCloud2), "depth": ("depth/image", Image)}


class Source:
    """One sensor. `sight` turns a message into what it says, in base_link."""

    def __init__(self, kind: str, settings: SenseSettings, queue_size: int) -> None:
        """`kind`: one of SOURCES. `queue_size`: 1, or more where no message may be lost."""
        self.kind, self._settings, self._queue_size = kind, settings, queue_size
        self._depth = DepthImages(settings.stride)
        self._K: Array | None = None
        self._senders = Senders(rospy.resolve_name(TOPICS[kind][0]))
        self._size = (0, 0)  # width and height that `_K` is of [px]; 0: not told
        self._makers: dict[str, Callable[[Any, Array], Sight]] = {
            "scan": self._of_scan,
            "cloud": lambda m, T: cloud_sight(messages.cloud_points(m), T, settings),
            "depth": self._of_depth,
        }

    def subscribe(self, callback: Callable[[Any], None]) -> None:
        """From now on."""
        if self.kind == "depth":
            rospy.Subscriber("depth/camera_info", CameraInfo, self._on_info, queue_size=1)
        topic, message = TOPICS[self.kind]

        def take(came: Any) -> None:
            self._senders.heard(sender_of(came))
            callback(came)

        buffer = 2**24 if self.kind != "scan" else 2**16  # so that an old image does not wait in it
        rospy.Subscriber(topic, message, take, queue_size=self._queue_size, buff_size=buffer, tcp_nodelay=True)

    def sight(self, message: Any, T_base_sensor: Array) -> Sight:
        """Raises ValueError: the message cannot be used, with the reason."""
        trouble = self._senders.trouble()
        if trouble:
            raise ValueError(trouble)
        return self._makers[self.kind](message, T_base_sensor)

    def measured(self, message: Any) -> bytes:
        """What the sensor told, without stamp: equal when it repeats itself."""
        return np.asarray(message.ranges).tobytes() if self.kind == "scan" else bytes(message.data)

    def _of_scan(self, m: LaserScan, T: Array) -> Sight:
        limits = (m.range_min, m.range_max)
        return scan_sight(m.ranges, m.angle_min, m.angle_increment, limits, T, self._settings.max_range)

    def _of_depth(self, m: Image, T: Array) -> Sight:
        if self._K is None:
            raise ValueError("no camera_info of the depth image yet")
        if self._size not in ((0, 0), (m.width, m.height)):
            theirs = " x ".join(str(side) for side in self._size)
            raise ValueError(f"depth image: is {m.width} x {m.height}, its camera_info of {theirs} pixels")
        return cloud_sight(self._depth.cloud(messages.depth_pixels(m), self._K), T, self._settings)

    def _on_info(self, message: CameraInfo) -> None:
        """Rectified images: the left part of P; without one, K."""
        self._size = message.width, message.height
        P = np.array(message.P).reshape(3, 4)[:, :3]
        self._K = P if P[0, 0] > 0.0 else np.array(message.K).reshape(3, 3)
