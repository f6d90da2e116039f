"""The corners of a board in an image."""

from __future__ import annotations

from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import NDArray

from seater_tools.board.board import CHESSBOARD, DICTIONARY, MARKER, Board

Array = NDArray[np.float64]
Image = NDArray[np.uint8]

FEWEST_CORNERS = 8  # of a ChArUco board in an image; fewer say little and may lie on one line
SMALLEST_WINDOW, LARGEST_WINDOW = 2, 15  # [px] half a window of sub-pixel refinement
# Half a window over a square's side: it holds the four squares that meet, and no other corner or marker.
OF_CHESSBOARD, OF_CHARUCO = 0.4, 0.1


@dataclass(frozen=True, eq=False)
class View:
    """One image of the board. ids: (n,) of inner corners; corners: (n, 2) [px], a pixel's centre is integer."""

    name: str
    ids: NDArray[np.intp]
    corners: Array


def find_board(image: Image, board: Board, name: str) -> View | None:
    """The board in a grey image (height, width); None: it is not seen, or too little of it."""
    if board.kind == CHESSBOARD:
        return _find_chessboard(image, board, name)
    return _find_charuco(image, board, name)


def _find_chessboard(image: Image, board: Board, name: str) -> View | None:
    size = (board.columns - 1, board.rows - 1)
    found, corners = cv2.findChessboardCornersSB(image, size, flags=cv2.CALIB_CB_ACCURACY | cv2.CALIB_CB_EXHAUSTIVE)
    if not found:
        return None
    corners = corners.reshape(size[1], size[0], 2)
    if _grey(image, corners[0, 0:2], corners[1, 0:2]) > _grey(image, corners[0, 1:3], corners[1, 1:3]):
        corners = corners[::-1, ::-1]  # OpenCV began at the other end: the square of the first corners is black
    steps = [np.linalg.norm(np.diff(corners, axis=axis), axis=2).min() for axis in (0, 1)]
    refined = _refined(image, corners.reshape(-1, 2), OF_CHESSBOARD * float(min(steps)))
    return View(name, np.arange(size[0] * size[1]), refined)


def _refined(image: Image, corners: Array, window: float) -> Array:
    """(n, 2) where gradients meet; `window`: half of it [px]. The detectors' own corners are off by up to 0.7 px."""
    half = int(np.clip(window, SMALLEST_WINDOW, LARGEST_WINDOW))
    stop = (cv2.TERM_CRITERIA_COUNT | cv2.TERM_CRITERIA_EPS, 60, 1e-4)
    start = np.ascontiguousarray(corners, dtype=np.float32).reshape(-1, 1, 2)
    return np.asarray(cv2.cornerSubPix(image, start, (half, half), (-1, -1), stop).reshape(-1, 2), dtype=float)


def _grey(image: Image, above: Array, below: Array) -> float:
    """Mean grey level in the middle of the square between four corners."""
    x, y = np.concatenate([above, below]).mean(axis=0).round().astype(int)
    return float(image[max(y - 1, 0) : y + 2, max(x - 1, 0) : x + 2].mean())


def _find_charuco(image: Image, board: Board, name: str) -> View | None:
    dictionary = cv2.aruco.getPredefinedDictionary(getattr(cv2.aruco, DICTIONARY))
    square = board.square
    known = cv2.aruco.CharucoBoard_create(board.columns, board.rows, square, MARKER * square, dictionary)
    markers, ids, _ = cv2.aruco.detectMarkers(image, dictionary)
    if ids is None or len(ids) < 2:
        return None
    count, found, numbers = cv2.aruco.interpolateCornersCharuco(markers, ids, image, known, minMarkers=2)
    if count < FEWEST_CORNERS:
        return None
    side = float(np.median([cv2.arcLength(marker.reshape(-1, 2), True) / 4.0 for marker in markers]))
    return View(name, numbers.ravel().astype(int), _refined(image, found, OF_CHARUCO * side / MARKER))
