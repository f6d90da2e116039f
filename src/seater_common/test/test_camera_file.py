"""What a calibration says of how certain it is."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from seater_common.camera_model import COVARIANCE, CameraModel
from seater_common.params import ParameterError

ROOT = np.diag([0.2, 0.2, 0.3, 0.3, *[1e-3] * 5]) @ (np.eye(9) + 0.3 * np.eye(9, k=1))
GOOD = ROOT @ ROOT.T


def values(covariance: Any = None) -> dict[str, Any]:
    found = {
        "image_width": 64,
        "image_height": 48,
        "camera_matrix": {"data": [60.0, 0.0, 31.5, 0.0, 60.0, 23.5, 0.0, 0.0, 1.0]},
        "distortion_model": "plumb_bob",
        "distortion_coefficients": {"data": [-0.05, 0.01, 0.0, 0.0, 0.0]},
    }
    return found if covariance is None else found | {COVARIANCE: {"data": np.ravel(covariance).tolist()}}


def test_a_covariance_is_read_and_need_not_be_there() -> None:
    assert CameraModel.from_mapping(values()).covariance is None
    read = CameraModel.from_mapping(values(GOOD)).covariance
    assert read is not None and np.array_equal(read, GOOD)


@pytest.mark.parametrize(
    ("covariance", "problem"),
    [
        (np.eye(4), "must be a list of 81 numbers"),
        (np.triu(GOOD), "not symmetric"),
        (np.diag([-1.0, *[1.0] * 8]), "variance that is not > 0"),
        (np.full((9, 9), -1.0) + 2.0 * np.eye(9), "contradict each other"),
        (np.full((9, 9), np.nan), "must be finite"),
    ],
)
def test_what_is_no_covariance_is_refused(covariance: np.ndarray, problem: str) -> None:
    with pytest.raises(ParameterError, match=rf"camera/parameter_covariance.*{problem}"):
        CameraModel.from_mapping(values(covariance))
