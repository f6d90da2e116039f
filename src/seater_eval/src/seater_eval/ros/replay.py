"""Feeds a recording to perception and the docking node, step by step, and keeps what they answer.

Without odometry in the recording, or on demand, perception alone.

Messages go out in the order in which they were recorded. After an image it waits for the detections of this image
and for the docking node to have used them, after an odometry message for the docking node as well; so the rate changes
how long a replay takes, never what it finds.
"""

from __future__ import annotations

import time
from collections.abc import Iterator

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
from seater_eval.ros.bag_input import COMPRESSED, BagInput, Topics
from seater_eval.ros.connections import is_connected, links
from seater_eval.ros.launch_watch import ended_nodes
from seater_eval.ros.replay_answers import Answers, ReplayError
from seater_eval.ros.replay_rows import cycle_row, image_row
from seater_msgs.msg import ObstacleArray

PERCEPTION, CONTROLLER = "marker_detector", "docking"  # nodes
ANSWERS = ("detections", "input_done", "controller_status")
GIVE_UP = 3  # images that perception does not answer to, before it has answered to any


class Replay:
    """One pass over one bag."""

    def __init__(self, bag: rosbag.Bag, topics: Topics, rate: float, *, controller: bool) -> None:
        """`controller`: the docking node runs too. Without odometry in the bag, perception alone is replayed.

        Raises:
            ReplayError: the bag has not what it takes.
        """
        self._bag, self._rate = bag, rate
        self.input = BagInput(bag, topics)
        self.controller = controller and self.input.odometry
        if controller and not self.controller:
            self.input.notes.append(
                f"the bag has no odometry ({topics.odom}): perception only, dock poses are in base_link"
                " (controller:=false does without the docking node)"
            )
        self.length = bag.get_end_time() - bag.get_start_time()
        compressed = topics.transport == "compressed"
        self._clock = rospy.Publisher("/clock", Clock, queue_size=10)
        self._publishers = {
            "camera_info": rospy.Publisher("camera/color/camera_info", CameraInfo, queue_size=10),
            "images": rospy.Publisher(
                "camera/color/image_raw" + (COMPRESSED if compressed else ""),
                CompressedImage if compressed else Image,
                queue_size=10,
            ),
        }
        if self.controller:
            self._publishers["odom"] = rospy.Publisher("odom", Odometry, queue_size=10)
        if self.controller and "obstacles" in self.input.names:
            self._publishers["obstacles"] = rospy.Publisher("obstacles", ObstacleArray, queue_size=10)
        self.answers = Answers()
        self.unanswered = self.obstacle_messages = 0

    def wait_for_listeners(self, timeout: float) -> None:
        """Until perception and docking node are connected."""
        end = time.monotonic() + timeout
        for key, publisher in self._publishers.items():
            while publisher.get_num_connections() == 0:
                self._require_nodes()
                if time.monotonic() > end or rospy.is_shutdown():
                    raise ReplayError(f"nobody listens to {publisher.resolved_name} ({key})")
                # Time has to be above zero for some nodes to start.
                self._clock.publish(rospy.Time.from_sec(max(0.001, self._bag.get_start_time())))
                time.sleep(0.05)
        self._wait_for_answering(end)

    def _require_nodes(self) -> None:
        wanted = (PERCEPTION, CONTROLLER) if self.controller else (PERCEPTION,)
        for name in ended_nodes(wanted):
            hint = "; controller:=false replays perception alone" if name == CONTROLLER else ""
            raise ReplayError(f"the node {name} has ended, its messages above say why{hint}")

    def _wait_for_answering(self, end: float) -> None:
        """Until what perception and docking node say is heard by everyone who listens."""
        master = rosgraph.Master(rospy.get_name())
        topics = [rospy.resolve_name(name) for name in (ANSWERS if self.controller else ANSWERS[:1])]
        while True:
            wanted = links(master, topics=topics)
            lacking = [link for link in wanted if not is_connected(master, *link)]
            if {topic for _, topic, _ in wanted} == set(topics) and not lacking:
                return
            self._require_nodes()
            if time.monotonic() > end or rospy.is_shutdown():
                raise ReplayError(f"not connected: {lacking or sorted(set(topics) - {t for _, t, _ in wanted})}")
            time.sleep(0.05)

    def run(self) -> Iterator[float]:
        """Yields the fraction that is done, 0..1."""
        first: float | None = None
        started = time.monotonic()
        for key, message, stamp in self.input.messages():
            if rospy.is_shutdown():
                raise ReplayError("interrupted")
            first = stamp.to_sec() if first is None else first
            elapsed = stamp.to_sec() - first
            if self._rate > 0.0:
                time.sleep(max(0.0, elapsed / self._rate - (time.monotonic() - started)))
            self._clock.publish(stamp)
            if key in self._publishers:
                self._publishers[key].publish(message)
                self._wait_for_answer(key, message.header.stamp)
            yield elapsed / self.length if self.length > 0.0 else 1.0

    def _wait_for_answer(self, key: str, stamp: rospy.Time) -> None:
        if key in ("odom", "obstacles"):
            self.answers.wait_for_done(key, stamp)
            self.obstacle_messages += key == "obstacles"
        elif key == "images" and not self.answers.wait_for_detections(stamp):
            self.unanswered += 1
            if self.unanswered >= GIVE_UP and not self.answers.detections:
                raise ReplayError(f"perception answers to no image: {self.why_unanswered()}")
        elif key == "images" and self.controller:
            self.answers.wait_for_done("detections", stamp)

    def why_unanswered(self) -> str:
        """In one line."""
        return self.answers.last_error or "the node marker_detector says nothing about it"

    def why_nothing(self) -> str:
        """In one line, why perception worked through no image; empty when it did."""
        if self.answers.detections:
            return ""
        return self.input.why_nothing() or f"perception answers to no image: {self.why_unanswered()}"

    def image_rows(self, chair: Chair) -> list[ImageRow]:
        """The dock in odom at each image's own time; without odometry, in base_link."""
        poses = self._odometry_poses() if self.input.odometry else None
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
        for _, message, _ in self._bag.read_messages(topics=[self.input.names["odom"]]):
            pose = message.pose.pose
            stamp = message.header.stamp.to_sec()
            rows.append([stamp, pose.position.x, pose.position.y, heading_of(pose.orientation)])
        return np.array(rows, dtype=float)

    def _recorded_commands(self) -> dict[rospy.Time, tuple[float, float]]:
        messages = self._bag.read_messages(topics=["velocity_request", "/velocity_request"])
        return {m.header.stamp: (m.twist.linear.x, m.twist.angular.z) for _, m, _ in messages}
