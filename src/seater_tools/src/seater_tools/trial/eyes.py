"""Perception as the nodelet runs it."""

from __future__ import annotations

from typing import Any

import seater_perception as sp
from seater_common.camera_model import CameraModel


def make_tracker(camera: CameraModel, dock: Any, perception: Any, mount: Any) -> sp.DockTracker:
    """`dock`, `perception`, `mount`: contents of a dock file, of perception.yaml, and of `camera` in chair.yaml.

    Raises ValueError where the nodelet would not start.
    """
    K, D, P = ([float(value) for value in matrix.ravel()] for matrix in (camera.K, camera.D, camera.P))
    raw = sp.CameraModel.raw(sp.Calibration(camera.width, camera.height, K, D, camera.distortion_model, P))
    return sp.DockTracker(raw, sp.load_dock_layout(dock), perception, mount)
