"""What the camera sees, as exact corners with noise."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from seater_common.camera_model import CameraModel
from seater_common.geometry import Limits, Marker, pose_matrix
from seater_sim.settings import SimulatorSettings
from seater_tools.drive.drive import Drive
from seater_tools.drive.gather import Gatherer
from seater_tools.mount.layout import marker_rotations
from seater_tools.trial.drive import SCRIPT, Frame, Script, drive_chair
from seater_tools.trial.truth import Installation

Array = NDArray[np.float64]

NOISE = 0.05  # [px] of a corner
INSIDE = 5.0  # [px] from the image's edge
STEEPEST = 0.25  # cosine between a print's normal and the view below which it is not read


def simulate_drive(
    truth: Installation,
    camera: CameraModel,
    simulator: SimulatorSettings,
    limits: Limits,
    seed: int,
    script: Script = SCRIPT,
) -> Drive:
    """A drive in front of this installation; raises DriveError when the camera sees too little."""
    rng = np.random.default_rng([seed, 91])
    gatherer = Gatherer(camera)

    def look(frame: Frame) -> None:
        for marker, lean in zip(truth.dock.markers, truth.leans, strict=True):
            corners = project_marker(marker, lean, truth, camera, frame.pose)
            if corners is not None:
                noisy = corners + NOISE * rng.standard_normal((4, 2))
                gatherer.marker(frame.stamp, marker.id, noisy, NOISE**2 * np.eye(8))

    drive_chair(simulator, limits, seed, look, gatherer.odometry, script)
    return gatherer.drive()


def project_marker(marker: Marker, lean: Array, truth: Installation, camera: CameraModel, pose: Array) -> Array | None:
    """Corners (4, 2) [px]; None: not wholly in the image, or too steep."""
    row = np.array([[*marker.position, marker.normal_yaw, *lean, 0.0]])
    R = marker_rotations(row)[0]
    T = np.linalg.inv(pose_matrix(pose) @ truth.mount.T_base_optical())
    points = (marker.corners() @ R.T + marker.position) @ T[:3, :3].T + T[:3, 3]
    if np.any(points[:, 2] < 0.1):
        return None
    pixels = camera.project(points)
    size = np.array([camera.width - 1, camera.height - 1])
    middle, normal = points.mean(axis=0), T[:3, :3] @ R[:, 2]
    if np.any(pixels < INSIDE) or np.any(pixels > size - INSIDE):
        return None
    return pixels if -float(normal @ middle) > STEEPEST * float(np.linalg.norm(middle)) else None
