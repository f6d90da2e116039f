"""The lens models as vectors of unknowns: fx, fy, cx, cy [px], then the distortion."""

from __future__ import annotations

from collections.abc import Sequence

import cv2
import numpy as np
from numpy.typing import NDArray

from seater_common.camera_model import CameraModel
from seater_tools.board.board import Board
from seater_tools.lens.find import View

Array = NDArray[np.float64]

COEFFICIENTS = {
    "plumb_bob": ("k1", "k2", "p1", "p2", "k3"),
    "rational_polynomial": ("k1", "k2", "p1", "p2", "k3", "k4", "k5", "k6"),
    "equidistant": ("k1", "k2", "k3", "k4"),
}
PINHOLE = ("fx", "fy", "cx", "cy")
FOCALS = (0.2, 0.3, 0.4, 0.5, 0.65, 0.8, 1.0, 1.3, 1.7)  # [image widths] tried as a beginning
FEWEST = 6  # corners that give a pose
_STOP = (cv2.TERM_CRITERIA_COUNT | cv2.TERM_CRITERIA_EPS, 100, 1e-10)


class LensError(ValueError):
    """The images do not give a calibration; the message says why."""


def names(model: str) -> tuple[str, ...]:
    """Of the unknowns."""
    return PINHOLE + COEFFICIENTS[model]


def camera_of(unknowns: Array, model: str, size: tuple[int, int]) -> CameraModel:
    """`size`: width, height [px]. P is left unknown."""
    fx, fy, cx, cy = unknowns[:4]
    K = np.array([[fx, 0.0, cx], [0.0, fy, cy], [0.0, 0.0, 1.0]])
    return CameraModel(*size, model, np.array(unknowns[4:]), K, np.eye(3), np.zeros((3, 4)))


def first_guess(views: Sequence[View], board: Board, model: str, size: tuple[int, int]) -> tuple[Array, Array]:
    """(unknowns, poses (views, 6): rotation vector and translation of the board in the optical frame).

    Raises LensError: there is none.
    """
    if model == "equidistant":  # OpenCV's own calibration of it fails on boards that lie straight ahead
        return _undistorted_guess(views, board, model, size)
    flags = cv2.CALIB_RATIONAL_MODEL if model == "rational_polynomial" else 0
    points = [board.points()[view.ids].astype(np.float32) for view in views]
    corners = [view.corners.astype(np.float32)[:, None] for view in views]
    try:
        _, K, D, r, t = cv2.calibrateCamera(points, corners, size, None, None, flags=flags, criteria=_STOP)
    except cv2.error as error:
        raise LensError(f"OpenCV finds no {model} lens in these images: {str(error).strip()[:200]}") from error
    D = np.ravel(D)[: len(COEFFICIENTS[model])]
    poses = np.column_stack([np.reshape(r, (-1, 3)), np.reshape(t, (-1, 3))])
    return np.concatenate([[K[0, 0], K[1, 1], K[0, 2], K[1, 2]], D]), poses


def _undistorted_guess(views: Sequence[View], board: Board, model: str, size: tuple[int, int]) -> tuple[Array, Array]:
    """Without distortion, at the focal length that explains the views best."""
    best: tuple[float, Array, Array] | None = None
    for focal in FOCALS:
        unknowns = np.zeros(len(names(model)))
        unknowns[:4] = [focal * size[0], focal * size[0], 0.5 * (size[0] - 1), 0.5 * (size[1] - 1)]
        camera = camera_of(unknowns, model, size)
        try:
            poses = np.array([board_pose(view, board, camera) for view in views])
        except LensError:
            continue
        drawn = [project(board.points()[v.ids], pose, unknowns, model) for v, pose in zip(views, poses, strict=True)]
        off = float(np.median([np.median(np.abs(d - v.corners)) for d, v in zip(drawn, views, strict=True)]))
        if best is None or off < best[0]:
            best = off, unknowns, poses
    if best is None:
        raise LensError(f"no focal length of a {model} lens explains these views")
    return best[1], best[2]


def board_pose(view: View, board: Board, camera: CameraModel) -> Array:
    """(6,) about where the board lies. Raises LensError: nowhere."""
    rays = camera.ray(view.corners)
    good = np.all(np.isfinite(rays), axis=1)
    if np.count_nonzero(good) >= FEWEST:
        points = board.points()[view.ids][good]
        for method in (cv2.SOLVEPNP_IPPE, cv2.SOLVEPNP_ITERATIVE):  # the first is nearly always right, and else NaN
            solved, r, t = cv2.solvePnP(points, rays[good], np.eye(3), np.zeros(4), flags=method)
            pose = np.concatenate([np.ravel(r), np.ravel(t)])
            if solved and np.all(np.isfinite(pose)) and pose[5] > 0.0:
                return pose
    raise LensError(f"{view.name}: the board has no pose")


def project(points: Array, pose: Array, unknowns: Array, model: str) -> Array:
    """(n, 2) [px] of points (n, 3) of the board that lies at `pose` (6,)."""
    K = np.array([[unknowns[0], 0.0, unknowns[2]], [0.0, unknowns[1], unknowns[3]], [0.0, 0.0, 1.0]])
    if model == "equidistant":
        return np.asarray(cv2.fisheye.projectPoints(points[:, None], pose[:3], pose[3:], K, unknowns[4:])[0][:, 0])
    return np.asarray(cv2.projectPoints(points, pose[:3], pose[3:], K, unknowns[4:])[0][:, 0])
