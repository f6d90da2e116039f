"""The camera's geometry against OpenCV's, and wrong files."""

from collections.abc import Callable
from typing import Any

import cv2
import numpy as np
import pytest

from seater_common.camera_model import CameraModel
from seater_common.params import ParameterError


@pytest.mark.parametrize("lens", ["plumb_bob", "rational_polynomial"])
def test_projection_is_opencvs(with_lens: Callable[[str], CameraModel], lens: str) -> None:
    model = with_lens(lens)
    points = np.random.default_rng(2).uniform([-0.9, -0.5, 1.0], [0.9, 0.5, 1.2], (100, 3))
    expected = cv2.projectPoints(points, np.zeros(3), np.zeros(3), model.K, model.D)[0].reshape(-1, 2)
    np.testing.assert_allclose(model.project(points), expected, atol=1e-9)
    assert model.distorted


@pytest.mark.parametrize("lens", ["plumb_bob", "rational_polynomial"])
def test_rays_are_the_inverse_of_projection(with_lens: Callable[[str], CameraModel], lens: str) -> None:
    model = with_lens(lens)
    rays = model.rays(margin=2)
    assert rays.shape == (724, 1284, 2)
    for u, v in [(0, 0), (1279, 719), (640, 360), (100, 600)]:
        x, y = rays[v + 2, u + 2]
        np.testing.assert_allclose(model.project(np.array([[x, y, 1.0]])), [[u, v]], atol=2e-3)


def test_wrong_files_are_named(camera_values: dict[str, Any]) -> None:
    def with_change(**changes: object) -> dict[str, Any]:
        return camera_values | changes

    cases = [
        (with_change(distortion_model="fisheye"), "camera/distortion_model: is 'fisheye', must be one of plumb_bob"),
        (with_change(image_width="wide"), "camera/image_width: is 'wide'"),
        (with_change(camera_matrix={"data": [1.0, 2.0]}), "camera/camera_matrix/data: is .* list of 9 numbers"),
        (with_change(camera_matrix={"data": [0.0] * 9}), "camera/camera_matrix: focal lengths 0.0, 0.0 must be > 0"),
        (with_change(projection_matrix={"data": [float("nan")] * 12}), "camera/projection_matrix/data: .* finite"),
        (with_change(distortion_coefficients=None), "camera/distortion_coefficients/data: is None"),
        ("d455.yaml", "camera: is 'd455.yaml', must be a mapping"),
    ]
    for values, message in cases:
        with pytest.raises(ParameterError, match=message):
            CameraModel.from_mapping(values)
