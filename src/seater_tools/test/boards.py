"""Cameras with known lenses, for the tests."""

from __future__ import annotations

import numpy as np

from seater_common.camera_model import CameraModel

SIZE = (640, 480)

LENSES = {
    "plumb_bob": (-0.22, 0.06, 0.0008, -0.0005, -0.005),
    "rational_polynomial": (0.3, 0.05, 0.0005, -0.0004, 0.005, 0.5, 0.1, 0.02),
    "equidistant": (0.05, -0.02, 0.01, -0.003),
}


def camera(model: str, D: tuple[float, ...], focal: float = 420.0) -> CameraModel:
    K = np.array([[focal, 0.0, 322.5], [0.0, focal * 1.004, 236.0], [0.0, 0.0, 1.0]])
    return CameraModel(*SIZE, model, np.array(D), K, np.eye(3), np.zeros((3, 4)))


def intrinsics(lens: CameraModel) -> np.ndarray:
    return np.array([lens.K[0, 0], lens.K[1, 1], lens.K[0, 2], lens.K[1, 2]])
