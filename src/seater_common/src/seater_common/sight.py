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
        eyes = self._eyes(poses)
        chosen = range(len(self.dock.markers)) if markers is None else markers
        return np.column_stack([self._sees(poses, eyes, index) for index in chosen])

    def _sees(self, poses: Array, eyes: Array, index: int) -> NDArray[np.bool_]:
        corners, centre, normal = self._markers[index]
        c, s = np.cos(poses[:, 2, None]), np.sin(poses[:, 2, None])
        dx, dy = corners[:, 0] - poses[:, 0, None], corners[:, 1] - poses[:, 1, None]
        in_base = np.stack([c * dx + s * dy, c * dy - s * dx, np.broadcast_to(corners[:, 2], dx.shape)], axis=2)
        result = np.all(in_base @ self._planes[:, :3].T + self._planes[:, 3] >= 0.0, axis=(1, 2))
        result &= (eyes - centre) @ normal > 0.0
        candidates = np.flatnonzero(result)
        if len(candidates):
            result[candidates] = ~np.any(blocked(eyes[candidates], corners, self._walls), axis=1)
        return result

    @cached_property
    def _planes(self) -> Array:
        """(5, 4): what is in view lies on the positive side of the image's edges and ahead of the lens, base_link."""
        axis = rotation_rpy(self.mount.roll, self.mount.pitch, self.mount.yaw)[:, 0]
        ahead = np.append(axis, -axis @ [self.mount.x, self.mount.y, self.mount.z] - _NEAREST)
        return np.vstack([self.field.edges(self.mount), ahead])

    @cached_property
    def _markers(self) -> list[tuple[Array, Array, Array]]:
        """Of each marker: corners (4, 3), centre and normal of its printed side (3,), in the dock's frame."""
        poses = [(marker, marker.T_dock_marker()) for marker in self.dock.markers]
        return [(m.corners() @ T[:3, :3].T + T[:3, 3], T[:3, 3], T[:3, 2]) for m, T in poses]

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
