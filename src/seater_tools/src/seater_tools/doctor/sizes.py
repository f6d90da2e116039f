"""Sizes of the prints, from images of a standing chair: the places of the markers in the dock's file say how long a
metre is, so each print's own size shows. Least squares over the dock's pose and the logarithm of each size."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import least_squares

from seater_common.camera_model import CameraModel
from seater_common.geometry import Dock, Marker
from seater_tools.doctor.observations import Sight

Array = NDArray[np.float64]

NOISE = 0.1  # [px] of a corner's mean over several images: what prints and lens models leave
FEWEST = 5  # images with a marker
LARGEST = 1.0  # of a logarithm: no print is off by more


@dataclass(frozen=True)
class SizeFit:
    """By marker id: `ratio` of its true size over the file's, with standard deviation `sd`; `off`: distance [m] of
    its centre from where the others leave it."""

    ratio: dict[int, float]
    sd: dict[int, float]
    off: dict[int, float]


def fit_sizes(sights: Sequence[Sight], camera: CameraModel, dock: Dock) -> SizeFit | None:
    """None: fewer than two markers are seen often enough, or no image says where the dock is."""
    corners = mean_corners(sights)
    markers = [marker for marker in dock.markers if marker.id in corners]
    start = next((sight.docks[0].T_optical_dock for sight in sights if sight.docks), None)
    if len(markers) < 2 or start is None or not np.all(np.isfinite(start)):
        return None
    measured = np.array([corners[marker.id] for marker in markers])

    def residuals(state: Array) -> Array:
        return np.asarray((_project(state, start, markers, camera) - measured).ravel() / NOISE)

    solved = least_squares(residuals, np.zeros(6 + len(markers)), x_scale=0.01, max_nfev=60)
    if not np.all(np.isfinite(solved.x)):
        return None
    spread = np.linalg.pinv(solved.jac.T @ solved.jac)
    left = solved.fun.reshape(-1, 4, 2) * NOISE
    sds = np.sqrt(np.diag(spread)[6:] * max(1.0, float(np.mean(solved.fun**2))))
    depth = (start[:3, :3] @ np.array([m.position for m in markers]).T)[2] + start[2, 3]
    off = np.linalg.norm(left.mean(axis=1), axis=1) * depth / camera.K[0, 0]
    ids = [marker.id for marker in markers]
    return SizeFit(
        ratio=dict(zip(ids, np.exp(solved.x[6:]).tolist(), strict=True)),
        sd=dict(zip(ids, sds.tolist(), strict=True)),
        off=dict(zip(ids, off.tolist(), strict=True)),
    )


def mean_corners(sights: Sequence[Sight]) -> dict[int, Array]:
    """(4, 2) [px] of each marker that FEWEST images show: medians, as single images may be wrong."""
    seen: dict[int, list[Array]] = {}
    for sight in sights:
        for marker in sight.markers:
            if np.all(np.isfinite(marker.corners)):
                seen.setdefault(marker.id, []).append(marker.corners)
    return {id: np.median(rows, axis=0) for id, rows in seen.items() if len(rows) >= FEWEST}


def _project(state: Array, start: Array, markers: list[Marker], camera: CameraModel) -> Array:
    """(n, 4, 2) [px]; state: rotation vector and shift of the dock against `start`, logarithms of the sizes."""
    import cv2

    turned, moved = cv2.Rodrigues(state[:3])[0], state[3:6]
    points = []
    for marker, log_size in zip(markers, np.clip(state[6:], -LARGEST, LARGEST), strict=True):
        T = start @ marker.T_dock_marker()
        square = marker.corners() * float(np.exp(log_size))
        points.append((square @ T[:3, :3].T + T[:3, 3]) @ turned.T + moved)
    flat = np.concatenate(points)
    flat[:, 2] = np.maximum(flat[:, 2], 0.01)  # a step that is far too long must not divide by zero
    return camera.project(flat).reshape(-1, 4, 2)
