"""What perception would say about the dock, without drawing an image: which markers are seen, and with which error.

The pose of the dock is found from the corners of all visible markers; each corner coordinate has the standard deviation
`corner_sigma`. To first order the error of the pose is then normal with covariance (J' J / sigma^2 + prior)^-1, J the
Jacobian of the projection; the prior is that the dock stands upright (`tilt_sigma`, rotation about the two horizontal
axes). That is how perception computes the covariance it publishes, and the error is drawn from it. It grows with
distance by itself.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from seater_common.geometry import Chair, Dock, Marker, pose_matrix
from seater_common.params import param
from seater_nmpc.observe.measurement import Hypothesis
from seater_sim.camera.camera_model import CameraModel

Array = NDArray[np.float64]


@dataclass(frozen=True)
class NoiseModel:
    """Values as in config/perception.yaml where it has them."""

    corner_sigma: float = param(0.05, "px", "standard deviation of a corner coordinate", low=0.001)
    tilt_sigma: float = param(0.035, "rad", "how far camera and markers are from upright", low=1e-4)
    min_side: float = param(18.0, "px", "smallest side of a marker that is still found", low=1.0)
    border: float = param(3.0, "px", "how far inside the image all corners have to be", low=0.0)


class DockSensor:
    """Camera and markers; poses are base_link in the dock's frame."""

    def __init__(self, chair: Chair, dock: Dock, camera: CameraModel, noise: NoiseModel | None = None) -> None:
        self._noise = noise or NoiseModel()
        self._width, self._height, self._K = camera.width, camera.height, camera.P[:, :3]
        self._T_optical_base = np.linalg.inv(chair.camera.T_base_optical())
        self._markers = [_corners_in_dock(marker) for marker in dock.markers]
        self._normals = [marker.T_dock_marker()[:3, 2] for marker in dock.markers]

    def T_optical_dock(self, T_dock_base: ArrayLike) -> Array:
        """4x4 pose of the dock in the camera's optical frame."""
        return np.asarray(self._T_optical_base @ np.linalg.inv(pose_matrix(T_dock_base)))

    def in_view(self, T_dock_base: ArrayLike) -> list[int]:
        """Markers that are wholly in the image, however far away."""
        T = self.T_optical_dock(T_dock_base)
        return [i for i in range(len(self._markers)) if self._side(T, i) is not None]

    def visible(self, T_dock_base: ArrayLike) -> list[int]:
        """Markers that are in the image and large enough to be found."""
        T = self.T_optical_dock(T_dock_base)
        sides = {i: self._side(T, i) for i in range(len(self._markers))}
        return [i for i, side in sides.items() if side is not None and side >= self._noise.min_side]

    def measure(self, T_dock_base: ArrayLike, rng: np.random.Generator) -> list[Hypothesis]:
        """The hypotheses of one image taken at this pose; empty when no marker is found."""
        T, seen = self.T_optical_dock(T_dock_base), self.visible(T_dock_base)
        noise = rng.standard_normal(6)  # drawn always, so that what is seen once does not change what follows
        if not seen:
            return []
        covariance = self.covariance(T, seen)
        error = np.linalg.cholesky(covariance) @ noise
        return [Hypothesis(_moved(T, error), covariance)]

    def covariance(self, T: Array, markers: list[int]) -> Array:
        """6x6: x, y, z [m], rotation about x, y, z of the optical frame [rad] round the dock's origin."""
        points = np.concatenate([self._markers[i] for i in markers])
        rows = []
        for at, arm in zip(_transform(T, points), points @ T[:3, :3].T, strict=True):
            rows.append(_projection_jacobian(self._K, at) @ np.hstack([np.eye(3), -_cross(arm)]))
        J = np.concatenate(rows) / self._noise.corner_sigma
        upright = T[:3, 2]  # the dock's vertical in the optical frame: turning about it is free
        tilt = (np.eye(3) - np.outer(upright, upright)) / self._noise.tilt_sigma**2
        information = J.T @ J
        information[3:, 3:] += tilt
        covariance = np.linalg.inv(information)
        return np.asarray(0.5 * (covariance + covariance.T))

    def _side(self, T: Array, marker: int) -> float | None:
        """Mean side in the image [px]; None when a corner is outside or the print is seen from behind."""
        points = _transform(T, self._markers[marker])
        if np.any(points[:, 2] < 0.05) or float((T[:3, :3] @ self._normals[marker]) @ points.mean(axis=0)) >= 0.0:
            return None
        pixels = (points / points[:, 2:]) @ self._K.T
        u, v, border = pixels[:, 0], pixels[:, 1], self._noise.border
        inside = (u >= border) & (u <= self._width - 1 - border) & (v >= border) & (v <= self._height - 1 - border)
        if not np.all(inside):
            return None
        return float(np.mean(np.hypot(*(np.roll(pixels, -1, axis=0) - pixels)[:, :2].T)))


def _corners_in_dock(marker: Marker) -> Array:
    T = marker.T_dock_marker()
    return _transform(T, marker.corners())


def _transform(T: Array, points: Array) -> Array:
    return points @ T[:3, :3].T + T[:3, 3]


def _projection_jacobian(K: Array, point: Array) -> Array:
    x, y, z = point
    return np.array([[K[0, 0] / z, 0.0, -K[0, 0] * x / z**2], [0.0, K[1, 1] / z, -K[1, 1] * y / z**2]])


def _cross(a: Array) -> Array:
    return np.array([[0.0, -a[2], a[1]], [a[2], 0.0, -a[0]], [-a[1], a[0], 0.0]])


def _moved(T: Array, error: Array) -> Array:
    """T with a shift and a small rotation in the optical frame, round the dock's origin."""
    angle = float(np.linalg.norm(error[3:]))
    axis = error[3:] / angle if angle > 0.0 else np.array([0.0, 0.0, 1.0])
    A = _cross(axis)
    rotation = np.eye(3) + math.sin(angle) * A + (1.0 - math.cos(angle)) * A @ A
    result = T.copy()
    result[:3, :3] = rotation @ T[:3, :3]
    result[:3, 3] += error[:3]
    return result
