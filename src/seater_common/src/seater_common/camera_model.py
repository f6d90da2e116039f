"""The camera's geometry: a lens' model, read from a camera_info file (config/cameras/) or one of OpenCV's.

Models and files: docs/reference/cameras.md; seater_perception::Lens knows the same. OpenCV loads where a lens is bent.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from seater_common.params import ParameterError, read_yaml

Array = NDArray[np.float64]

COEFFICIENTS = {"plumb_bob": (4, 5), "rational_polynomial": (4, 5, 8, 12, 14), "equidistant": (4,)}
COVARIANCE = "parameter_covariance"
# librealsense's names, whose formulas are not OpenCV's: without distortion only.
STRAIGHT = ("none", "brown_conrady", "inverse_brown_conrady", "modified_brown_conrady")
_OPENCV_NAMES = {  # of OpenCV's tutorials
    "camera_matrix": ("Camera_Matrix", "cameraMatrix", "K"),
    "distortion_coefficients": ("Distortion_Coefficients", "distCoeffs", "dist_coeffs", "D"),
    "image_width": ("image_Width",),
    "image_height": ("image_Height",),
}
_INVERTIBLE = 0.5  # [px] a ray that is projected farther from its pixel is not the pixel's
_WIDEST = np.tan(1.5)  # of a ray, which is x / z and has no end at 90 degrees


@dataclass(frozen=True, eq=False)
class CameraModel:
    """Intrinsics as in sensor_msgs/CameraInfo. A pixel's centre has integer coordinates."""

    width: int
    height: int
    distortion_model: str
    D: Array  # as of COEFFICIENTS
    K: Array  # (3, 3), raw image
    R: Array  # (3, 3), rectification
    P: Array  # (3, 4), rectified image; all 0: not known
    covariance: Array | None = None  # of `parameters`, as the calibration has it; None: not known
    distorted: bool = field(init=False)  # whether the lens bends straight lines

    def __post_init__(self) -> None:
        object.__setattr__(self, "distorted", self.distortion_model == "equidistant" or bool(np.any(self.D != 0.0)))

    @classmethod
    def load(cls, path: str | Path) -> CameraModel:
        """From a file of camera_calibration or of OpenCV (FileStorage's .yml).

        Raises:
            ParameterError: naming the file, and the key that is missing or wrong.
        """
        return cls.from_mapping(read_calibration(path), str(path))

    @classmethod
    def from_mapping(cls, values: Any, prefix: str = "camera") -> CameraModel:
        """Of the mapping that camera_calibration writes as YAML.

        Raises:
            ParameterError: a key is missing or has a wrong value; the message names it.
        """
        if not isinstance(values, Mapping):
            raise ParameterError(f"{prefix}: is {values!r}, must be a mapping (a camera_info file)")
        model, D = _lens(values, prefix)
        K = _matrix(values, "camera_matrix", (3, 3), prefix)
        if K[0, 0] <= 0.0 or K[1, 1] <= 0.0:
            raise ParameterError(f"{prefix}/camera_matrix: focal lengths {K[0, 0]}, {K[1, 1]} must be > 0 [px]")
        return cls(
            width=_size(values, "image_width", prefix),
            height=_size(values, "image_height", prefix),
            distortion_model=model,
            D=D,
            K=K,
            R=_matrix(values, "rectification_matrix", (3, 3), prefix, np.eye(3)),
            P=_matrix(values, "projection_matrix", (3, 4), prefix, np.zeros((3, 4))),
            covariance=_covariance(values, 4 + len(D), prefix),
        )

    @property
    def parameters(self) -> Array:
        """(4 + coefficients,): fx, fy, cx, cy [px], D."""
        return np.array([self.K[0, 0], self.K[1, 1], self.K[0, 2], self.K[1, 2], *self.D])

    def with_parameters(self, values: Array) -> CameraModel:
        """The same with these, in the raw image."""
        K = self.K.copy()
        K[0, 0], K[1, 1], K[0, 2], K[1, 2] = values[:4]
        return replace(self, K=K, D=np.array(values[4:]))

    def project(self, points: Array) -> Array:
        """Pixels (n, 2) of points (n, 3) [m] in the optical frame, all with z > 0."""
        rays = points[:, :2] / points[:, 2:]
        if self.distorted:
            rays = self._distort(rays)
        return np.asarray(rays @ self.K[:2, :2].T + self.K[:2, 2])

    def _distort(self, rays: Array) -> Array:
        """(n, 2) of (n, 2), by OpenCV with K = 1."""
        import cv2

        points, zero = np.column_stack([rays, np.ones(len(rays))])[:, None], np.zeros(3)
        if self.distortion_model == "equidistant":
            return np.asarray(cv2.fisheye.projectPoints(points, zero, zero, np.eye(3), self.D)[0].reshape(-1, 2))
        return np.asarray(cv2.projectPoints(points, zero, zero, np.eye(3), self.D)[0].reshape(-1, 2))

    def _undistort(self, pixels: Array) -> Array:
        """(n, 2) of (n, 2); where there is no inverse, some ray in about that direction."""
        if not self.distorted:
            return (pixels - self.K[:2, 2]) * (1.0 / self.K[[0, 1], [0, 1]])
        import cv2

        precise = (cv2.TERM_CRITERIA_COUNT | cv2.TERM_CRITERIA_EPS, 50, 1e-10)
        seen = np.ascontiguousarray(pixels, dtype=float).reshape(-1, 1, 2)
        if self.distortion_model != "equidistant":
            return np.asarray(cv2.undistortPointsIter(seen, self.K, self.D, None, None, precise).reshape(-1, 2))
        rays = cv2.fisheye.undistortPoints(seen, self.K, self.D, criteria=precise).reshape(-1, 2)
        outwards = (pixels - self.K[:2, 2]) / self.K[[0, 1], [0, 1]]
        radius = np.maximum(np.linalg.norm(outwards, axis=1), 1e-12)
        # OpenCV marks what does not converge by -1e6; rays at more than 90 degrees point backwards.
        lost = ~(np.sum(rays * outwards, axis=1) >= 0.0) | (np.linalg.norm(rays, axis=1) > _WIDEST)
        rays[lost] = (outwards * (_WIDEST / radius)[:, None])[lost]
        return np.asarray(rays)

    def rectified(self) -> CameraModel:
        """The pinhole of the rectified images: P in the place of K, no distortion. Raises ParameterError: P is not
        known."""
        if not (self.P[0, 0] > 0.0 and self.P[1, 1] > 0.0):
            raise ParameterError("projection_matrix: is missing or 0, rectified images need it")
        K = self.P[:, :3].copy()
        return replace(self, distortion_model="plumb_bob", D=np.zeros(5), K=K, R=np.eye(3), covariance=None)

    def ray(self, pixels: Array) -> Array:
        """(x / z, y / z) of pixels (n, 2), (n, 2); NaN where the lens model has no inverse (far outside the image)."""
        rays = self._undistort(pixels)
        back = self.project(np.column_stack([rays, np.ones(len(rays))]))
        rays[np.hypot(*(back - pixels).T) > _INVERTIBLE] = np.nan
        return np.asarray(rays)

    def rays(self, margin: int) -> NDArray[np.float32]:
        """(x / z, y / z) of every pixel's centre, (height + 2 margin, width + 2 margin, 2), the margin outside the
        image."""
        u, v = np.meshgrid(np.arange(-margin, self.width + margin), np.arange(-margin, self.height + margin))
        rays = self._undistort(np.stack([u, v], axis=-1).reshape(-1, 2).astype(float))
        return rays.reshape(self.height + 2 * margin, self.width + 2 * margin, 2).astype(np.float32)


def read_calibration(path: str | Path) -> dict[str, Any]:
    """The mapping of a calibration file, with the keys of camera_calibration.

    Raises:
        ParameterError: the file cannot be read.
    """
    values = read_yaml(path)
    if not isinstance(values, dict):
        raise ParameterError(f"{path}: is {values!r:.50}, must be a mapping (a camera_info file)")
    for key, others in _OPENCV_NAMES.items():
        used = next((name for name in others if name in values), key)
        if key not in values and used in values:
            values[key] = values[used]
    if "distortion_model" not in values and isinstance(D := values.get("distortion_coefficients"), dict):
        usual = "plumb_bob" if len(D.get("data") or []) <= 5 else "rational_polynomial"
        values["distortion_model"] = "equidistant" if values.get("fisheye_model") == 1 else usual
    return values


def _lens(values: Mapping[str, Any], prefix: str) -> tuple[str, Array]:
    """Model and coefficients; without distortion, plumb_bob and five zeros."""
    name = values.get("distortion_model", "")
    entry = values.get("distortion_coefficients")
    count = len(entry["data"]) if isinstance(entry, Mapping) and isinstance(entry.get("data"), list | tuple) else 5
    D = _matrix(values, "distortion_coefficients", (1, count), prefix).reshape(-1)
    plain = str(name).removeprefix("distortion.").replace(" ", "_").lower()
    straight = not np.any(D)
    if straight and (plain in STRAIGHT or name in ("", "plumb_bob", "rational_polynomial")):
        return "plumb_bob", np.zeros(5)
    if name not in COEFFICIENTS:
        known = ", ".join(f"{model} ({' or '.join(map(str, n))} coefficients)" for model, n in COEFFICIENTS.items())
        known += f", or without distortion (all coefficients 0) {', '.join(STRAIGHT)}"
        raise ParameterError(f"{prefix}/distortion_model: is {name!r} with D = {D.tolist()}, must be one of {known}")
    if name == "equidistant" and len(D) == 5 and D[4] == 0.0:  # realsense-ros sends an unused fifth one
        D = D[:4]
    if len(D) not in COEFFICIENTS[name]:
        wanted = " or ".join(map(str, COEFFICIENTS[name]))
        raise ParameterError(f"{prefix}/distortion_coefficients/data: has {len(D)}, must have {wanted} for {name}")
    return name, D


def _matrix(
    values: Mapping[str, Any], key: str, shape: tuple[int, int], prefix: str, default: Array | None = None
) -> Array:
    entry = values.get(key)
    if key not in values and default is not None:
        return default
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


def _covariance(values: Mapping[str, Any], count: int, prefix: str) -> Array | None:
    """seater's own key, which ROS' tools leave alone; None where it is missing."""
    if COVARIANCE not in values:
        return None
    matrix = _matrix(values, COVARIANCE, (count, count), prefix)
    sd = np.sqrt(np.maximum(np.diag(matrix), 0.0))
    if not (np.all(sd > 0.0) and np.allclose(matrix, matrix.T, rtol=1e-6, atol=0.0)):
        raise ParameterError(f"{prefix}/{COVARIANCE}: is no covariance (not symmetric, or a variance that is not > 0)")
    if float(np.linalg.eigvalsh(matrix / np.outer(sd, sd)).min()) < -1e-6:
        raise ParameterError(f"{prefix}/{COVARIANCE}: is no covariance (correlations that contradict each other)")
    return matrix


def _size(values: Mapping[str, Any], key: str, prefix: str) -> int:
    value = values.get(key)
    if isinstance(value, bool) or not isinstance(value, int) or not 16 <= value <= 8192:
        raise ParameterError(f"{prefix}/{key}: is {value!r}, must be a whole number from 16 to 8192 [px]")
    return value
