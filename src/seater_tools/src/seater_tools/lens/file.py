"""A calibration as a file of camera_info, as camera_calibration writes it, and with how certain it is."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import cv2
import numpy as np
from numpy.typing import NDArray

from seater_common.camera_model import COVARIANCE, CameraModel

Array = NDArray[np.float64]


def calibration_text(camera: CameraModel, name: str, comments: Sequence[str]) -> str:
    """`comments`: lines without their #. What camera.covariance says goes into a key that other tools pass over."""
    lines = [
        *(f"# {comment}" for comment in comments),
        f"image_width: {camera.width}",
        f"image_height: {camera.height}",
        f"camera_name: {name}",
        *_matrix("camera_matrix", camera.K),
        f"distortion_model: {camera.distortion_model}",
        *_matrix("distortion_coefficients", camera.D[None]),
        *_matrix("rectification_matrix", camera.R),
        *_matrix("projection_matrix", camera.P),
    ]
    if camera.covariance is not None:
        lines += ["# of fx, fy, cx, cy [px] and the distortion coefficients, for ./seater calibrate mount"]
        lines += _matrix(COVARIANCE, camera.covariance)
    return "\n".join(lines) + "\n"


def with_projection(camera: CameraModel) -> CameraModel:
    """With the P of a rectified image without black edges."""
    K, D, size = camera.K, camera.D, (camera.width, camera.height)
    if camera.distortion_model == "equidistant":
        new = cv2.fisheye.estimateNewCameraMatrixForUndistortRectify(K, D, size, np.eye(3), balance=0.0)
    else:
        new, _ = cv2.getOptimalNewCameraMatrix(K, D, size, 0.0)
    return replace(camera, P=np.column_stack([new, np.zeros(3)]))


def _matrix(name: str, values: Array) -> list[str]:
    data = ", ".join(f"{value:.9g}" for value in np.ravel(values))
    return [f"{name}:", f"  rows: {values.shape[0]}", f"  cols: {values.shape[1]}", f"  data: [{data}]"]
