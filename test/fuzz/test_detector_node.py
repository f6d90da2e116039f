"""Hostile messages to the marker detector's node: it lives, what it says is finite, and a good image is found at once.

Only where SEATER_FUZZ_MESSAGES is set, since the node takes minutes for them.
"""

from __future__ import annotations

import math
import os
import subprocess
import threading
import time
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import cv2
import numpy as np
import pytest
import rosgraph
import rospy
import yaml
from amount import EPISODES, PER_EPISODE
from driver import wait_until
from geometry_msgs.msg import PoseWithCovarianceStamped, TransformStamped
from hostile import Hostile, numbers
from sensor_msgs.msg import CameraInfo, CompressedImage, Image
from tf2_msgs.msg import TFMessage

from seater_msgs.msg import DockInUse, MarkerDetectionArray

CONFIG = Path(__file__).resolve().parents[2] / "config"
WIDTH, HEIGHT, FOCAL = 320, 180, 160.0  # [px]
BURST = 20  # hostile messages, then a good image whose detections are waited for: nothing is dropped for long
PATIENCE = 20.0  # [s]
DOCK = (CONFIG / "docks" / "default.yaml").read_text()

pytestmark = pytest.mark.skipif("SEATER_FUZZ_MESSAGES" not in os.environ, reason="SEATER_FUZZ_MESSAGES is not set")


def picture() -> np.ndarray:
    """Marker 0 of the default dock, 60 px wide."""
    image = np.full((HEIGHT, WIDTH), 200, np.uint8)
    dictionary = cv2.aruco.getPredefinedDictionary(cv2.aruco.DICT_4X4_50)
    image[60:120, 130:190] = cv2.aruco.drawMarker(dictionary, 0, 60)
    return image


PIXELS = picture()
RAW, JPEG = PIXELS.tobytes(), cv2.imencode(".jpg", PIXELS)[1].tobytes()


class Node:
    """The node as shipped, fed with `transport` images, and what it says."""

    def __init__(self, transport: str) -> None:
        self.name, self.transport = f"detector_{transport}", transport
        files = {"chair": "chair", "dock": "docks/default", "perception": "perception"}
        master = rosgraph.Master("/test")
        for key, file in files.items():
            master.setParam(f"/{self.name}/{key}", yaml.safe_load((CONFIG / f"{file}.yaml").read_text()))
        for key, value in {"image_transport": transport, "rectified": False, "odometry_frame": "odom"}.items():
            master.setParam(f"/{self.name}/{key}", value)
        self.stamps: set[rospy.Time] = set()
        self.violations: list[str] = []
        self._lock = threading.Lock()
        self._subscribers = [
            rospy.Subscriber(f"{transport}/detections", MarkerDetectionArray, self._on_detections, queue_size=100),
            rospy.Subscriber(f"{transport}/dock_pose", PoseWithCovarianceStamped, self._check, queue_size=100),
        ]
        kinds = {
            "image": Image if transport == "raw" else CompressedImage,
            "camera_info": CameraInfo,
            "dock_in_use": DockInUse,
            "/tf": TFMessage,
            "/tf_static": TFMessage,
        }
        topics = {"image": f"{transport}/image" + ("" if transport == "raw" else "/compressed")}
        self.publishers = {
            key: rospy.Publisher(topics.get(key, key if key[0] == "/" else f"{transport}/{key}"), kind, queue_size=100)
            for key, kind in kinds.items()
        }
        remappings = [f"{topic}:={transport}/{topic}" for topic in ("image", "detections", "dock_pose", "dock_in_use")]
        words = ["rosrun", "seater_perception", "marker_detector", f"__name:={self.name}", *remappings]
        self.process = subprocess.Popen(words, stdout=subprocess.DEVNULL, stderr=subprocess.STDOUT)
        wait_until(lambda: all(p.get_num_connections() for p in self.publishers.values()), "the detector to listen")

    def send(self, topic: str, message: Any) -> None:
        self.publishers[topic].publish(message)

    def finds(self) -> bool:
        """Whether a good image, sent as often as it takes to pass what waits before it, brings detections."""
        end = time.monotonic() + PATIENCE
        while time.monotonic() < end and self.process.poll() is None:
            stamp = rospy.Time.now()
            self.send("image", self.image(stamp))
            self.send("camera_info", camera_info(stamp))
            until = time.monotonic() + 0.3
            while time.monotonic() < until:
                with self._lock:
                    if stamp in self.stamps:
                        self.stamps.clear()
                        return True
                time.sleep(0.001)
        return False

    def image(self, stamp: rospy.Time) -> Any:
        if self.transport == "raw":
            message = Image(height=HEIGHT, width=WIDTH, encoding="mono8", step=WIDTH, data=RAW)
        else:
            message = CompressedImage(format="mono8; jpeg compressed ", data=JPEG)
        message.header.stamp, message.header.frame_id = stamp, "camera_color_optical_frame"
        return message

    def end(self) -> None:
        self.process.kill()
        self.process.wait()
        for subscriber in self._subscribers:
            subscriber.unregister()

    def _on_detections(self, message: MarkerDetectionArray) -> None:
        self._check(message)
        if any(marker.id == 0 for marker in message.markers):
            with self._lock:
                self.stamps.add(message.header.stamp)

    def _check(self, message: Any) -> None:
        if not all(map(math.isfinite, numbers(message))):
            self.violations.append(f"not finite: {message}")


def camera_info(stamp: rospy.Time) -> CameraInfo:
    message = CameraInfo(width=WIDTH, height=HEIGHT, distortion_model="plumb_bob", D=[0.0] * 5)
    message.header.stamp, message.header.frame_id = stamp, "camera_color_optical_frame"
    cx, cy = 0.5 * (WIDTH - 1), 0.5 * (HEIGHT - 1)
    message.K = [FOCAL, 0.0, cx, 0.0, FOCAL, cy, 0.0, 0.0, 1.0]
    message.R = [1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0]
    message.P = [FOCAL, 0.0, cx, 0.0, 0.0, FOCAL, cy, 0.0, 0.0, 0.0, 1.0, 0.0]
    return message


def dock_in_use(stamp: rospy.Time) -> DockInUse:
    return DockInUse(name="default", source="test", since=stamp, known=["default"], content=DOCK)


def transforms(stamp: rospy.Time) -> TFMessage:
    message = TransformStamped(child_frame_id="camera_color_optical_frame")
    message.header.stamp, message.header.frame_id = stamp, "odom"
    message.transform.rotation.w = 1.0
    return TFMessage([message])


def attack(node: Node, topic: str, hostile: Hostile) -> None:
    """One message with something wrong in it, and what belongs to it."""
    stamp = rospy.Time.now()
    if topic == "image":
        image = node.image(stamp)
        image.data, data = b"", image.data
        image = hostile.spoil(image)
        image.data = spoilt(data, hostile)
        node.send("image", image)
        info = camera_info(image.header.stamp)  # the pair is worked through
    else:
        node.send("image", node.image(stamp))
        info = hostile.spoil(camera_info(stamp)) if topic == "camera_info" else camera_info(stamp)
        info.header.stamp = stamp if hostile.random.random() < 0.9 else info.header.stamp
    node.send("camera_info", info)
    if topic == "dock_in_use":
        message = hostile.spoil(dock_in_use(stamp))
        message.content = wrong_yaml(hostile) if hostile.random.random() < 0.7 else message.content
        node.send(topic, message)
    elif topic.startswith("/tf"):
        node.send(topic, hostile.spoil(transforms(stamp)))


def spoilt(data: bytes, hostile: Hostile) -> bytes:
    """As it is, too short, too long, nothing, or with some bytes that are others."""
    random = hostile.random
    kind = random.randrange(6)
    if kind == 0:
        return data[: random.randrange(len(data))]
    if kind == 1:
        return data * 2
    if kind == 2:
        return b""
    if kind == 3:
        other = bytearray(data)
        for _ in range(random.choice((1, 10, 100))):
            other[random.randrange(len(other))] = random.randrange(256)
        return bytes(other)
    return data


def wrong_yaml(hostile: Hostile) -> str:
    """The dock file with a piece left out, doubled, or a number that is another."""
    random, words = hostile.random, DOCK.split()
    kind, place = random.randrange(3), random.randrange(len(DOCK))
    if kind == 0:
        return DOCK[:place] + DOCK[place + random.randrange(1, 200) :]
    if kind == 1:
        return DOCK[:place] + DOCK[place - 50 : place] + DOCK[place:]
    number = random.choice([word for word in words if word.replace(".", "", 1).isdigit()])
    return DOCK.replace(number, random.choice((".nan", ".inf", "-1", "0", "1e300", "1e-300", "[]", "99999999999")))


@pytest.fixture(scope="module", params=["raw", "compressed"])
def node(driver: Any, request: Any) -> Iterator[Node]:
    made = Node(request.param)
    yield made
    made.end()


@pytest.mark.parametrize("topic", ["image", "camera_info", "dock_in_use", "/tf", "/tf_static"])
def test_hostile_messages_to_the_detector(node: Node, topic: str) -> None:
    hostile = Hostile(f"{node.transport} {topic}")
    good: Callable[[], bool] = node.finds
    for episode in range(EPISODES):
        for number in range(PER_EPISODE):
            attack(node, topic, hostile)
            if number % BURST == BURST - 1:
                where = f"{topic}, episode {episode}, message {number}"
                if topic == "dock_in_use":
                    node.send(topic, dock_in_use(rospy.Time.now()))
                assert good(), f"{where}: no detections; exit code {node.process.poll()}"
                assert not node.violations, where
