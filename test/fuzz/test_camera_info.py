"""Hostile camera_info: refused with what is wrong, or a camera of which everything is finite; nothing else."""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np
import yaml
from amount import MESSAGES
from hostile import Hostile
from sensor_msgs.msg import CameraInfo

import seater_perception
from seater_common.camera_model import CameraModel
from seater_common.field_of_view import FieldOfView
from seater_common.geometry import Chair, Dock
from seater_common.params import load
from seater_nmpc.ros.camera import from_message
from seater_sim.camera.camera import Camera

CONFIG = Path(__file__).resolve().parents[2] / "config"


def good(camera: CameraModel | None = None) -> CameraInfo:
    camera = camera or CameraModel.from_mapping(yaml.safe_load((CONFIG / "cameras" / "d455.yaml").read_text()))
    message = CameraInfo(width=camera.width, height=camera.height, distortion_model=camera.distortion_model)
    message.D, message.K = camera.D.tolist(), camera.K.ravel().tolist()
    message.R, message.P = camera.R.ravel().tolist(), camera.P.ravel().tolist()
    return message


def test_hostile_camera_info() -> None:
    hostile, original, refused = Hostile("camera_info"), good(), 0
    for number in range(MESSAGES):
        message = hostile.spoil(original)
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


def small_camera() -> CameraModel:
    """A quarter of the pixels, so that an image takes some milliseconds."""
    values = yaml.safe_load((CONFIG / "cameras" / "d455.yaml").read_text())
    values["image_width"], values["image_height"] = values["image_width"] // 2, values["image_height"] // 2
    for name, keys in (("camera_matrix", (0, 2, 4, 5)), ("projection_matrix", (0, 2, 5, 6))):
        for key in keys:
            values[name]["data"][key] /= 2.0
    return CameraModel.from_mapping(values)


def test_hostile_camera_info_to_the_detector() -> None:
    """Its class refuses the calibration, or works the image through to what is finite."""
    camera, chair = small_camera(), Chair()
    values = yaml.safe_load((CONFIG / "docks" / "default.yaml").read_text())
    image = Camera(camera, chair.camera, load(Dock, values, "dock")).render([-1.5, 0.1, 0.0])
    layout = seater_perception.load_dock_layout(values)
    parameters = yaml.safe_load((CONFIG / "perception.yaml").read_text())
    hostile, original, refused, seen = Hostile("camera_info of the detector"), good(camera), 0, 0
    for number in range(MESSAGES):
        told = hostile.spoil(original)
        make = seater_perception.CameraModel.rectified if number % 2 else seater_perception.CameraModel.raw
        try:
            sizes = ((size + 2**31) % 2**32 - 2**31 for size in (told.width, told.height))  # as the nodelet's cast
            calibration = seater_perception.Calibration(*sizes, told.K, told.D, told.distortion_model, told.P)
            found = seater_perception.DockTracker(make(calibration), layout, parameters).detect(image)
        except (ValueError, RuntimeError):  # the node says so, and publishes nothing for this image
            refused += 1
            continue
        seen += bool(found.dock)
        for hypothesis in (*found.dock, *(h for marker in found.markers for h in marker.hypotheses)):
            values = (hypothesis.pose, hypothesis.covariance, hypothesis.error, hypothesis.weight)
            assert all(np.all(np.isfinite(value)) for value in values), told
    assert 0 < refused < MESSAGES and seen > 0
