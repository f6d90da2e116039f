"""The camera's geometry: pinhole with lens distortion, read from a camera_info file (config/cameras/)."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from typing import Any

import cv2
import numpy as np
from numpy.typing import NDArray

from seater_common.params import ParameterError

Array = NDArray[np.float64]

COEFFICIENTS = {"plumb_bob": 5, "rational_polynomial": 8}
_INVERTIBLE = 0.5  # [px] a ray that is projected farther from its pixel is not the pixel's


@dataclass(frozen=True, eq=False)
class CameraModel:
    """Intrinsics as in sensor_msgs/CameraInfo. A pixel's centre has integer coordinates."""

    width: int
    height: int
    distortion_model: str
    D: Array  # (5,): k1 k2 p1 p2 k3, or (8,): and k4 k5 k6
    K: Array  # (3, 3), raw image
    R: Array  # (3, 3), rectification
    P: Array  # (3, 4), rectified image
    distorted: bool = field(init=False)  # whether the lens bends straight lines

    def __post_init__(self) -> None:
        object.__setattr__(self, "distorted", bool(np.any(self.D != 0.0)))

    @classmethod
    def from_mapping(cls, values: Any, prefix: str = "camera") -> CameraModel:
        """Of the mapping that camera_calibration writes as YAML.

        Raises:
            ParameterError: a key is missing or has a wrong value; the message names it.
        """
        if not isinstance(values, Mapping):
            raise ParameterError(f"{prefix}: is {values!r}, must be a mapping (a camera_info file)")
        model = values.get("distortion_model")
        if model not in COEFFICIENTS:
            raise ParameterError(f"{prefix}/distortion_model: is {model!r}, must be one of {', '.join(COEFFICIENTS)}")
        K = _matrix(values, "camera_matrix", (3, 3), prefix)
        if K[0, 0] <= 0.0 or K[1, 1] <= 0.0:
            raise ParameterError(f"{prefix}/camera_matrix: focal lengths {K[0, 0]}, {K[1, 1]} must be > 0 [px]")
        return cls(
            width=_size(values, "image_width", prefix),
            height=_size(values, "image_height", prefix),
            distortion_model=model,
            D=_matrix(values, "distortion_coefficients", (1, COEFFICIENTS[model]), prefix).reshape(-1),
            K=K,
            R=_matrix(values, "rectification_matrix", (3, 3), prefix),
            P=_matrix(values, "projection_matrix", (3, 4), prefix),
        )

    def project(self, points: Array) -> Array:
        """Pixels (n, 2) of points (n, 3) [m] in the optical frame, all with z > 0."""
        rays = points[:, :2] / points[:, 2:]
        if self.distorted:
            rays = np.column_stack(self._distort(rays[:, 0], rays[:, 1]))
        return np.asarray(rays @ self.K[:2, :2].T + self.K[:2, 2])

    def _distort(self, x: Array, y: Array) -> tuple[Array, Array]:
        k = np.zeros(8)
        k[: len(self.D)] = self.D
        r2 = x * x + y * y
        radial = 1.0 + r2 * (k[0] + r2 * (k[1] + r2 * k[4]))
        radial = radial / (1.0 + r2 * (k[5] + r2 * (k[6] + r2 * k[7])))
        return (
            x * radial + 2.0 * k[2] * x * y + k[3] * (r2 + 2.0 * x * x),
            y * radial + k[2] * (r2 + 2.0 * y * y) + 2.0 * k[3] * x * y,
        )

    def rectified(self) -> CameraModel:
        """The pinhole of the rectified images: P in the place of K, no distortion."""
        return replace(self, distortion_model="plumb_bob", D=np.zeros(5), K=self.P[:, :3].copy(), R=np.eye(3))

    def ray(self, pixels: Array) -> Array:
        """(x / z, y / z) of pixels (n, 2), (n, 2); NaN where the lens model has no inverse (far outside the image)."""
        criteria = (cv2.TERM_CRITERIA_COUNT | cv2.TERM_CRITERIA_EPS, 50, 1e-10)
        rays = cv2.undistortPointsIter(pixels.reshape(-1, 1, 2), self.K, self.D, None, None, criteria).reshape(-1, 2)
        back = self.project(np.column_stack([rays, np.ones(len(rays))]))
        rays[np.hypot(*(back - pixels).T) > _INVERTIBLE] = np.nan
        return np.asarray(rays)

    def rays(self, margin: int) -> NDArray[np.float32]:
        """(x / z, y / z) of every pixel's centre, (height + 2 margin, width + 2 margin, 2), the margin outside the
        image."""
        u, v = np.meshgrid(np.arange(-margin, self.width + margin), np.arange(-margin, self.height + margin))
        pixels = np.stack([u, v], axis=-1).astype(np.float64).reshape(-1, 1, 2)
        criteria = (cv2.TERM_CRITERIA_COUNT | cv2.TERM_CRITERIA_EPS, 50, 1e-10)
        rays = cv2.undistortPointsIter(pixels, self.K, self.D, None, None, criteria)
        return rays.reshape(self.height + 2 * margin, self.width + 2 * margin, 2).astype(np.float32)


def _matrix(values: Mapping[str, Any], key: str, shape: tuple[int, int], prefix: str) -> Array:
    entry = values.get(key)
    data = entry.get("data") if isinstance(entry, Mapping) else None
    if not isinstance(data, list | tuple) or len(data) != shape[0] * shape[1]:
        raise ParameterError(f"{prefix}/{key}/data: is {data!r}, must be a list of {shape[0] * shape[1]} numbers")
    try:
        matrix = np.array(data, dtype=float).reshape(shape)
    except (TypeError, ValueError):
        raise ParameterError(f"{prefix}/{key}/data: is {data!r}, must be a list of numbers") from None
    if not np.all(np.isfinite(matrix)):
        raise ParameterError(f"{prefix}/{key}/data: is {data!r}, must be finite")
    return matrix


def _size(values: Mapping[str, Any], key: str, prefix: str) -> int:
    value = values.get(key)
    if isinstance(value, bool) or not isinstance(value, int) or not 16 <= value <= 8192:
        raise ParameterError(f"{prefix}/{key}: is {value!r}, must be a whole number from 16 to 8192 [px]")
    return value
