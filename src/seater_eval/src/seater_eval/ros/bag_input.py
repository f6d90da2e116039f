"""What a replay takes out of a bag: topics as they are there, and for each image its camera_info."""

from __future__ import annotations

import bisect
from collections.abc import Iterator
from copy import copy
from dataclasses import dataclass, field
from typing import Any

import rosbag
import rospy
from sensor_msgs.msg import CameraInfo

from seater_common.camera_model import CameraModel
from seater_eval.ros.camera_messages import decoded, info_message
from seater_eval.ros.replay_answers import ReplayError

COMPRESSED = "/compressed"
MATCHES = ("exact", "nearest")


@dataclass
class Topics:
    """Topic names in the bag, which form of images goes to perception, and where the calibration comes from."""

    image: str
    camera_info: str
    odom: str
    transport: str = "raw"
    obstacles: str = "obstacles"  # played where the bag has it
    match: str = "exact"  # nearest: the camera_info of the nearest stamp belongs to an image
    calibration: CameraModel | None = None  # in place of the bag's camera_info

    @property
    def images(self) -> str:
        return self.image + COMPRESSED if self.transport == "compressed" else self.image


@dataclass
class Pairing:
    """How images and camera_info fitted together."""

    images: int = 0  # that came by
    alone: int = 0  # without a camera_info
    undecodable: int = 0
    largest: float = 0.0  # [s] between the stamps of an image and of its camera_info
    nearest: float | None = None  # [s] of images that have none, to the next camera_info


def absolute(name: str) -> str:
    return name if name.startswith("/") else "/" + name


@dataclass
class BagInput:
    """The messages of one bag. Raises ReplayError: it has no images of this name, or no calibration."""

    bag: rosbag.Bag
    topics: Topics
    names: dict[str, str] = field(init=False)  # of topics in the bag, by images, camera_info, odom, obstacles
    decoding: bool = field(init=False, default=False)  # the bag has compressed images only, perception takes raw ones
    notes: list[str] = field(init=False, default_factory=list)  # for the person who started it
    pairing: Pairing = field(init=False, default_factory=Pairing)

    def __post_init__(self) -> None:
        if self.topics.match not in MATCHES:
            raise ReplayError(f"match_camera_info is {self.topics.match!r}, must be one of {', '.join(MATCHES)}")
        self._known = self.bag.get_type_and_topic_info()[1]
        self.names = {"images": self._image_topic()}
        for key in ("camera_info", "odom", "obstacles"):
            if name := self._find(getattr(self.topics, key)):
                self.names[key] = name
        if self.topics.calibration is not None:
            self.names.pop("camera_info", None)
        elif "camera_info" not in self.names:
            raise ReplayError(
                f"the bag has no topic {self.topics.camera_info}, it has {self._listed('sensor_msgs/CameraInfo')};"
                " calibration_file:=FILE takes its place"
            )
        if not self.images:
            raise ReplayError(f"the bag's topic {self.names['images']} has no message")

    @property
    def images(self) -> int:
        """How many the bag has."""
        return int(self._known[self.names["images"]].message_count)

    @property
    def odometry(self) -> bool:
        return "odom" in self.names

    def messages(self) -> Iterator[tuple[str, Any, rospy.Time]]:
        """(key of `names`, message, time of its recording), in recorded order.

        A camera_info goes out right before its image and with its stamp, when both have been recorded.
        """
        infos = self._infos()
        held: list[tuple[rospy.Time, Any, CameraInfo]] = []
        keys = {name: key for key, name in self.names.items() if key != "camera_info"}
        for name, message, stamp in self.bag.read_messages(topics=list(keys)):
            while held and held[0][0] <= stamp:
                yield from self._pair(*held.pop(0))
            if keys[name] != "images":
                yield keys[name], message, stamp
                continue
            self.pairing.images += 1
            info, recorded = self._info_of(message.header, infos)
            if info is None:
                self.pairing.alone += 1
            elif recorded is not None and recorded > stamp:
                held.append((recorded, message, info))
            else:
                yield from self._pair(stamp, message, info)
        for entry in held:
            yield from self._pair(*entry)

    def why_nothing(self) -> str:
        """In one line, why no image went out; empty when one did."""
        p = self.pairing
        if p.alone == p.images:
            away = "" if p.nearest is None else f"; the nearest is {1e3 * p.nearest:.1f} ms away"
            hint = "match_camera_info:=nearest takes it, calibration_file:=FILE does without"
            return f"none of {p.images} images has a camera_info of its own stamp{away} ({hint})"
        if p.alone + p.undecodable == p.images:
            return f"none of {p.undecodable} compressed images can be decoded"
        return ""

    def pairing_text(self) -> list[str]:
        """What did not fit, for a person."""
        p, lines = self.pairing, []
        if p.largest > 0.0:
            lines.append(f"camera_info of the nearest stamp was taken: up to {1e3 * p.largest:.1f} ms from its image")
        if p.alone:
            lines.append(f"{p.alone} of {p.images} images have no camera_info of their stamp: left out")
        if p.undecodable:
            lines.append(f"{p.undecodable} compressed images cannot be decoded: left out")
        return lines

    def _image_topic(self) -> str:
        if name := self._find(self.topics.images):
            return name
        if self.topics.transport == "raw" and (name := self._find(self.topics.image + COMPRESSED)):
            self.decoding = True
            self.notes.append(f"the bag has {name} only: images are decoded here")
            return name
        kind = "sensor_msgs/CompressedImage" if self.topics.transport == "compressed" else "sensor_msgs/Image"
        raise ReplayError(f"the bag has no topic {self.topics.images}, it has {self._listed(kind)}")

    def _find(self, wanted: str) -> str | None:
        return next((str(name) for name in self._known if wanted and absolute(name) == absolute(wanted)), None)

    def _listed(self, kind: str) -> str:
        """Topics of this type; when there are none, all."""
        names = sorted(name for name, info in self._known.items() if info.msg_type == kind)
        return ", ".join(names) if names else f"no {kind} but {', '.join(sorted(self._known)) or 'nothing'}"

    def _infos(self) -> list[tuple[float, rospy.Time, CameraInfo]]:
        """(stamp, time of the recording, message), by stamp."""
        if "camera_info" not in self.names:
            return []
        read = self.bag.read_messages(topics=[self.names["camera_info"]])
        return sorted(((m.header.stamp.to_sec(), t, m) for _, m, t in read), key=lambda entry: entry[0])

    def _info_of(
        self, header: Any, infos: list[tuple[float, rospy.Time, CameraInfo]]
    ) -> tuple[CameraInfo | None, rospy.Time | None]:
        """Under the image's header, with the time of its recording; None without one."""
        if self.topics.calibration is not None:
            info, recorded = info_message(self.topics.calibration), None
        else:
            stamp = header.stamp.to_sec()
            after = bisect.bisect_left(infos, stamp, key=lambda entry: entry[0])
            near = min(infos[max(0, after - 1) : after + 1], key=lambda entry: abs(entry[0] - stamp), default=None)
            if near is None:
                return None, None
            away = abs(near[0] - stamp)
            if self.topics.match == "exact" and near[2].header.stamp != header.stamp:
                self.pairing.nearest = min(away, self.pairing.nearest if self.pairing.nearest is not None else away)
                return None, None
            self.pairing.largest = max(self.pairing.largest, away)
            info, recorded = copy(near[2]), near[1]
        info.header = header
        return info, recorded

    def _pair(self, stamp: rospy.Time, image: Any, info: CameraInfo) -> Iterator[tuple[str, Any, rospy.Time]]:
        if self.decoding:
            image = decoded(image)
        if image is None:
            self.pairing.undecodable += 1
            return
        yield "camera_info", info, stamp
        yield "images", image, stamp
