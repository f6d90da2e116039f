"""The unknowns of the bundle adjustment as one vector, in this order.

mount     6  x, y, z [m], roll, pitch, yaw [rad] of the camera's body in base_link
odometry  6  scale [-], heading scale [-], heading drift [rad/m], way per turn [m/rad], side creep [-], delay [s]
lens      k  how far the lens is from its calibration, in standard deviations (lens.py); 0 where that is not known
markers   7  each: x, y, z [m] in the dock frame, yaw of its normal, tilt, roll [rad], log of its size over the file's
poses     3  each image: x, y [m], heading [rad] of base_link in the dock frame
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from seater_common.geometry import CameraMount, Dock

Array = NDArray[np.float64]

MOUNT = ("x", "y", "z", "roll", "pitch", "yaw")
ODOMETRY = ("scale", "heading_scale", "heading_drift", "way_per_turn", "side_creep", "delay")
MARKER = ("x", "y", "z", "yaw", "tilt", "roll", "log_size")
FIRST_LENS = len(MOUNT) + len(ODOMETRY)


@dataclass(frozen=True, eq=False)
class Layout:
    """Where what stands in the vector, for these markers (ids, in the file's order), so many images and unknowns of the
    lens."""

    ids: tuple[int, ...]
    images: int
    lens: int = 0

    @property
    def first_marker(self) -> int:
        return FIRST_LENS + self.lens

    @property
    def first_pose(self) -> int:
        return self.first_marker + len(MARKER) * len(self.ids)

    @property
    def size(self) -> int:
        return self.first_pose + 3 * self.images

    def mount(self, state: Array) -> Array:
        """(6,) view."""
        return state[: len(MOUNT)]

    def odometry(self, state: Array) -> Array:
        """(6,) view."""
        return state[len(MOUNT) : FIRST_LENS]

    def lens_off(self, state: Array) -> Array:
        """(lens,) view."""
        return state[FIRST_LENS : self.first_marker]

    def markers(self, state: Array) -> Array:
        """(markers, 7) view."""
        return state[self.first_marker : self.first_pose].reshape(-1, len(MARKER))

    def poses(self, state: Array) -> Array:
        """(images, 3) view."""
        return state[self.first_pose :].reshape(-1, 3)

    def start(self, mount: CameraMount, dock: Dock, poses: Array) -> Array:
        """The files' values, and the poses (images, 3) of base_link in the dock frame."""
        state = np.zeros(self.size)
        self.mount(state)[:] = [getattr(mount, name) for name in MOUNT]
        known = {marker.id: marker for marker in dock.markers}
        for row, id in zip(self.markers(state), self.ids, strict=True):
            row[:4] = [*known[id].position, known[id].normal_yaw]
        self.poses(state)[:] = poses
        return state


def marker_rotations(markers: Array) -> Array:
    """(n, 3, 3) R_dock_marker of rows (n, 7). Upright ones (tilt, roll 0) as Marker.T_dock_marker; tilt: about the
    print's x axis, positive leans the upper edge towards the viewer; roll: about its normal, anticlockwise as seen."""
    upright = np.array([_upright(yaw) for yaw in markers[:, 3]])
    turned = np.array([_about_x(tilt) @ _about_z(roll) for tilt, roll in markers[:, 4:6]])
    return np.asarray(upright @ turned)


def _upright(yaw: float) -> Array:
    c, s = math.cos(yaw), math.sin(yaw)
    return np.array([[-s, 0.0, c], [c, 0.0, s], [0.0, 1.0, 0.0]])


def _about_x(angle: float) -> Array:
    c, s = math.cos(angle), math.sin(angle)
    return np.array([[1.0, 0.0, 0.0], [0.0, c, -s], [0.0, s, c]])


def _about_z(angle: float) -> Array:
    c, s = math.cos(angle), math.sin(angle)
    return np.array([[c, -s, 0.0], [s, c, 0.0], [0.0, 0.0, 1.0]])
