"""A drive from messages or images, one after the other."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from seater_common.camera_model import CameraModel
from seater_tools.drive.drive import Drive, DriveError

Array = NDArray[np.float64]

FLOOR = 0.03  # [px] of a corner: what a print and a lens model are off; the fit scales it by what it finds
STEP = 1e-6  # [m], [rad] of the numerical derivative


class Gatherer:
    """Collects; `drive` gives what there is."""

    def __init__(self, camera: CameraModel) -> None:
        self.camera = camera
        self.sightings = 0  # of markers so far
        self._odometry: list[tuple[float, ...]] = []
        self._seen: dict[float, list[tuple[int, Array, Array]]] = {}

    def odometry(self, stamp: float, pose: Sequence[float] | Array) -> None:
        """Pose (x, y, heading) of base_link in odom; what is not finite is left out."""
        row = (stamp, *map(float, pose))
        if np.all(np.isfinite(row)):
            self._odometry.append(row)

    def marker(self, stamp: float, id: int, corners: Array, covariance: Array) -> None:
        """Corners (4, 2) [px] with covariance (8, 8); what is not finite or has no covariance is left out."""
        if np.all(np.isfinite(corners)) and np.all(np.isfinite(covariance)):
            self._seen.setdefault(stamp, []).append((id, corners, covariance))
            self.sightings += 1

    def pose(self, stamp: float, id: int, size: float, corners: Array, T: Array, covariance: Array) -> None:
        """A marker as perception sees it: corners (4, 2) that belong to the pose T (4, 4) of the marker of side `size`
        in the optical frame, with the pose's covariance (6, 6)."""
        if np.all(np.isfinite(T)) and np.all(np.isfinite(covariance)):
            self.marker(stamp, id, corners, corner_covariance(self.camera, size, T, covariance))

    def drive(self) -> Drive:
        """Raises DriveError: too little."""
        odometry = np.array(self._odometry, dtype=float).reshape(-1, 4)
        odometry = odometry[np.argsort(odometry[:, 0], kind="stable")]
        odometry = odometry[np.append(np.diff(odometry[:, 0]) > 0.0, True)] if len(odometry) else odometry
        if not self._seen:
            raise DriveError("no marker of the dock was seen")
        stamps = np.array(sorted(self._seen))
        rows = [(k, *row) for k, stamp in enumerate(stamps) for row in self._seen[float(stamp)]]
        image, ids, corners, covariance = zip(*rows, strict=True)
        return Drive(odometry, stamps, np.array(image), np.array(ids), np.array(corners), np.array(covariance))


def corner_covariance(camera: CameraModel, size: float, T: Array, covariance: Array) -> Array:
    """(8, 8) [px^2] of the corners of a marker, from the covariance (6, 6) of its pose T (4, 4) in the optical frame:
    position, rotation about the axes of that frame; first order, with a floor."""
    half = 0.5 * size
    square = np.array([[-half, half, 0.0], [half, half, 0.0], [half, -half, 0.0], [-half, -half, 0.0]])
    arms = square @ T[:3, :3].T
    J = np.empty((8, 6))
    for axis in range(3):
        unit = np.zeros(3)
        unit[axis] = STEP
        for column, move in ((axis, np.broadcast_to(unit, (4, 3))), (axis + 3, np.cross(unit, arms))):
            ahead, behind = (camera.project(T[:3, 3] + arms + sign * move) for sign in (1.0, -1.0))
            J[:, column] = (ahead - behind).ravel() / (2.0 * STEP)
    return np.asarray(J @ covariance @ J.T + FLOOR**2 * np.eye(8))
