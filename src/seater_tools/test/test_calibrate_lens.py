"""`./seater calibrate camera` as a person types it, boards on paper, and Debian's cameracalibrator beside it."""

from __future__ import annotations

import subprocess
from pathlib import Path

import cv2
import numpy as np
import pytest
from as_typed import run
from boards import LENSES, SIZE, camera, intrinsics

from seater_common.camera_model import CameraModel
from seater_tools.board.board import CHARUCO, CHESSBOARD, SQUARES, Board
from seater_tools.lens.find import View, find_board
from seater_tools.lens.fit import fit_lens
from seater_tools.sheets.draw.board_page import board_pdf
from seater_tools.sheets.layout.paper import PAPERS
from seater_tools.trial.board_views import poses, rays_of, render, texture

BOARD = Board()


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
    for i, pose in enumerate(poses(BOARD, lens)):
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
    assert found.covariance is not None
    off = np.array([*intrinsics(found), *found.D]) - [*intrinsics(lens), *lens.D]
    assert np.all(np.abs(off) < 4.0 * np.sqrt(np.diag(found.covariance))), off
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
    pose = poses(board, lens)[16]
    view = find_board(render(rays_of(lens), pose, texture(board)), board, "v")
    assert view is not None
    expected = lens.project(board.points() @ cv2.Rodrigues(pose[:3])[0].T + pose[3:])
    assert np.sqrt(np.mean((view.corners - expected) ** 2)) < 0.06


def test_a_board_sheet_by_the_command(tmp_path: Path) -> None:
    done = run("sheets", "--board", "charuco", "--paper", "a3", "--results", tmp_path)
    assert done.returncode == 0 and [p.name for p in tmp_path.iterdir()] == ["board_charuco_a3.pdf"]


@pytest.mark.extensive  # standard deviations are compared with OpenCV always
def test_debians_cameracalibrator_agrees() -> None:
    """On the same images of a chessboard, found and fitted by either."""
    calibrator = pytest.importorskip("camera_calibration.calibrator", reason="needs python3-camera-calibration")
    board, lens = Board(CHESSBOARD), camera("plumb_bob", LENSES["plumb_bob"])
    rays, drawn = rays_of(lens), texture(board)
    images = [render(rays, pose, drawn, i) for i, pose in enumerate(poses(board, lens)[::2])]
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
