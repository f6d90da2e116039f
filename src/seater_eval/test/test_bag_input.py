"""Bags as others record them: what a replay takes out of them, and what it says when something is missing."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

import cv2
import numpy as np
import pytest
import rosbag
import rospy
from nav_msgs.msg import Odometry
from sensor_msgs.msg import CameraInfo, CompressedImage, Image

from seater_common.camera_model import CameraModel
from seater_eval.ros.bag_input import BagInput, Topics
from seater_eval.ros.replay_answers import ReplayError

PIXELS = np.arange(12, dtype=np.uint8).reshape(3, 4) * 20
TOPICS = Topics("camera/image_raw", "camera/camera_info", "odom")
CAMERA = Path(__file__).resolve().parents[3] / "config/cameras/d455.yaml"


def stamped(message: object, time: float) -> object:
    message.header.stamp = rospy.Time.from_sec(time)  # type: ignore[attr-defined]
    return message


def image(kind: str) -> Image | CompressedImage:
    if kind == "compressed":
        return CompressedImage(format="png", data=cv2.imencode(".png", PIXELS)[1].tobytes())
    if kind == "broken":
        return CompressedImage(format="png", data=b"no image")
    return Image(height=3, width=4, step=4, encoding="mono8", data=PIXELS.tobytes())


def bag_of(
    path: Path,
    *,
    kind: str = "raw",
    offset: float | None = 0.0,
    late: float = 0.0,
    odometry: Sequence[float] = (),
) -> rosbag.Bag:
    """Images of 1.0, 1.1 ... 1.9 s; a camera_info stamped `offset` s later (None: none) and recorded `late` s after."""
    suffix = "" if kind == "raw" else "/compressed"
    with rosbag.Bag(str(path), "w") as bag:
        for time in np.arange(10) / 10 + 1.0:
            bag.write(f"/camera/image_raw{suffix}", stamped(image(kind), time), rospy.Time.from_sec(time + 0.02))
            if offset is not None:
                info = stamped(CameraInfo(width=4, height=3), time + offset)
                bag.write("/camera/camera_info", info, rospy.Time.from_sec(time + 0.02 + late))
        for time in odometry:
            bag.write("/odom", stamped(Odometry(), time), rospy.Time.from_sec(time))
    return rosbag.Bag(str(path))


def played(source: BagInput) -> list[tuple[str, float]]:
    return [(key, round(message.header.stamp.to_sec(), 6)) for key, message, _ in source.messages()]


def times(start: float = 1.0) -> list[float]:
    return [round(start + i / 10, 6) for i in range(10)]


def test_pairs_go_out_together_in_recorded_order(tmp_path: Path) -> None:
    """An image waits for its camera_info; odometry that is recorded meanwhile comes before both."""
    source = BagInput(bag_of(tmp_path / "a.bag", late=0.03, odometry=(1.01, 1.04, 1.06)), TOPICS)
    assert source.odometry and source.images == 10
    assert played(source)[:5] == [("odom", 1.01), ("odom", 1.04), ("camera_info", 1.0), ("images", 1.0), ("odom", 1.06)]
    assert played(source)[-2:] == [("camera_info", 1.9), ("images", 1.9)]
    assert source.why_nothing() == "" and source.pairing_text() == []


def test_other_stamps_are_named_and_matched_on_demand(tmp_path: Path) -> None:
    bag = bag_of(tmp_path / "a.bag", offset=0.0123)
    exact = BagInput(bag, TOPICS)
    assert played(exact) == []
    assert exact.why_nothing() == (
        "none of 10 images has a camera_info of its own stamp; the nearest is 12.3 ms away"
        " (match_camera_info:=nearest takes it, calibration_file:=FILE does without)"
    )
    nearest = BagInput(bag, Topics("camera/image_raw", "camera/camera_info", "odom", match="nearest"))
    assert played(nearest) == [(key, t) for t in times() for key in ("camera_info", "images")]
    assert nearest.pairing_text() == ["camera_info of the nearest stamp was taken: up to 12.3 ms from its image"]
    with pytest.raises(ReplayError, match="match_camera_info is 'near', must be one of exact, nearest"):
        BagInput(bag, Topics("camera/image_raw", "camera/camera_info", "odom", match="near"))


def test_the_nearest_camera_info_is_before_or_after(tmp_path: Path) -> None:
    for offset, used in ((0.04, 1.04), (0.06, 1.06), (-0.03, 0.97)):
        bag = bag_of(tmp_path / "a.bag", offset=offset)
        source = BagInput(bag, Topics("camera/image_raw", "camera/camera_info", "odom", match="nearest"))
        assert len(played(source)) == 20
        # The first image has none before it; with 0.06 the others have one 0.04 before them.
        assert source.pairing.largest == pytest.approx(abs(used - 1.0), abs=1e-6)


def test_a_calibration_takes_the_place_of_camera_info(tmp_path: Path) -> None:
    bag = bag_of(tmp_path / "a.bag", offset=None)
    with pytest.raises(
        ReplayError, match=r"no topic camera/camera_info, it has no sensor_msgs/CameraInfo but /camera/"
    ):
        BagInput(bag, TOPICS)
    calibration = CameraModel.load(CAMERA)
    source = BagInput(bag, Topics("camera/image_raw", "camera/camera_info", "odom", calibration=calibration))
    messages = [(key, message) for key, message, _ in source.messages()]
    assert [key for key, _ in messages] == ["camera_info", "images"] * 10
    info, seen = messages[0][1], messages[1][1]
    assert info.header.stamp == seen.header.stamp and (info.width, info.K[0]) == (1280, 640.0)
    assert not source.odometry


def test_compressed_images_alone_are_decoded(tmp_path: Path) -> None:
    source = BagInput(bag_of(tmp_path / "a.bag", kind="compressed"), TOPICS)
    assert source.notes == ["the bag has /camera/image_raw/compressed only: images are decoded here"]
    seen = next(message for key, message, _ in source.messages() if key == "images")
    assert seen.encoding == "mono8"
    assert np.array_equal(np.frombuffer(seen.data, np.uint8).reshape(seen.height, seen.step), PIXELS)
    compressed = BagInput(source.bag, Topics("camera/image_raw", "camera/camera_info", "odom", "compressed"))
    assert compressed.notes == []
    assert next(m for key, m, _ in compressed.messages() if key == "images")._type == "sensor_msgs/CompressedImage"
    broken = BagInput(bag_of(tmp_path / "b.bag", kind="broken"), TOPICS)
    assert played(broken) == []
    assert broken.why_nothing() == "none of 10 compressed images can be decoded"


def test_missing_images_are_named(tmp_path: Path) -> None:
    bag = bag_of(tmp_path / "a.bag")
    with pytest.raises(ReplayError, match=r"no topic front/image, it has /camera/image_raw"):
        BagInput(bag, Topics("front/image", "camera/camera_info", "odom"))
    with pytest.raises(
        ReplayError, match=r"no topic camera/image_raw/compressed, it has no sensor_msgs/CompressedImage"
    ):
        BagInput(bag, Topics("camera/image_raw", "camera/camera_info", "odom", "compressed"))
