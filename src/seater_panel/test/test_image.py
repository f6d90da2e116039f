"""Images for the page: reduced, and only what is an annotated image."""

import cv2
import numpy as np
import pytest
from sensor_msgs.msg import Image

from seater_panel.ros.image import pixels, to_jpeg


def message(width: int, height: int, *, step: int = 0, encoding: str = "bgr8") -> Image:
    image = Image(width=width, height=height, step=step or 3 * width, encoding=encoding)
    image.data = bytes(image.step * height)
    return image


def test_an_image_is_reduced_to_what_a_phone_shows() -> None:
    decoded = cv2.imdecode(np.frombuffer(to_jpeg(np.zeros((720, 1280, 3), np.uint8)), np.uint8), cv2.IMREAD_COLOR)
    assert decoded.shape == (450, 800, 3)


def test_rows_may_be_padded() -> None:
    padded = message(4, 2, step=16)
    padded.data = b"".join(bytes([row] * 12) + b"pad!" for row in (7, 9))
    found = pixels(padded)
    assert found is not None
    assert found.shape == (2, 4, 3)
    assert [int(row[0, 0]) for row in found] == [7, 9]
    assert int(found.max()) == 9


BAD = [
    message(4, 2, encoding="mono8"),
    message(4, 2, step=6),
    message(0, 0),
    message(4, 0),
    Image(width=4, height=2, step=12, encoding="bgr8"),
]


@pytest.mark.parametrize("bad", BAD, ids=["grey", "short rows", "empty", "flat", "without pixels"])
def test_what_is_no_annotated_image_is_left_out(bad: Image) -> None:
    assert pixels(bad) is None
