"""The renderer against closed forms, and the Cramer-Rao bound against Monte Carlo."""

import math
from dataclasses import replace
from pathlib import Path

import cv2
import numpy as np
import pytest

from seater_common.params import ParameterError
from seater_eval.perception.images.bound import cramer_rao
from seater_eval.perception.images.degraded_camera import DegradedCamera, load_degraded_camera
from seater_eval.perception.images.render import Print, box_of, clean_image, corners_of, exposed, moved, white_fraction

CONFIG = Path(__file__).resolve().parents[3] / "config"
CAMERA = DegradedCamera(640, 480, 600.0, 1.0, 3.0, 40.0, 215.0, 150.0, 1.0)


def facing(x: float, y: float, z: float, yaw: float = 0.0, roll: float = 0.0) -> np.ndarray:
    """T_optical_marker of a print that faces the camera, then is turned."""
    T = np.eye(4)
    turn = cv2.Rodrigues(np.array([0.0, yaw, 0.0]))[0]
    T[:3, :3] = turn @ np.diag([1.0, -1.0, -1.0]) @ cv2.Rodrigues(np.array([0.0, 0.0, roll]))[0]
    T[:3, 3] = [x, y, z]
    return T


@pytest.mark.parametrize("pose", [facing(0.01, -0.02, 0.5, 0.5, 0.1), facing(0.1, 0.05, 2.0, 0.3, 0.7)])
def test_converges_with_the_sampling(pose: np.ndarray) -> None:
    print_ = Print("DICT_4X4_50", 7, 0.1, pose)
    box = box_of(print_, CAMERA, 1.0, 5.0)
    default, finest = (white_fraction(print_, CAMERA, box, samples=s) for s in (None, 24))
    assert np.abs(default - finest).max() < 0.002  # of full contrast: 0.35 grey levels


def test_pixel_convention() -> None:
    """The blurred edges of a frontal print cross half contrast where the projected corners say (0.02 px)."""
    print_ = Print("DICT_4X4_50", 7, 0.1, facing(0.0123, -0.0231, 0.6))
    corners = corners_of(print_, CAMERA.K)
    box = box_of(print_, CAMERA, 1.0, 3.0)
    share = white_fraction(print_, CAMERA, box)
    row = share[round(corners[0, 1] - box[1]) + 8]  # within the black border's top row of cells
    column = share[:, round(corners[0, 0] - box[0]) + 8]
    for line, expected in ((row, corners[0, 0] - box[0]), (column, corners[0, 1] - box[1])):
        i = int(np.argmax((line[:-1] >= 0.5) & (line[1:] < 0.5)))
        crossing = i + (line[i] - 0.5) / (line[i] - line[i + 1])
        assert crossing == pytest.approx(expected, abs=0.02)


def test_blurred_edge_is_the_error_function() -> None:
    print_ = Print("DICT_4X4_50", 7, 0.2, facing(0.0, 0.0, 0.4))
    box = box_of(print_, CAMERA, 1.0, 3.0)
    left = corners_of(print_, CAMERA.K)[0, 0]
    row = white_fraction(print_, CAMERA, box)[round(corners_of(print_, CAMERA.K)[0, 1] - box[1]) + 20]
    for u in range(round(left) - 4, round(left) + 5):
        # mean over the pixel of the normal distribution function, by the midpoint rule
        inside = [0.5 * math.erfc((u - 0.5 + (k + 0.5) / 50 - left) / math.sqrt(2.0)) for k in range(50)]
        assert row[u - box[0]] == pytest.approx(np.mean(inside), abs=0.003)


def test_motion_widens_along_its_path_only() -> None:
    print_ = Print("DICT_4X4_50", 7, 0.2, facing(0.0, 0.0, 0.4))
    box = box_of(print_, CAMERA, 1.0, 8.0)
    corner = corners_of(print_, CAMERA.K)[0]
    moving = white_fraction(print_, CAMERA, box, motion=(6.0, 0.0))
    still = white_fraction(print_, CAMERA, box)
    row, column = round(corner[1] - box[1]) + 20, round(corner[0] - box[0]) + 20
    width = [1.0 / np.abs(np.diff(image[row, :column])).max() for image in (still, moving)]
    assert width[1] == pytest.approx(6.0, rel=0.05)
    assert width[0] < 3.0
    assert np.abs(moving[: row + 5, column] - still[: row + 5, column]).max() < 0.01


def test_levels_noise_and_wall() -> None:
    print_ = Print("DICT_4X4_50", 7, 0.1, facing(0.0, 0.0, 0.5))
    clean = clean_image([print_], CAMERA)
    assert clean.shape == (480, 640)
    assert clean[0, 0] == 150.0
    corner = corners_of(print_, CAMERA.K)[0]
    assert clean[round(corner[1]) + 10, round(corner[0]) + 10] == pytest.approx(40.0, abs=0.1)
    assert clean[round(corner[1]) - 10, round(corner[0])] == pytest.approx(215.0, abs=0.1)
    image = exposed(clean, 3.0, np.random.default_rng(1))
    assert image.dtype == np.uint8
    assert float(np.std(image[:50, :50])) == pytest.approx(math.hypot(3.0, math.sqrt(1 / 12)), rel=0.05)


def test_bound_is_the_spread_of_least_squares() -> None:
    """Maximum likelihood, one linear step from the truth, on 200 noisy images: its covariance is the bound's."""
    print_ = Print("DICT_4X4_50", 7, 0.1, facing(0.02, 0.01, 0.8, 0.4, 0.2))
    camera = replace(CAMERA, noise_sd=3.0)
    C = cramer_rao(print_, camera, psf=0, slope=False)
    box = box_of(print_, camera, 1.0, 1.0)
    black, white, _ = camera.levels
    steps = np.array([5e-5, 5e-5, 5e-4, 5e-3, 5e-3, 2e-3])  # other steps and sampling than the bound takes

    def grey(change: np.ndarray) -> np.ndarray:
        share = white_fraction(moved(print_, change), camera, box, samples=7, endless_paper=True)
        return (black + (white - black) * share).ravel()

    J = [(grey(step * e) - grey(-step * e)) / (2 * step) for step, e in zip(steps, np.eye(6), strict=True)]
    middle = grey(np.zeros(6))
    J = np.column_stack([*J, np.ones_like(middle), middle])
    random = np.random.default_rng(3)
    images = np.rint(middle[:, None] + 3.0 * random.standard_normal((len(middle), 200)))
    scale = np.linalg.norm(J, axis=0)
    errors = np.linalg.lstsq(J / scale, images - middle[:, None], rcond=None)[0][:6] / scale[:6, None]
    nees = np.einsum("in,ij,jn->n", errors, np.linalg.inv(C), errors)
    assert nees.mean() == pytest.approx(6.0, rel=0.12)  # four standard deviations of the mean
    assert np.diag(C) == pytest.approx(errors.var(axis=1), rel=0.45)


def test_bound_grows_with_unknowns_and_noise() -> None:
    print_ = Print("DICT_4X4_50", 7, 0.1, facing(0.02, 0.01, 0.8, 0.4, 0.2))
    full, less = cramer_rao(print_, CAMERA), cramer_rao(print_, CAMERA, psf=0, slope=False)
    assert np.all(np.diag(full) >= np.diag(less) * (1 - 1e-9))
    directed = cramer_rao(print_, CAMERA, psf=3)
    assert np.all(np.diag(directed) >= np.diag(full) * (1 - 1e-3))
    assert np.all(np.diag(directed) <= 1.5 * np.diag(full))
    noisy = cramer_rao(print_, replace(CAMERA, noise_sd=6.0))
    assert noisy == pytest.approx(full * (36.0 + 1 / 12) / (9.0 + 1 / 12))


def test_frozen_camera_is_read_strictly(tmp_path: Path) -> None:
    camera = load_degraded_camera(CONFIG / "cameras" / "degraded.yaml")
    assert (camera.image_width, camera.image_height, camera.focal_length) == (1280, 720, 640.0)
    assert camera.noise_sd == 3.0
    wrong = tmp_path / "wrong.yaml"
    text = (CONFIG / "cameras" / "degraded.yaml").read_text()
    wrong.write_text(text.replace("noise_sd: 3.0", "noise_sd: -1.0") + "\nunknown: 1\n")
    with pytest.raises(ParameterError, match=r"noise_sd: is -1\.0, must be a number from 0") as error:
        load_degraded_camera(wrong)
    assert "unknown: unknown key" in str(error.value)
