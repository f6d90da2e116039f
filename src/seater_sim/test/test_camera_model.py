"""The camera's geometry against OpenCV's, and wrong files."""

from collections.abc import Callable
from pathlib import Path
from typing import Any

import cv2
import numpy as np
import pytest

from seater_common.camera_model import CameraModel
from seater_common.params import ParameterError

LENSES = ["plumb_bob", "rational_polynomial", "equidistant"]
CONFIG = Path(__file__).resolve().parents[3] / "config"


@pytest.mark.parametrize("lens", LENSES)
def test_projection_is_opencvs(with_lens: Callable[[str], CameraModel], lens: str) -> None:
    model = with_lens(lens)
    points = np.random.default_rng(2).uniform([-0.9, -0.5, 1.0], [0.9, 0.5, 1.2], (100, 3))
    zero = np.zeros(3)
    if lens == "equidistant":
        expected = cv2.fisheye.projectPoints(points[:, None], zero, zero, model.K, model.D)[0]
    else:
        expected = cv2.projectPoints(points, zero, zero, model.K, model.D)[0]
    np.testing.assert_allclose(model.project(points), expected.reshape(-1, 2), atol=1e-9)
    assert model.distorted


@pytest.mark.parametrize("lens", LENSES)
def test_rays_are_the_inverse_of_projection(with_lens: Callable[[str], CameraModel], lens: str) -> None:
    model = with_lens(lens)
    rays = model.rays(margin=2)
    assert rays.shape == (724, 1284, 2)
    for u, v in [(0, 0), (1279, 719), (640, 360), (100, 600)]:
        x, y = rays[v + 2, u + 2]
        np.testing.assert_allclose(model.project(np.array([[x, y, 1.0]])), [[u, v]], atol=2e-3)


def test_fisheye_beyond_the_hemisphere(camera_values: dict[str, Any]) -> None:
    # f = 280 px: the image's left edge is 131 degrees off the axis, where no ray (x / z) is.
    K = [280.0, 0.0, 640.0, 0.0, 280.0, 360.0, 0.0, 0.0, 1.0]
    lens = {"distortion_model": "equidistant", "distortion_coefficients": {"data": [0.0] * 4}}
    model = CameraModel.from_mapping(camera_values | lens | {"camera_matrix": {"data": K}})
    rays = model.ray(np.array([[640.0, 360.0], [640.0 + 280.0 * np.pi / 3, 360.0], [640.0 - 280.0 * 1.6, 360.0]]))
    np.testing.assert_allclose(rays[:2], [[0.0, 0.0], [np.tan(np.pi / 3), 0.0]], atol=1e-6)
    assert np.all(np.isnan(rays[2]))
    everywhere = model.rays(margin=2)
    assert np.all(np.isfinite(everywhere))
    assert everywhere[362, 2, 0] == pytest.approx(-np.tan(1.5), rel=1e-3)


@pytest.mark.parametrize("name", ["", "Inverse Brown Conrady", "distortion.brown_conrady", "None"])
def test_names_without_coefficients(camera_values: dict[str, Any], name: str) -> None:
    for data in ([], [0.0] * 5):
        lens = {"distortion_model": name, "distortion_coefficients": {"data": data}}
        assert not CameraModel.from_mapping(camera_values | lens).distorted
    lens = {"distortion_model": name, "distortion_coefficients": {"data": [0.1, 0.0, 0.0, 0.0, 0.0]}}
    with pytest.raises(ParameterError, match=r"is .* with D = .*, must be one of plumb_bob \(4 or 5 coefficients\)"):
        CameraModel.from_mapping(camera_values | lens)


def test_files_of_opencv(tmp_path: Path, camera_values: dict[str, Any]) -> None:
    path = tmp_path / "camera.yml"
    file = cv2.FileStorage(str(path), cv2.FILE_STORAGE_WRITE)
    file.write("image_width", 640)
    file.write("image_height", 480)
    K = np.array([[600.0, 0.0, 320.5], [0.0, 601.0, 240.5], [0.0, 0.0, 1.0]])
    file.write("camera_matrix", K)
    file.write("distortion_coefficients", np.array([[0.1], [-0.2], [0.001], [0.0], [0.05]]))
    file.release()
    model = CameraModel.load(path)
    assert (model.width, model.height, model.distortion_model) == (640, 480, "plumb_bob")
    np.testing.assert_array_equal(model.K, K)
    np.testing.assert_array_equal(model.D, [0.1, -0.2, 0.001, 0.0, 0.05])
    with pytest.raises(ParameterError, match="projection_matrix: is missing"):
        model.rectified()
    path.write_text(path.read_text() + "fisheye_model: 1\n")
    with pytest.raises(ParameterError, match="has 5, must have 4 for equidistant"):
        CameraModel.load(path)
    path.write_text("just text")
    with pytest.raises(ParameterError, match=r"camera.yml: is 'just text', must be a mapping"):
        CameraModel.load(path)
    ros = CameraModel.load(CONFIG / "cameras" / "d455.yaml")
    np.testing.assert_array_equal(ros.P, CameraModel.from_mapping(camera_values).P)


def test_wrong_files_are_named(camera_values: dict[str, Any]) -> None:
    def with_change(**changes: object) -> dict[str, Any]:
        return camera_values | changes

    cases = [
        (with_change(distortion_model="fisheye"), "camera/distortion_model: is 'fisheye' with .* one of plumb_bob"),
        (with_change(distortion_model="equidistant", distortion_coefficients={"data": []}), "has 0, must have 4 for"),
        (with_change(image_width="wide"), "camera/image_width: is 'wide'"),
        (with_change(camera_matrix={"data": [1.0, 2.0]}), "camera/camera_matrix/data: is .* list of 9 numbers"),
        (with_change(camera_matrix={"data": [0.0] * 9}), "camera/camera_matrix: focal lengths 0.0, 0.0 must be > 0"),
        (with_change(projection_matrix={"data": [float("nan")] * 12}), "camera/projection_matrix/data: .* finite"),
        (with_change(distortion_coefficients={"data": [0.1] * 8}), "data: has 8, must have 4 or 5 for plumb_bob"),
        (with_change(distortion_coefficients=None), "camera/distortion_coefficients/data: is None"),
        ("d455.yaml", "camera: is 'd455.yaml', must be a mapping"),
    ]
    for values, message in cases:
        with pytest.raises(ParameterError, match=message):
            CameraModel.from_mapping(values)
