"""A camera with a known lens in front of a board: images drawn pixel by pixel, without the code that calibrates."""

from __future__ import annotations

import cv2
import numpy as np
from numpy.typing import NDArray

from seater_common.camera_model import CameraModel
from seater_tools.board.board import CHESSBOARD, DICTIONARY, MARKER, Board

Image = NDArray[np.uint8]
Array = NDArray[np.float64]
DENSITY = 8000.0  # [px/m] of the drawn board
MARGIN = 0.02  # [m] of white round it
SCALE = 3  # each pixel is the mean of so many squared; with 2 the focal length comes out off by 0.1 %


def texture(board: Board) -> Image:
    """Grey levels of the board with its margin, by OpenCV's own drawing where it has one."""
    side, margin = round(board.square * DENSITY), round(MARGIN * DENSITY)
    size = (board.columns * side, board.rows * side)
    if board.kind == CHESSBOARD:
        squares = np.add.outer(np.arange(board.rows), np.arange(board.columns)) % 2
        drawn = np.kron(255 * squares, np.ones((side, side))).astype(np.uint8)
    else:
        dictionary = cv2.aruco.getPredefinedDictionary(getattr(cv2.aruco, DICTIONARY))
        known = cv2.aruco.CharucoBoard_create(
            board.columns, board.rows, board.square, MARKER * board.square, dictionary
        )
        drawn = known.draw(size)
    return np.asarray(cv2.copyMakeBorder(drawn, *[margin] * 4, cv2.BORDER_CONSTANT, value=255))


def rays_of(lens: CameraModel) -> NDArray[np.float32]:
    """(height x SCALE, width x SCALE, 3) directions; between the pixels' middles they are straight enough."""
    fine = (np.arange(SCALE) + 0.5) / SCALE - 0.5
    u = (np.arange(lens.width)[:, None] + fine).ravel() + 1.0
    v = (np.arange(lens.height)[:, None] + fine).ravel() + 1.0
    x, y = np.meshgrid(u.astype(np.float32), v.astype(np.float32))
    rays = cv2.remap(lens.rays(1), x, y, cv2.INTER_LINEAR)
    return np.concatenate([rays, np.ones((*rays.shape[:2], 1), np.float32)], axis=-1)


def render(rays: NDArray[np.float32], pose: Array, drawn: Image, seed: int = 0) -> Image:
    """The board at `pose` (6,), rotation vector and translation in the optical frame; grey wall behind it."""
    R, t = cv2.Rodrigues(pose[:3])[0].astype(np.float32), pose[3:].astype(np.float32)
    along = (t @ R[:, 2]) / (rays @ R[:, 2])
    place = ((rays * along[..., None] - t) @ R[:, :2] + MARGIN) * DENSITY - 0.5
    place[~(along > 0.0)] = -1e6
    image = cv2.remap(drawn, place.astype(np.float32), None, cv2.INTER_LINEAR, borderValue=140)
    size = (rays.shape[1] // SCALE, rays.shape[0] // SCALE)
    image = cv2.resize(image, size, interpolation=cv2.INTER_AREA)
    image = cv2.GaussianBlur(0.8 * image.astype(float) + 20.0, (0, 0), 0.6)
    return np.clip(image + 2.0 * np.random.default_rng(seed).standard_normal(image.shape), 0, 255).astype(np.uint8)


def poses(board: Board, lens: CameraModel) -> list[Array]:
    """Twenty views: at every part of the image and tilted to all sides; three near ones in the middle.

    Distances are those of an image of 640 x 480 with a focal length of 420 px, in which the board fills as much.
    """
    # Part of the image [-1, 1] of the board's middle, distance [m], tilts about x and y, turn [rad].
    views = [
        (x, y, 0.42, 0.5 * (-1) ** k, 0.45 * (-1) ** (k // 2), 0.1 * k)
        for k, (x, y) in enumerate((x, y) for x in (-0.6, 0.0, 0.6) for y in (-0.4, 0.0, 0.4))
    ]
    reach = 0.62 if board.kind == CHESSBOARD else 0.8  # which may not reach over the edge, and may
    views += [(x, 1.03 * y, 0.32, 0.0, 0.0, 1.57) for x in (-reach, reach) for y in (-reach, reach)]
    views += [(0.0, 0.0, 0.17, 0.05 * k, -0.05 * k, 1.57 + 0.05 * k) for k in (-1, 0, 1)]
    views += [(0.1, 0.1, 0.4, 0.6, 0.0, 0.3), (0.1, -0.1, 0.45, -0.6, 0.0, -0.3)]
    views += [(-0.1, 0.1, 0.4, 0.0, 0.6, 0.8), (-0.1, -0.1, 0.45, 0.0, -0.6, -0.7)]
    return [placed(board, lens, *view) for view in views]


def placed(board: Board, lens: CameraModel, x: float, y: float, z: float, *angles: float) -> Array:
    """(6,) pose of the board whose middle is at (x, y) of the image [-1, 1]; `z`, `angles`: as in `poses`."""
    width, height, focal = lens.width, lens.height, float(lens.K[0, 0])
    axes = np.diag(angles)
    R = cv2.Rodrigues(axes[0])[0] @ cv2.Rodrigues(axes[1])[0] @ cv2.Rodrigues(axes[2])[0]
    z *= (focal / 420.0) / min(width / 640.0, height / 480.0)
    centre = z * np.array([x * 0.5 * width / focal, y * 0.5 * height / focal, 1.0])
    middle = board.square * np.array([0.5 * board.columns, 0.5 * board.rows, 0.0])
    return np.concatenate([cv2.Rodrigues(R)[0].ravel(), centre - R @ middle])
