"""Which markers of a dock the camera on the chair sees, and from where."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from seater_common.field_of_view import FieldOfView
from seater_common.geometry import CameraMount, Dock, rotation_rpy
from seater_common.occlusion import Prism, blocked, side_wall_prisms

Array = NDArray[np.float64]

_BLOCK = 512  # poses that are looked at together: as much as stays in the processor's cache
_NEAREST = 0.05  # [m] along the optical axis; nearer, nothing is sharp


@dataclass(frozen=True)
class Sight:
    """Which markers of a dock the camera on the chair has wholly in view; poses are base_link in the dock's frame."""

    mount: CameraMount
    dock: Dock
    field: FieldOfView

    def seen(self, poses: Array, markers: Sequence[int] | None = None) -> NDArray[np.bool_]:
        """(n, k): marker (index in the dock's list; None: all) wholly in the image, printed side to the camera, no side
        wall between; poses (n, 3)."""
        poses = np.atleast_2d(np.asarray(poses, dtype=float))
        corners, centres, normals = self._markers
        if markers is not None:
            chosen = list(markers)
            corners, centres, normals = corners[chosen], centres[chosen], normals[chosen]
        blocks = (poses[i : i + _BLOCK] for i in range(0, max(len(poses), 1), _BLOCK))
        return np.concatenate([self._sees(block, corners, centres, normals) for block in blocks])

    def _sees(self, poses: Array, corners: Array, centres: Array, normals: Array) -> NDArray[np.bool_]:
        """(n, k) for markers with these corners (k, 4, 3), centres and normals (k, 3)."""
        eyes, points = self._eyes(poses), corners.reshape(-1, 3)
        c, s = np.cos(poses[:, 2, None]), np.sin(poses[:, 2, None])
        dx, dy = points[:, 0] - poses[:, 0, None], points[:, 1] - poses[:, 1, None]
        in_base = np.stack([c * dx + s * dy, c * dy - s * dx, np.broadcast_to(points[:, 2], dx.shape)], axis=2)
        in_view = np.all(in_base @ self._planes[:, :3].T + self._planes[:, 3] >= 0.0, axis=2)
        result = np.all(in_view.reshape(len(poses), -1, 4), axis=2)
        result &= eyes @ normals.T > np.sum(centres * normals, axis=1)
        candidates = np.flatnonzero(np.any(result, axis=1))
        if len(candidates):
            hidden = blocked(eyes[candidates], points, self._walls).reshape(len(candidates), -1, 4)
            result[candidates] &= ~np.any(hidden, axis=2)
        return result

    @cached_property
    def _planes(self) -> Array:
        """(5, 4): what is in view lies on the positive side of the image's edges and ahead of the lens, base_link."""
        axis = rotation_rpy(self.mount.roll, self.mount.pitch, self.mount.yaw)[:, 0]
        ahead = np.append(axis, -axis @ [self.mount.x, self.mount.y, self.mount.z] - _NEAREST)
        return np.vstack([self.field.edges(self.mount), ahead])

    @cached_property
    def _markers(self) -> tuple[Array, Array, Array]:
        """Of all markers: corners (k, 4, 3), centres and normals of the printed sides (k, 3), in the dock's frame."""
        T = np.array([marker.T_dock_marker() for marker in self.dock.markers])
        own = np.array([marker.corners() for marker in self.dock.markers])
        return own @ T[:, :3, :3].transpose(0, 2, 1) + T[:, None, :3, 3], T[:, :3, 3], T[:, :3, 2]

    @cached_property
    def _walls(self) -> list[Prism]:
        return side_wall_prisms(self.dock.bay)

    def _eyes(self, poses: Array) -> Array:
        """Where the camera is, (n, 3)."""
        c, s = np.cos(poses[:, 2]), np.sin(poses[:, 2])
        x, y = self.mount.x, self.mount.y
        return np.column_stack(
            [poses[:, 0] + c * x - s * y, poses[:, 1] + s * x + c * y, np.full(len(poses), self.mount.z)]
        )

    def pixels_across(self, pose: Array, index: int, focal_length: float) -> float:
        """About the side of a marker in the image [px], seen from straight ahead; `focal_length` [px]."""
        marker = self.dock.markers[index]
        eye = self._eyes(np.atleast_2d(np.asarray(pose, dtype=float)))[0]
        return focal_length * marker.size / max(float(np.linalg.norm(np.asarray(marker.position) - eye)), _NEAREST)


def marker_edges(dock: Dock, index: int) -> tuple[Array, Array]:
    """The left and the right end of a marker as seen by one who looks at the dock along its x axis, (3,) each [m]."""
    marker = dock.markers[index]
    T = marker.T_dock_marker()
    half = 0.5 * marker.size * T[:3, 0]
    centre = np.asarray(marker.position, dtype=float)
    ends = sorted((centre - half, centre + half), key=lambda end: float(end[1]))
    return ends[1], ends[0]
