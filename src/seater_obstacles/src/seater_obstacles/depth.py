"""Clouds and depth images as a sight: what is floor and what stands on it."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike, NDArray

from seater_obstacles.settings import SenseSettings
from seater_obstacles.sight import Sight, View

Array = NDArray[np.float64]

_MILLIMETRE = 1e-3
_RAYS = 0.02  # [rad] between two columns of a cloud at most; less does not matter


def cloud_sight(points: ArrayLike, T_base_sensor: ArrayLike, settings: SenseSettings) -> Sight:
    """The sight of points (n, 3) [m] in the sensor's frame; not finite: not measured.

    Along each bearing nothing stands from the nearest floor that is seen (nearer, the view may pass over a low thing)
    to the nearest point above the floor, or to the farthest floor.
    """
    T = np.asarray(T_base_sensor, dtype=float)
    given = np.asarray(points, dtype=float).reshape(-1, 3)
    p = given[np.isfinite(given).all(axis=1)] @ T[:3, :3].T + T[:3, 3]
    origin = T[:2, 3]
    offsets = p[:, :2] - origin
    distance, bearings = np.hypot(offsets[:, 0], offsets[:, 1]), np.arctan2(offsets[:, 1], offsets[:, 0])
    floor = np.abs(p[:, 2]) <= settings.floor + settings.floor_slope * distance
    stands = (p[:, 2] > 0.0) & ~floor & (p[:, 2] <= settings.top)
    view = _view(origin, bearings, distance, floor, stands)
    near = np.hypot(p[:, 0], p[:, 1]) <= settings.max_range
    return Sight(p[stands & near, :2], view, len(p))


def _view(origin: Array, bearings: Array, distance: Array, floor: NDArray[np.bool_], stands: NDArray[np.bool_]) -> View:
    view = View(origin, bearings[:0], distance[:0], distance[:0], _RAYS)
    bins, count = view.bins(bearings), len(view.free)
    nearest, farthest, first = np.full(count, np.inf), np.full(count, -np.inf), np.full(count, np.inf)
    np.minimum.at(nearest, bins[floor], distance[floor])
    np.maximum.at(farthest, bins[floor], distance[floor])
    np.minimum.at(first, bins[stands], distance[stands])
    view.near = nearest
    view.free = np.where(np.isfinite(first), first, farthest)
    return view


class DepthImages:
    """Depth images of one camera as clouds; the rays are computed once per calibration."""

    def __init__(self, stride: int) -> None:
        """`stride` [px]: every so manieth row and column is used."""
        self._stride = stride
        self._key: tuple[float, ...] = ()
        self._rays = np.empty((0, 0, 3))

    def cloud(self, depth: NDArray[np.generic], K: ArrayLike) -> Array:
        """Points (n, 3) [m] in the optical frame (z forward, x right, y down) of what was measured.

        Args:
            depth: (height, width) along the optical axis: float32 [m] or uint16 [mm]; 0, NaN: not measured.
            K: (3, 3) of the rectified image [px].

        Raises:
            ValueError: another type of pixel, or a K that is not finite or has no focal length.
        """
        if depth.ndim != 2 or depth.dtype not in (np.float32, np.uint16):
            raise ValueError(f"depth image: is {depth.dtype} {depth.shape}, must be 32FC1 [m] or 16UC1 [mm]")
        matrix = np.asarray(K, dtype=float).reshape(3, 3)
        if not np.all(np.isfinite(matrix)) or matrix[0, 0] <= 0.0 or matrix[1, 1] <= 0.0:
            raise ValueError("depth camera_info: K must be finite, with focal lengths above zero")
        self._prepare(depth.shape, matrix)
        half = self._stride // 2
        z = depth[half :: self._stride, half :: self._stride].astype(float)
        z *= _MILLIMETRE if depth.dtype == np.uint16 else 1.0
        valid = np.isfinite(z) & (z > 0.0)
        return np.asarray(z[valid, None] * self._rays[valid])

    def _prepare(self, shape: tuple[int, ...], K: Array) -> None:
        key = (*shape, *K.ravel().tolist())
        if key == self._key:
            return
        half = self._stride // 2
        v, u = np.mgrid[half : shape[0] : self._stride, half : shape[1] : self._stride].astype(float)
        self._rays = np.stack([(u - K[0, 2]) / K[0, 0], (v - K[1, 2]) / K[1, 1], np.ones_like(u)], axis=-1)
        self._key = key
