"""The sensor of obstacles: where its rays go, and what it makes of them."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike, NDArray

from seater_common.camera_model import CameraModel
from seater_common.geometry import CameraMount, Dock, pose_matrix, rotation_rpy
from seater_sim.ranging.walls import cast, standing, walking
from seater_sim.settings import SCAN, SimulatorSettings

Array = NDArray[np.float64]


class RangeSensor:
    """A laser scanner or a depth camera. The same arguments give the same measurement, to the bit."""

    def __init__(self, settings: SimulatorSettings, mount: CameraMount, dock: Dock, model: CameraModel | None) -> None:
        """`mount` and `model`: of the camera whose view a depth image shows.

        Raises:
            ValueError: a depth image without a camera model.
        """
        self.settings, self.kind = settings.ranging, settings.ranging.kind
        self._walkers, self._walls = settings.walkers, standing(dock, settings.obstacles)
        if self.kind == SCAN:
            scan = self.settings.scan
            self.angles = np.arange(-scan.half_angle, scan.half_angle + 0.5 * scan.step, scan.step)
            self._rays = np.column_stack([np.cos(self.angles), np.sin(self.angles), np.zeros(len(self.angles))])
            self.T_base_sensor = np.eye(4)
            self.T_base_sensor[:3, :3] = rotation_rpy(0.0, 0.0, scan.yaw)
            self.T_base_sensor[:3, 3] = scan.x, scan.y, scan.z
            return
        if model is None:
            raise ValueError("simulator/ranging/kind: is depth, which needs the camera's calibration")
        self.K, self._rays = _pixels(model, self.settings.depth.columns, self.settings.depth.rows)
        self.T_base_sensor = mount.T_base_optical()

    def measure(self, pose: ArrayLike, walkers: Array, seed: int, index: int) -> Array:
        """With base_link at `pose` and the walkers at their positions (n, 2) [m] in the dock frame.

        scan: (n,) ranges [m], infinite: nothing. depth: (rows, columns) along the optical axis [m], 0: not measured.
        """
        T = pose_matrix(pose) @ self.T_base_sensor
        reach = cast(T[:3, 3], self._rays @ T[:3, :3].T, self._walls + walking(self._walkers, walkers))
        rng = np.random.default_rng([seed, index, 7])
        if self.kind == SCAN:
            scan = self.settings.scan
            noisy = np.maximum(reach + scan.noise_sd * rng.standard_normal(len(reach)), scan.min_range)
            return np.where((reach < scan.min_range), np.nan, np.where(reach <= scan.max_range, noisy, np.inf))
        depth = self.settings.depth
        near = np.where(reach <= depth.max_range, reach, 0.0)
        noisy = near + depth.noise * near**2 * rng.standard_normal(len(near))
        return np.maximum(noisy, 0.0).reshape(depth.rows, depth.columns)


def _pixels(model: CameraModel, columns: int, rows: int) -> tuple[Array, Array]:
    """K of an image of this size with the camera's field of view, without distortion, and its rays (n, 3)."""
    sx, sy = columns / model.width, rows / model.height
    # A pixel's centre has integer coordinates.
    shift = np.array([[sx, 0.0, 0.5 * sx - 0.5], [0.0, sy, 0.5 * sy - 0.5], [0.0, 0.0, 1.0]])
    K = shift @ model.K
    v, u = np.mgrid[0:rows, 0:columns].astype(float)
    pixels = np.stack([u.ravel(), v.ravel(), np.ones(u.size)], axis=1)
    return K, np.linalg.solve(K, pixels.T).T
