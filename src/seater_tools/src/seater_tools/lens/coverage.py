"""Which views of the board are missing, in words for whoever holds it."""

from __future__ import annotations

import math
from collections.abc import Sequence

import cv2
import numpy as np
from numpy.typing import NDArray

from seater_common.camera_model import CameraModel
from seater_tools.board.board import Board
from seater_tools.lens.find import View
from seater_tools.lens.model import LensError, board_pose

Array = NDArray[np.float64]

FEWEST_VIEWS = 15
BORDER = 0.15  # of the image's width and height: corners have to be seen within it, on each side and in each corner
FEWEST_AT_BORDER = 3  # corners of the board, in each of these regions
TILT = math.radians(
    20.0
)  # of the board against the line of sight, about both axes and both ways: shows the focal length
FEWEST_TILTED = 2  # views of each kind
NEAR = 0.30  # of the image's area is filled by a near board
FEWEST_NEAR = 3
ALIKE = (0.06, math.radians(7.0))  # of the image's width, and of tilt: a view nearer to another one says nothing new
REGIONS = (
    ("upper left corner", 0, 0),
    ("upper edge", 1, 0),
    ("upper right corner", 2, 0),
    ("left edge", 0, 1),
    ("right edge", 2, 1),
    ("lower left corner", 0, 2),
    ("lower edge", 1, 2),
    ("lower right corner", 2, 2),
)
TILTS = (
    ("upper edge towards the camera", 0, 1.0),
    ("lower edge towards the camera", 0, -1.0),
    ("left edge towards the camera", 1, -1.0),
    ("right edge towards the camera", 1, 1.0),
)


def missing_views(views: Sequence[View], board: Board, size: tuple[int, int], camera: CameraModel | None) -> list[str]:
    """Empty: enough. `camera`: about what it is; None: without distortion, of a usual focal length."""
    camera = camera or rough_camera(size)
    found = []
    if len(views) < FEWEST_VIEWS:
        found.append(f"{FEWEST_VIEWS - len(views)} more views that differ from each other")
    counts = _at_borders(views, size)
    found += [f"the board at the {name} of the image" for name, i, j in REGIONS if counts[j, i] < FEWEST_AT_BORDER]
    tilts = np.array([tilt_of(view, board, camera) for view in views]).reshape(-1, 2)
    for words, axis, way in TILTS:
        if np.count_nonzero(way * tilts[:, axis] >= TILT) < FEWEST_TILTED:
            found.append(f"the board tilted by 20 to 45 deg, its {words}")
    if sum(filled(view, size) >= NEAR for view in views) < FEWEST_NEAR:
        found.append(f"the board near, so that it fills {100 * NEAR:.0f} % of the image")
    return found


def rough_camera(size: tuple[int, int]) -> CameraModel:
    """70 deg wide."""
    focal = 0.7 * size[0]
    K = np.array([[focal, 0.0, 0.5 * (size[0] - 1)], [0.0, focal, 0.5 * (size[1] - 1)], [0.0, 0.0, 1.0]])
    return CameraModel(*size, "plumb_bob", np.zeros(5), K, np.eye(3), np.zeros((3, 4)))


def differs(view: View, others: Sequence[View], board: Board, size: tuple[int, int]) -> bool:
    """Whether it is worth keeping beside the others."""
    camera = rough_camera(size)
    middle, tilt, side = view.corners.mean(axis=0), tilt_of(view, board, camera), math.sqrt(filled(view, size))
    for other in others:
        shifted = float(np.linalg.norm(other.corners.mean(axis=0) - middle)) / size[0]
        grown = abs(math.sqrt(filled(other, size)) - side)
        turned = float(np.abs(tilt_of(other, board, camera) - tilt).max())
        if max(shifted, grown) < ALIKE[0] and turned < ALIKE[1]:
            return False
    return True


def filled(view: View, size: tuple[int, int]) -> float:
    """Part of the image's area within the hull of the corners."""
    hull = cv2.convexHull(view.corners.astype(np.float32))
    return float(cv2.contourArea(hull)) / (size[0] * size[1])


def tilt_of(view: View, board: Board, camera: CameraModel) -> Array:
    """(2,) [rad] of the board against the line of sight: positive when its upper, its right edge (in the image) is
    nearer. NaN: it has no pose."""
    try:
        pose = board_pose(view, board, camera)
    except LensError:
        return np.full(2, np.nan)
    normal = cv2.Rodrigues(pose[:3])[0][:, 2]  # away from the camera, when the board is seen from its front
    sight = np.append(camera.ray(view.corners.mean(axis=0)[None])[0], 1.0)
    normal = normal * math.copysign(1.0, float(normal @ sight))
    # Angles of normal against line of sight, in the planes y, z and x, z of the camera.
    up = math.atan2(normal[1], normal[2]) - math.atan2(sight[1], sight[2])
    aside = math.atan2(normal[0], normal[2]) - math.atan2(sight[0], sight[2])
    return np.array([-up, aside])


def _at_borders(views: Sequence[View], size: tuple[int, int]) -> NDArray[np.intp]:
    """(3, 3) corners of all views: rows top, middle, bottom of the image, columns left, middle, right."""
    counts = np.zeros((3, 3), dtype=np.intp)
    for view in views:
        part = view.corners / np.array(size)
        place = (part > BORDER).astype(int) + (part > 1.0 - BORDER).astype(int)
        np.add.at(counts, (place[:, 1], place[:, 0]), 1)
    return counts
