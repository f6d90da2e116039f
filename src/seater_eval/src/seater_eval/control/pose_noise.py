"""What perception would say about the dock, without drawing an image: which markers are seen, and with which error.

The pose of the dock is found from the corners of all visible markers; each corner coordinate has the standard deviation
`corner_sigma`. To first order the error of the pose is then normal with covariance (J' J / sigma^2 + prior)^-1, J the
Jacobian of the projection; the prior is that the dock stands upright (`tilt_sigma`, rotation about the two horizontal
axes). That is how perception computes the covariance it publishes, and the error is drawn from it. It grows with
distance by itself. Side walls hide markers as they do in rendered images; a marker that is partly hidden is not found.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from seater_common.camera_model import CameraModel
from seater_common.geometry import Chair, Dock, Marker, pose_matrix
from seater_common.occlusion import Prism, blocked, side_wall_prisms
from seater_common.params import param
from seater_nmpc.observe.measurement import Hypothesis

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

    def __init__(
        self,
        chair: Chair,
        dock: Dock,
        camera: CameraModel,
        noise: NoiseModel | None = None,
        obstacles: Sequence[Prism] = (),
    ) -> None:
        """`obstacles` hide markers as the bay's side walls do; in the dock's frame."""
        self._noise = noise or NoiseModel()
        self._width, self._height, self._K = camera.width, camera.height, camera.P[:, :3]
        self._T_optical_base = np.linalg.inv(chair.camera.T_base_optical())
        self._corners = np.concatenate([_corners_in_dock(marker) for marker in dock.markers])  # (4 n, 3), in the dock
        self._outlines = _outlines(self._corners).reshape(-1, 8, 3)
        self._prisms = [*side_wall_prisms(dock.bay), *obstacles]
        self._normals = np.array([marker.T_dock_marker()[:3, 2] for marker in dock.markers])

    def T_optical_dock(self, T_dock_base: ArrayLike) -> Array:
        """4x4 pose of the dock in the camera's optical frame."""
        return np.asarray(self._T_optical_base @ np.linalg.inv(pose_matrix(T_dock_base)))

    def in_view(self, T_dock_base: ArrayLike) -> list[int]:
        """Markers that are wholly in the image, however far away."""
        return np.flatnonzero(self._sides(self.T_optical_dock(T_dock_base)) > 0.0).tolist()

    def visible(self, T_dock_base: ArrayLike) -> list[int]:
        """Markers that are in the image and large enough to be found."""
        return self._visible(self.T_optical_dock(T_dock_base))

    def measure(self, T_dock_base: ArrayLike, rng: np.random.Generator) -> list[Hypothesis]:
        """The hypotheses of one image taken at this pose; empty when no marker is found."""
        T = self.T_optical_dock(T_dock_base)
        seen = self._visible(T)
        noise = rng.standard_normal(6)  # drawn always, so that what is seen once does not change what follows
        if not seen:
            return []
        covariance = self.covariance(T, seen)
        error = np.linalg.cholesky(covariance) @ noise
        return [Hypothesis(_moved(T, error), covariance)]

    def covariance(self, T: Array, markers: list[int]) -> Array:
        """6x6: x, y, z [m], rotation about x, y, z of the optical frame [rad] round the dock's origin."""
        points = self._corners.reshape(-1, 4, 3)[markers].reshape(-1, 3)
        motion = np.concatenate(
            [np.broadcast_to(np.eye(3), (len(points), 3, 3)), -_cross(points @ T[:3, :3].T)], axis=2
        )
        J = (_projection_jacobian(self._K, _transform(T, points)) @ motion).reshape(-1, 6) / self._noise.corner_sigma
        upright = T[:3, 2]  # the dock's vertical in the optical frame: turning about it is free
        tilt = (np.eye(3) - np.outer(upright, upright)) / self._noise.tilt_sigma**2
        information = J.T @ J
        information[3:, 3:] += tilt
        covariance = np.linalg.inv(information)
        return np.asarray(0.5 * (covariance + covariance.T))

    def _visible(self, T: Array) -> list[int]:
        return np.flatnonzero(self._sides(T) >= self._noise.min_side).tolist()

    def _sides(self, T: Array) -> Array:
        """Mean side of each marker in the image [px]; 0 when a corner is outside, the print is seen from behind, or
        something stands before any part of it."""
        points = _transform(T, self._corners).reshape(-1, 4, 3)
        faces_us = np.einsum("ni,ni->n", self._normals @ T[:3, :3].T, points.sum(axis=1)) < 0.0
        candidates = np.flatnonzero(faces_us & (points[:, :, 2].min(axis=1) >= 0.05))
        pixels = ((points[candidates] / points[candidates, :, 2:]) @ self._K.T)[:, :, :2]
        border = self._noise.border
        low, high = border, [self._width - 1 - border, self._height - 1 - border]
        inside = ((pixels >= low) & (pixels <= high)).all(axis=(1, 2))
        sides = np.zeros(len(points))
        if not inside.any():
            return sides
        candidates, pixels = candidates[inside], pixels[inside]
        edges = pixels[:, [1, 2, 3, 0]] - pixels
        sides[candidates] = np.hypot(edges[:, :, 0], edges[:, :, 1]).mean(axis=1)
        sides[candidates[self._hidden(T, candidates)]] = 0.0
        return sides

    def _hidden(self, T: Array, markers: NDArray[np.int_]) -> NDArray[np.bool_]:
        """Whether a wall or an obstacle stands before each of these markers, or a part of it (its outline is looked
        at)."""
        camera = -T[:3, :3].T @ T[:3, 3]
        lines = blocked(camera[None], self._outlines[markers].reshape(-1, 3), self._prisms)[0]
        return np.asarray(lines.reshape(len(markers), -1).any(axis=1))


def _corners_in_dock(marker: Marker) -> Array:
    T = marker.T_dock_marker()
    return _transform(T, marker.corners())


def _outlines(corners: Array) -> Array:
    """Corners (4 n, 3) and, after those of each marker, the middles of its sides: (8 n, 3)."""
    squares = corners.reshape(-1, 4, 3)
    middles = 0.5 * (squares + squares[:, [1, 2, 3, 0]])
    return np.concatenate([squares, middles], axis=1).reshape(-1, 3)


def _transform(T: Array, points: Array) -> Array:
    return points @ T[:3, :3].T + T[:3, 3]


def _projection_jacobian(K: Array, points: Array) -> Array:
    """(n, 2, 3): the derivative of the pixels with respect to points (n, 3) in the optical frame."""
    x, y, z = points.T
    z_squared = np.float_power(z, 2)
    J = np.zeros((len(points), 2, 3))
    J[:, 0, 0], J[:, 0, 2] = K[0, 0] / z, -K[0, 0] * x / z_squared
    J[:, 1, 1], J[:, 1, 2] = K[1, 1] / z, -K[1, 1] * y / z_squared
    return J


def _cross(a: Array) -> Array:
    """Skew matrices (..., 3, 3) of vectors (..., 3): [a] b = a x b."""
    skew = np.zeros((*a.shape, 3))
    skew[..., 0, 1], skew[..., 0, 2], skew[..., 1, 2] = -a[..., 2], a[..., 1], -a[..., 0]
    return skew - np.swapaxes(skew, -1, -2)


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
