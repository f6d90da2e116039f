"""Messages of a camera that a recording lacks: made of a calibration file, or of a compressed image."""

from __future__ import annotations

import sys

import cv2
import numpy as np
from sensor_msgs.msg import CameraInfo, CompressedImage, Image

from seater_common.camera_model import CameraModel
from seater_common.messages import camera_info_of


def info_message(camera: CameraModel) -> CameraInfo:
    """Without a header."""
    return CameraInfo(**camera_info_of(camera))


def decoded(message: CompressedImage) -> Image | None:
    """Its grey levels, of 8 or 16 bits as the detector decodes them; None when it cannot be decoded."""
    data = np.frombuffer(message.data, np.uint8)
    grey = cv2.imdecode(data, cv2.IMREAD_GRAYSCALE | cv2.IMREAD_ANYDEPTH) if len(data) else None
    if grey is None or grey.dtype not in (np.uint8, np.uint16):
        return None
    image = Image(header=message.header, height=grey.shape[0], width=grey.shape[1], step=grey.strides[0])
    image.encoding = "mono8" if grey.dtype == np.uint8 else "mono16"
    image.is_bigendian = int(sys.byteorder == "big")
    image.data = grey.tobytes()
    return image
