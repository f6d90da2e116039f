"""Lenses from views whose corners are known, and what is refused."""

from __future__ import annotations

import cv2
import numpy as np
import pytest
from boards import LENSES, SIZE, camera, intrinsics

from seater_common.camera_model import CameraModel
from seater_tools.board.board import Board
from seater_tools.lens.coverage import differs, missing_views, tilt_of
from seater_tools.lens.find import View
from seater_tools.lens.fit import fit_lens, held_out_rms
from seater_tools.lens.result import calibrate, direction_sd
from seater_tools.trial.board_views import poses

NOISE = 0.08  # [px], as the detector has it
BOARD = Board()


def views_of(lens: CameraModel, board: Board = BOARD, seed: int = 0, noise: float = NOISE) -> list[View]:
    """What a detector would see of the board's poses: corners within the image, with noise."""
    rng, found = np.random.default_rng(seed), []
    for i, pose in enumerate(poses(board, lens)):
        points = board.points() @ cv2.Rodrigues(pose[:3])[0].T + pose[3:]
        corners = lens.project(points)
        inside = np.all((corners > 3.0) & (corners < np.array(SIZE) - 4.0), axis=1)
        seen = corners[inside] + noise * rng.standard_normal((int(inside.sum()), 2))
        found.append(View(f"view {i}", np.flatnonzero(inside), seen))
    return found


@pytest.mark.parametrize("model", LENSES)
def test_a_lens_is_found_within_its_standard_deviations(model: str) -> None:
    lens = camera(model, LENSES[model])
    normalised = []
    for seed in range(2):
        fit = fit_lens(views_of(lens, seed=seed), BOARD, model, SIZE)
        off = fit.unknowns[:4] - intrinsics(lens)
        assert np.all(np.abs(off[:2]) < 0.003 * lens.K[0, 0]), off
        assert fit.noise == pytest.approx(NOISE, rel=0.05)
        normalised.append(off / np.sqrt(np.diag(fit.covariance))[:4])
    assert np.abs(normalised).max() < 3.5
    # What counts is where directions are seen: everywhere in the image, but for a turn of the camera.
    assert direction_sd(fit) < 1.0


def test_standard_deviations_are_those_of_opencv() -> None:
    views = views_of(camera("plumb_bob", LENSES["plumb_bob"]))
    fit = fit_lens(views, BOARD, "plumb_bob", SIZE)
    points = [BOARD.points()[view.ids].astype(np.float32) for view in views]
    corners = [view.corners.astype(np.float32)[:, None] for view in views]
    _, K, _, _, _, sd, _, _ = cv2.calibrateCameraExtended(points, corners, SIZE, None, None)
    assert fit.unknowns[:4] == pytest.approx(np.array([K[0, 0], K[1, 1], K[0, 2], K[1, 2]]), abs=0.1)
    # OpenCV takes all residuals for one coordinate each, and divides by corners less unknowns, not by twice as many.
    ratio = np.sqrt(np.diag(fit.covariance)) / sd.ravel()[:9]
    assert np.all((ratio > 0.6) & (ratio < 1.1)), ratio
    assert ratio.max() / ratio.min() < 1.15, ratio


def test_views_held_out_are_as_good_as_those_fitted() -> None:
    lens = camera("plumb_bob", LENSES["plumb_bob"])
    held_out = held_out_rms(views_of(lens), BOARD, "plumb_bob", SIZE)
    assert held_out == pytest.approx(np.sqrt(2.0) * NOISE, rel=0.15)


def test_enough_views_are_accepted_and_parts_of_them_refused() -> None:
    lens = camera("plumb_bob", LENSES["plumb_bob"])
    views = views_of(lens)
    assert calibrate(views, BOARD, "plumb_bob", SIZE).refused == []
    middle = [view for view in views if np.all(np.abs(view.corners.mean(axis=0) - [320, 240]) < [100, 80])]
    few = calibrate(middle, BOARD, "plumb_bob", SIZE).refused
    assert "missing: the board at the upper left corner of the image" in few
    assert any("more views that differ" in words for words in few)


def test_boards_that_face_the_camera_leave_the_focal_length_open() -> None:
    """All at one distance and without tilt, the focal length and the distance cannot be told apart."""
    lens, board = camera("plumb_bob", (0.0,) * 5), BOARD
    views, rng = [], np.random.default_rng(1)
    for i in range(16):
        pose = np.array([0.0, 0.0, 0.1 * i, 0.0, 0.0, 0.4])
        pose[3:5] = np.array([-0.084, -0.12]) + 0.03 * rng.standard_normal(2)
        corners = lens.project(board.points() @ cv2.Rodrigues(pose[:3])[0].T + pose[3:])
        views.append(View(str(i), np.arange(len(corners)), corners + NOISE * rng.standard_normal(corners.shape)))
    refused = calibrate(views, board, "plumb_bob", SIZE).refused
    assert any(words.startswith("the focal length is uncertain") for words in refused), refused
    assert "missing: the board tilted by 20 to 45 deg, its left edge towards the camera" in refused


@pytest.mark.parametrize(
    ("turn", "words"),
    [
        ([0.5, 0.0, 0.0], "upper edge"),
        ([-0.5, 0.0, 0.0], "lower edge"),
        ([0.0, 0.5, 0.0], "right edge"),
        ([0.0, -0.5, 0.0], "left edge"),
    ],
)
def test_tilts_are_told_apart(turn: list[float], words: str) -> None:
    """By which edge of the board is nearer to the camera, and so longer in the image."""
    lens, R = camera("plumb_bob", (0.0,) * 5), cv2.Rodrigues(np.array(turn))[0]
    points = (BOARD.points() - [0.084, 0.12, 0.0]) @ R.T
    near = {
        "upper edge": points[points[:, 1] < 0.0, 2].mean(),
        "lower edge": points[points[:, 1] > 0.0, 2].mean(),
        "left edge": points[points[:, 0] < 0.0, 2].mean(),
        "right edge": points[points[:, 0] > 0.0, 2].mean(),
    }
    assert min(near, key=near.__getitem__) == words
    view = View("v", np.arange(len(points)), lens.project(points + [0.02, -0.03, 0.5]))
    up, right = tilt_of(view, BOARD, lens)
    wanted = {"upper edge": (1, 0), "lower edge": (-1, 0), "right edge": (0, 1), "left edge": (0, -1)}[words]
    assert (up, right) == pytest.approx(0.5 * np.array(wanted), abs=0.08)  # the line of sight is 3 deg off the axis
    missing = missing_views([view, view], BOARD, SIZE, lens)
    assert not any(f"its {words} towards the camera" in line for line in missing)
    assert sum("towards the camera" in line for line in missing) == 3


def test_a_view_like_another_is_not_kept() -> None:
    lens = camera("plumb_bob", LENSES["plumb_bob"])
    views = views_of(lens)
    again = views_of(lens, seed=1)
    assert not any(differs(view, views, BOARD, SIZE) for view in again)
    assert differs(views[0], views[5:], BOARD, SIZE)
