"""The node that writes a small bag for each docking and undocking. It listens, and sends nothing.

Private parameters: ~folder, ~megabytes (of all bags), ~before, ~after [s] (of a goal), ~image (topic of an image that
is kept now and then, as a small JPEG; empty: none), ~image_period [s].
"""

from __future__ import annotations

import datetime
import io
import threading
from pathlib import Path
from typing import Any

import cv2
import rosbag
import rospy
from cv_bridge import CvBridge
from sensor_msgs.msg import CompressedImage, Image

from seater_msgs.msg import DockActionFeedback, DockActionResult, UndockActionFeedback, UndockActionResult
from seater_tools.episodes.disk import PART, has_room, make_room, remove_parts
from seater_tools.episodes.episode import Episode, Episodes
from seater_tools.episodes.ring import Entry, Ring
from seater_tools.episodes.topics import DOCK, TOPICS, UNDOCK

MOST_MEMORY = 64_000_000  # [bytes] of messages: minutes without images, which are small and few
WIDTH = 640  # [px] of the images
_POLL = 0.5  # [s] on the wall

# By its feedback a goal is known to go on: a client may send its goal before anybody but the docking node hears it.
_READ = {
    (DOCK, "feedback"): DockActionFeedback,
    (DOCK, "result"): DockActionResult,
    (UNDOCK, "feedback"): UndockActionFeedback,
    (UNDOCK, "result"): UndockActionResult,
}


class EpisodeRecorder:
    """One lock round ring and goals; bags are written by the timer's thread, while the chair stands."""

    def __init__(self) -> None:
        """Raises KeyError (a parameter is missing), ValueError (it is wrong) and OSError (no such folder)."""
        self._folder = Path(str(rospy.get_param("~folder"))).expanduser()
        self._most = int(1e6 * float(rospy.get_param("~megabytes")))
        if self._most <= 0:
            raise ValueError(f"~megabytes: is {self._most / 1e6}, must be above 0")
        self._folder.mkdir(parents=True, exist_ok=True)
        remove_parts(self._folder)
        self._lock, self._ring = threading.Lock(), Ring(float(rospy.get_param("~before")), MOST_MEMORY)
        self._episodes = Episodes(self._ring, float(rospy.get_param("~after")))
        for topic in TOPICS:
            rospy.Subscriber(topic, rospy.AnyMsg, self._on_message, callback_args=topic, queue_size=200)
        self._image, self._period = str(rospy.get_param("~image")), float(rospy.get_param("~image_period"))
        self._image_subscriber: Any = None
        self._image_at = float("-inf")

    def run(self) -> None:
        """Until the node ends: writes what is due, asks for an image now and then."""
        while not rospy.is_shutdown():
            self._write_due()
            self._ask_for_image()
            threading.Event().wait(_POLL)

    def _on_message(self, message: Any, topic: str) -> None:
        """rospy gives all subscribers of a topic the type of the first: goals and results are read here."""
        self._keep(message, rospy.resolve_name(topic))
        action, _, part = topic.partition("/")
        kind = _READ.get((action, part))
        if kind is None:
            return
        read = kind().deserialize(message._buff)
        with self._lock:
            if part == "feedback":
                self._episodes.goes_on(read.status.goal_id.id)
            else:
                self._episodes.result(read.status.goal_id.id, action, int(read.result.result_code), rospy.get_time())

    def _keep(self, message: Any, topic: str) -> None:
        header = message._connection_header
        sender = header.get("callerid", "") if header.get("latching") == "1" or topic == "/tf_static" else None
        with self._lock:
            self._ring.add(Entry(rospy.get_time(), topic, len(message._buff), message), sender)

    def _ask_for_image(self) -> None:
        """One, then no more for a while: nobody sends images that nobody takes."""
        now = rospy.get_time()
        if self._image and self._image_subscriber is None and not 0.0 <= now - self._image_at < self._period:
            self._image_at = now
            self._image_subscriber = rospy.Subscriber(self._image, Image, self._on_image, queue_size=1)

    def _on_image(self, message: Image) -> None:
        subscriber, self._image_subscriber = self._image_subscriber, None
        if subscriber is not None:
            subscriber.unregister()
            self._keep(small_jpeg(message), f"{rospy.resolve_name(self._image)}/compressed")

    def _write_due(self) -> None:
        with self._lock:
            episode = self._episodes.due(rospy.get_time(), datetime.datetime.now(datetime.UTC))
        if episode is None:
            return
        try:
            write(episode, self._folder)
            for path in make_room(self._folder, self._most):
                rospy.loginfo("removed the oldest bag, %s", path.name)
        except OSError as error:
            rospy.logerr("no bag of this docking: %s", error)


def small_jpeg(message: Image) -> rospy.AnyMsg:
    """As it would come over a topic of its own."""
    pixels = CvBridge().imgmsg_to_cv2(message, "bgr8")
    scale = min(1.0, WIDTH / pixels.shape[1])
    pixels = cv2.resize(pixels, None, fx=scale, fy=scale, interpolation=cv2.INTER_AREA)
    jpeg = CompressedImage(message.header, "jpeg", cv2.imencode(".jpg", pixels)[1].tobytes())
    buffer, small = io.BytesIO(), rospy.AnyMsg()
    jpeg.serialize(buffer)
    small._buff = buffer.getvalue()
    definition = {"type": jpeg._type, "md5sum": jpeg._md5sum, "message_definition": jpeg._full_text}
    small._connection_header = definition
    return small


def write(episode: Episode, folder: Path) -> Path:
    """The bag, complete or not there. Raises OSError."""
    size = sum(entry.size for entry in episode.entries)
    if not has_room(folder, size):
        raise OSError(f"the disk of {folder} is nearly full")
    if episode.dropped:
        rospy.logwarn("%s: %d messages found no room in memory", episode.name, episode.dropped)
    path = folder / f"{episode.name}.bag"
    part = path.with_name(path.name + PART)
    with rosbag.Bag(str(part), "w", compression=rosbag.Compression.BZ2) as bag:
        for entry in episode.entries:
            header = dict(entry.item._connection_header, topic=entry.topic)
            kind = type("Kind", (), {"_md5sum": header["md5sum"], "_type": header["type"]})  # what rosbag asks for
            raw = (header["type"], entry.item._buff, header["md5sum"], kind)
            time = rospy.Time.from_sec(max(entry.time, 1e-3))
            bag.write(entry.topic, raw, time, raw=True, connection_header=header)
    part.replace(path)
    return path
