"""Feeds a recording to perception and the docking node, step by step, and keeps what they answer.

Messages go out in the order in which they were recorded. After an image it waits for the detections of this image
and for the docking node to have used them, after an odometry message for the docking node as well; so the rate changes
how long a replay takes, never what it finds.
"""

from __future__ import annotations

import time
from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any

import numpy as np
import rosbag
import rosgraph
import rospy
from nav_msgs.msg import Odometry
from rosgraph_msgs.msg import Clock
from sensor_msgs.msg import CameraInfo, CompressedImage, Image

from seater_common.geometry import Chair
from seater_eval.docking.recording import heading_of
from seater_eval.docking.replay_log import CycleRow, ImageRow
from seater_eval.ros.connections import is_connected, links
from seater_eval.ros.replay_answers import Answers, ReplayError
from seater_eval.ros.replay_rows import cycle_row, image_row
from seater_msgs.msg import ObstacleArray

ANSWERS = ("detections", "input_done", "controller_status")


@dataclass
class Topics:
    """Topic names in the bag, and which form of images it holds."""

    image: str
    camera_info: str
    odom: str
    transport: str = "raw"
    obstacles: str = "obstacles"  # played where the bag has it

    @property
    def images(self) -> str:
        return self.image + "/compressed" if self.transport == "compressed" else self.image


def absolute(name: str) -> str:
    return name if name.startswith("/") else "/" + name


class Replay:
    """One pass over one bag."""

    def __init__(self, bag: rosbag.Bag, topics: Topics, rate: float) -> None:
        self._bag, self._topics, self._rate = bag, topics, rate
        names = bag.get_type_and_topic_info()[1]
        self._names = {key: self._find(getattr(topics, key), names) for key in ("images", "camera_info", "odom")}
        obstacles = [name for name in names if absolute(name) == absolute(topics.obstacles)]
        if obstacles:
            self._names["obstacles"] = obstacles[0]
        self.images_in_bag = int(names[self._names["images"]].message_count)
        self.length = bag.get_end_time() - bag.get_start_time()
        kind = CompressedImage if topics.transport == "compressed" else Image
        suffix = "/compressed" if topics.transport == "compressed" else ""
        self._clock = rospy.Publisher("/clock", Clock, queue_size=10)
        self._publishers = {
            "odom": rospy.Publisher("odom", Odometry, queue_size=10),
            "camera_info": rospy.Publisher("camera/color/camera_info", CameraInfo, queue_size=10),
            "images": rospy.Publisher("camera/color/image_raw" + suffix, kind, queue_size=10),
        }
        if obstacles:
            self._publishers["obstacles"] = rospy.Publisher("obstacles", ObstacleArray, queue_size=10)
        self.answers = Answers()
        self.unanswered = self.obstacle_messages = 0

    @staticmethod
    def _find(wanted: str, names: Any) -> str:
        for name in names:
            if absolute(name) == absolute(wanted):
                return str(name)
        raise ReplayError(f"the bag has no topic {wanted}; it has: {', '.join(sorted(names))}")

    def wait_for_listeners(self, timeout: float) -> None:
        """Until perception and docking node are connected."""
        end = time.monotonic() + timeout
        for key, publisher in self._publishers.items():
            while publisher.get_num_connections() == 0:
                if time.monotonic() > end or rospy.is_shutdown():
                    raise ReplayError(f"nobody listens to {publisher.resolved_name} ({key})")
                # Time has to be above zero for some nodes to start.
                self._clock.publish(rospy.Time.from_sec(max(0.001, self._bag.get_start_time())))
                time.sleep(0.05)
        self._wait_for_answering(end)

    @staticmethod
    def _wait_for_answering(end: float) -> None:
        """Until what perception and docking node say is heard by everyone who listens."""
        master = rosgraph.Master(rospy.get_name())
        topics = [rospy.resolve_name(name) for name in ANSWERS]
        while True:
            wanted = links(master, topics=topics)
            lacking = [link for link in wanted if not is_connected(master, *link)]
            if {topic for _, topic, _ in wanted} == set(topics) and not lacking:
                return
            if time.monotonic() > end or rospy.is_shutdown():
                raise ReplayError(f"not connected: {lacking or sorted(set(topics) - {t for _, t, _ in wanted})}")
            time.sleep(0.05)

    def run(self) -> Iterator[float]:
        """Yields the fraction that is done, 0..1."""
        first: float | None = None
        started = time.monotonic()
        for key, message, stamp in self._messages():
            if rospy.is_shutdown():
                raise ReplayError("interrupted")
            first = stamp.to_sec() if first is None else first
            elapsed = stamp.to_sec() - first
            if self._rate > 0.0:
                time.sleep(max(0.0, elapsed / self._rate - (time.monotonic() - started)))
            self._clock.publish(stamp)
            self._publishers[key].publish(message)
            self._wait_for_answer(key, message.header.stamp)
            yield elapsed / self.length if self.length > 0.0 else 1.0

    def _messages(self) -> Iterator[tuple[str, Any, rospy.Time]]:
        """In recorded order; a camera_info goes out before its image whichever was recorded first."""
        keys = {name: key for key, name in self._names.items()}
        waiting: dict[rospy.Time, tuple[str, Any]] = {}
        for name, message, stamp in self._bag.read_messages(topics=list(keys)):
            key = keys[name]
            if key in ("odom", "obstacles"):
                yield key, message, stamp
                continue
            other = waiting.pop(message.header.stamp, None)
            if other is None:
                waiting[message.header.stamp] = (key, message)
                continue
            pair = dict([other, (key, message)])
            if len(pair) == 2:
                yield "camera_info", pair["camera_info"], stamp
                yield "images", pair["images"], stamp

    def _wait_for_answer(self, key: str, stamp: rospy.Time) -> None:
        if key in ("odom", "obstacles"):
            self.answers.wait_for_done(key, stamp)
            self.obstacle_messages += key == "obstacles"
        elif key == "images":
            if self.answers.wait_for_detections(stamp):
                self.answers.wait_for_done("detections", stamp)
            else:
                self.unanswered += 1

    def image_rows(self, chair: Chair) -> list[ImageRow]:
        """The dock in odom at each image's own time."""
        poses = self._odometry_poses()
        T_base_optical = chair.camera.T_base_optical()
        return [
            image_row(message, poses, T_base_optical)
            for _, message in sorted(self.answers.detections.items(), key=lambda item: item[0].to_sec())
        ]

    def cycle_rows(self) -> list[CycleRow]:
        recorded = self._recorded_commands()
        return [cycle_row(message, recorded) for message in self.answers.status if message.status != message.IDLE]

    def _odometry_poses(self) -> np.ndarray:
        rows = []
        for _, message, _ in self._bag.read_messages(topics=[self._names["odom"]]):
            pose = message.pose.pose
            stamp = message.header.stamp.to_sec()
            rows.append([stamp, pose.position.x, pose.position.y, heading_of(pose.orientation)])
        return np.array(rows, dtype=float)

    def _recorded_commands(self) -> dict[rospy.Time, tuple[float, float]]:
        messages = self._bag.read_messages(topics=["velocity_request", "/velocity_request"])
        return {m.header.stamp: (m.twist.linear.x, m.twist.angular.z) for _, m, _ in messages}
