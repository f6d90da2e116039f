"""Images and lenses as messages; perception's word about the exposure out of diagnostics."""

from __future__ import annotations

import numpy as np
from diagnostic_msgs.msg import DiagnosticArray
from numpy.typing import NDArray
from sensor_msgs.msg import CameraInfo, Image
from std_msgs.msg import Header

from seater_common.camera_model import CameraModel
from seater_common.messages import camera_info_of

# As seater_perception's diagnostics say it; a test compares.
MARKERS, CLIPPED = "markers", "white of and round markers that is cut off [%]"


def image_message(header: Header, image: NDArray[np.uint8]) -> Image:
    """Of (height, width): mono8, of (height, width, 3): bgr8."""
    message = Image(header=header, encoding="mono8" if image.ndim == 2 else "bgr8")
    message.height, message.width = image.shape[:2]
    message.step = message.width * (1 if image.ndim == 2 else 3)
    message.data = image.tobytes()
    return message


def info_message(header: Header, lens: CameraModel | None, width: int, height: int) -> CameraInfo:
    """K = 0 where the lens is not known, as ROS has it. Without a projection of rectified images, P = [K 0]."""
    if lens is None:
        return CameraInfo(header=header, width=width, height=height)
    message = CameraInfo(header=header, **camera_info_of(lens))
    if not lens.P[0, 0] > 0.0:
        message.P = np.hstack([lens.K, np.zeros((3, 1))]).ravel().tolist()
    return message


def clipped_white(message: DiagnosticArray) -> float | None:
    """Share of the white round markers that is cut off; None: not told, or no markers seen."""
    for status in message.status:
        values = {entry.key: entry.value for entry in status.values}
        if CLIPPED in values and values.get(MARKERS, "0") != "0":
            try:
                return float(values[CLIPPED]) / 100.0
            except ValueError:
                return None
    return None
