"""Lenses from drawn and from rendered views, boards on paper, and what is refused."""

from __future__ import annotations

import subprocess
from pathlib import Path

import cv2
import numpy as np
import pytest
from as_typed import run
from boards import SIZE, camera, poses, rays_of, render, texture

from seater_common.camera_model import CameraModel
from seater_tools.board.board import CHARUCO, CHESSBOARD, SQUARES, Board
from seater_tools.lens.coverage import differs, missing_views, tilt_of
from seater_tools.lens.find import View, find_board
from seater_tools.lens.fit import fit_lens, held_out_rms
from seater_tools.lens.result import calibrate, direction_sd
from seater_tools.sheets.draw.board_page import board_pdf
from seater_tools.sheets.layout.paper import PAPERS

LENSES = {
    "plumb_bob": (-0.22, 0.06, 0.0008, -0.0005, -0.005),
    "rational_polynomial": (0.3, 0.05, 0.0005, -0.0004, 0.005, 0.5, 0.1, 0.02),
    "equidistant": (0.05, -0.02, 0.01, -0.003),
}
NOISE = 0.08  # [px], as the detector has it
BOARD = Board()


def views_of(lens: CameraModel, board: Board = BOARD, seed: int = 0, noise: float = NOISE) -> list[View]:
    """What a detector would see of the board's poses: corners within the image, with noise."""
    rng, found = np.random.default_rng(seed), []
    for i, pose in enumerate(poses(board)):
        points = board.points() @ cv2.Rodrigues(pose[:3])[0].T + pose[3:]
        corners = lens.project(points)
        inside = np.all((corners > 3.0) & (corners < np.array(SIZE) - 4.0), axis=1)
        seen = corners[inside] + noise * rng.standard_normal((int(inside.sum()), 2))
        found.append(View(f"view {i}", np.flatnonzero(inside), seen))
    return found


def intrinsics(lens: CameraModel) -> np.ndarray:
    return np.array([lens.K[0, 0], lens.K[1, 1], lens.K[0, 2], lens.K[1, 2]])


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


@pytest.mark.parametrize("kind", [CHARUCO, CHESSBOARD])
@pytest.mark.parametrize("paper", ["a4", "a3"])
def test_the_printed_board_is_read(tmp_path: Path, kind: str, paper: str) -> None:
    board = Board(kind, square=SQUARES[paper])
    (tmp_path / "board.pdf").write_bytes(board_pdf(board, PAPERS[paper]))
    subprocess.run(["pdftoppm", "-r", "100", "-gray", str(tmp_path / "board.pdf"), str(tmp_path / "page")], check=True)
    (page,) = tmp_path.glob("*.pgm")
    image = cv2.GaussianBlur(cv2.imread(str(page), cv2.IMREAD_GRAYSCALE), (0, 0), 0.8)
    view = find_board(image, board, "page")
    assert view is not None and len(view.ids) == 54
    # A page is seen straight: corners are the board's points, scaled and shifted.
    points = board.points()[view.ids, :2]
    scale = 100.0 / 0.0254
    off = view.corners - scale * points
    assert np.abs(off - off.mean(axis=0)).max() < 0.25  # a quarter of a pixel of 100 dpi: 0.06 mm


@pytest.fixture(scope="module")
def photographs(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Rendered images of a ChArUco board through a known lens, and one without a board."""
    folder, lens = tmp_path_factory.mktemp("photographs"), camera("plumb_bob", LENSES["plumb_bob"])
    rays, drawn = rays_of(lens), texture(BOARD)
    for i, pose in enumerate(poses(BOARD)):
        cv2.imwrite(str(folder / f"{i:02d}.png"), render(rays, pose, drawn, i))
    cv2.imwrite(str(folder / "wall.png"), np.full(SIZE[::-1], 140, np.uint8))
    return folder


def test_the_command_writes_a_camera_info_that_is_right(photographs: Path, tmp_path: Path) -> None:
    words = ("camera", "--images", photographs, "--name", "my_camera", "--results", tmp_path)
    done = run("calibrate", *words)
    assert done.returncode == 0, done.stdout + done.stderr
    assert "20 of 21 images show the board; not wall.png" in done.stdout
    lens, found = camera("plumb_bob", LENSES["plumb_bob"]), CameraModel.load(tmp_path / "my_camera.yaml")
    assert intrinsics(found)[:2] == pytest.approx(intrinsics(lens)[:2], rel=0.0025)  # 3 sd of 20 views of 640 x 480
    assert intrinsics(found)[2:] == pytest.approx(intrinsics(lens)[2:], abs=1.0)
    assert found.P[0, 0] > 0.5 * found.K[0, 0]
    assert (tmp_path / "my_camera.png").stat().st_size > 10_000
    again = run("calibrate", *words)
    assert again.returncode == 1 and "exists already; --force" in again.stderr


def test_the_command_refuses_half_of_the_views(photographs: Path, tmp_path: Path) -> None:
    for path in sorted(photographs.glob("*.png"))[:8]:
        (tmp_path / path.name).write_bytes(path.read_bytes())
    done = run("calibrate", "camera", "--images", tmp_path, "--results", tmp_path / "out")
    assert done.returncode == 3
    assert "do not constrain the lens" in done.stdout and "missing: 7 more views" in done.stdout
    assert not (tmp_path / "out" / "camera.yaml").exists()


@pytest.mark.parametrize(
    ("words", "problem"),
    [
        (("--images", "nowhere"), "--images: nowhere is no folder"),
        (("--images", ".", "--name", "my camera"), "--name: is 'my camera'"),
        (("--images", ".", "--squares", "3", "9"), "--squares: is 3 x 9, must be 4 to 30 each"),
        (("--images", ".", "--squares", "20", "20"), "more than 100 white ones"),
        ((), "one of the arguments --images --topic is required"),
    ],
)
def test_wrong_input_is_named(words: tuple[str, ...], problem: str, tmp_path: Path) -> None:
    done = run("calibrate", "camera", *words, "--results", tmp_path / "out")
    assert done.returncode == 2 and problem in done.stderr


def test_images_of_two_sizes_are_refused(photographs: Path, tmp_path: Path) -> None:
    image = cv2.imread(str(photographs / "00.png"))
    cv2.imwrite(str(tmp_path / "a.png"), image)
    cv2.imwrite(str(tmp_path / "b.png"), image[:400])
    done = run("calibrate", "camera", "--images", tmp_path, "--results", tmp_path / "out")
    assert done.returncode == 2 and "images of several sizes: a.png 640 x 480, b.png 640 x 400" in done.stderr


def test_a_chessboard_is_seen_where_it_is() -> None:
    board, lens = Board(CHESSBOARD), camera("plumb_bob", LENSES["plumb_bob"])
    pose = poses(board)[16]
    view = find_board(render(rays_of(lens), pose, texture(board)), board, "v")
    assert view is not None
    expected = lens.project(board.points() @ cv2.Rodrigues(pose[:3])[0].T + pose[3:])
    assert np.sqrt(np.mean((view.corners - expected) ** 2)) < 0.06


def test_a_board_sheet_by_the_command(tmp_path: Path) -> None:
    done = run("sheets", "--board", "charuco", "--paper", "a3", "--results", tmp_path)
    assert done.returncode == 0 and [p.name for p in tmp_path.iterdir()] == ["board_charuco_a3.pdf"]


def test_debians_cameracalibrator_agrees() -> None:
    """On the same images of a chessboard, found and fitted by either."""
    calibrator = pytest.importorskip("camera_calibration.calibrator", reason="needs python3-camera-calibration")
    board, lens = Board(CHESSBOARD), camera("plumb_bob", LENSES["plumb_bob"])
    rays, drawn = rays_of(lens), texture(board)
    images = [render(rays, pose, drawn, i) for i, pose in enumerate(poses(board)[::2])]
    views = [view for view in (find_board(image, board, "v") for image in images) if view is not None]
    assert len(views) == len(images)
    ours = fit_lens(views, board, "plumb_bob", SIZE)
    theirs = calibrator.MonoCalibrator([calibrator.ChessboardInfo("chessboard", 9, 6, board.square)])
    corners = theirs.collect_corners(images)
    theirs.cal_fromcorners(corners)
    K = theirs.intrinsics
    found = np.array([K[0, 0], K[1, 1], K[0, 2], K[1, 2], *theirs.distortion.ravel()])
    # Their corners, our fit: the same minimum, but for a few that count less (Huber).
    turned = Board(CHESSBOARD, board.rows, board.columns)  # 9 inner corners across, as their detector has it
    again = fit_lens([View("v", np.arange(54), c[0].reshape(-1, 2)) for c in corners], turned, "plumb_bob", SIZE)
    sds = np.sqrt(np.diag(again.covariance))
    assert np.all(np.abs(again.unknowns - found) < 0.5 * sds), (again.unknowns - found, sds)
    # Each with its own corners: within three standard deviations of the difference.
    spread = np.hypot(sds, np.sqrt(np.diag(ours.covariance)))
    assert np.all(np.abs(ours.unknowns - found) < 3.0 * spread), (ours.unknowns - found, spread)
