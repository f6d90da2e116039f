"""Messages of images and lenses; perception's word in its diagnostics."""

from pathlib import Path

import numpy as np
import pytest
from diagnostic_msgs.msg import DiagnosticArray, DiagnosticStatus, KeyValue
from std_msgs.msg import Header
from virtual import lens, picture

from seater_camera.ros.messages import CLIPPED, MARKERS, clipped_white, image_message, info_message

PERCEPTION = Path(__file__).resolve().parents[2] / "seater_perception/src/ros/ros_diagnostics.cpp"


def test_images() -> None:
    colour = picture(1)
    message = image_message(Header(frame_id="eye"), colour)
    assert (message.encoding, message.width, message.height, message.step) == ("bgr8", 64, 48, 192)
    assert np.array_equal(np.frombuffer(message.data, np.uint8).reshape(48, 64, 3), colour)
    grey = image_message(Header(), np.ascontiguousarray(colour[:, :, 0]))
    assert (grey.encoding, grey.step, len(grey.data)) == ("mono8", 64, 64 * 48)


def test_lenses() -> None:
    message = info_message(Header(frame_id="eye"), lens(), 64, 48)
    assert (message.header.frame_id, message.distortion_model) == ("eye", "plumb_bob")
    assert list(message.K) == [50.0, 0.0, 32.0, 0.0, 50.0, 24.0, 0.0, 0.0, 1.0]
    assert np.array_equal(np.reshape(message.P, (3, 4))[:, :3], np.reshape(message.K, (3, 3)))
    unknown = info_message(Header(), None, 64, 48)
    assert (unknown.width, unknown.height, unknown.K[0]) == (64, 48, 0.0)


@pytest.mark.parametrize(
    ("values", "told"),
    [
        ({MARKERS: "60", CLIPPED: "12.5"}, 0.125),
        ({MARKERS: "0", CLIPPED: "0"}, None),
        ({MARKERS: "3", CLIPPED: "much"}, None),
        ({"rate": "30"}, None),
    ],
)
def test_perceptions_word(values: dict[str, str], told: float | None) -> None:
    status = DiagnosticStatus(values=[KeyValue(key, value) for key, value in values.items()])
    assert clipped_white(DiagnosticArray(status=[DiagnosticStatus(), status])) == told


def test_perception_uses_these_words() -> None:
    source = PERCEPTION.read_text()
    assert f'"{MARKERS}"' in source and f'"{CLIPPED}"' in source
