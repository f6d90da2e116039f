"""Hostile camera_info: refused with what is wrong, or a camera of which everything is finite; nothing else."""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np
import yaml
from amount import MESSAGES
from hostile import Hostile
from sensor_msgs.msg import CameraInfo

from seater_common.camera_model import CameraModel
from seater_common.field_of_view import FieldOfView
from seater_nmpc.ros.camera import from_message

CONFIG = Path(__file__).resolve().parents[2] / "config"


def good() -> CameraInfo:
    camera = CameraModel.from_mapping(yaml.safe_load((CONFIG / "cameras" / "d455.yaml").read_text()))
    message = CameraInfo(width=camera.width, height=camera.height, distortion_model=camera.distortion_model)
    message.D, message.K = camera.D.tolist(), camera.K.ravel().tolist()
    message.R, message.P = camera.R.ravel().tolist(), camera.P.ravel().tolist()
    return message


def test_hostile_camera_info() -> None:
    hostile, refused = Hostile("camera_info"), 0
    for number in range(MESSAGES):
        message = hostile.spoil(good())
        try:
            camera = from_message(message)
            camera = camera.rectified() if number % 2 else camera
            seen = FieldOfView.of(camera)
        except ValueError:  # ParameterError among them: the node goes on without this camera, or does not start
            refused += 1
            continue
        assert all(np.all(np.isfinite(values)) for values in (camera.K, camera.D, camera.R, camera.P)), message
        assert all(math.isfinite(edge) for edge in vars(seen).values()), message
    assert 0 < refused < MESSAGES
