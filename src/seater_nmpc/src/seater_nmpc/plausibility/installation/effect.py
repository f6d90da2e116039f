"""What a mount and a focal length that are off do to where an image has the dock.

dx, dy [m], dyaw [rad] are by what the mount is off, and k is by what distances along the camera's axis are measured too
long (a focal length that is too long by k, or prints that are smaller). With c the camera and M the middle of the
markers, q = D - c and r = M - c seen from base_link, a the camera's axis and t the angle between it and the normal of
the markers, an image shows the dock D off by

    position  -(dx, dy) + dyaw (q_y, -q_x) + k (a r) a + turn (D - M)_across,
    heading   -dyaw + turn,   turn = k sin t cos t.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from seater_common.geometry import CameraMount, Dock
from seater_common.se2 import relative, transform_points
from seater_nmpc.observe.odometry.drift import SIZE as DRIFT
from seater_nmpc.observe.odometry.instant import Instant

Array = NDArray[np.float64]

ALL = DRIFT + 4  # states: those of drift.py, then dx, dy, dyaw and k


class Effect:
    """Of one camera that looks at one dock."""

    def __init__(self, mount: CameraMount, dock: Dock) -> None:
        self._camera = np.array([mount.x, mount.y, mount.yaw])
        self._middle = dock.front[:2]
        self._normal = float(np.mean([marker.normal_yaw for marker in dock.markers]))

    def on(self, dock: Array) -> Array:
        """(3, 4): of (dx, dy, dyaw, k) on a dock at `dock` (3,) in base_link."""
        middle = transform_points(dock, self._middle[None, :])[0]
        q, r = dock[:2] - self._camera[:2], middle - self._camera[:2]
        yaw = float(self._camera[2])
        a = np.array([math.cos(yaw), math.sin(yaw)])
        t = math.remainder(float(dock[2]) + self._normal + math.pi - yaw, 2.0 * math.pi)
        turn = math.sin(t) * math.cos(t)
        arm = dock[:2] - middle
        B = np.zeros((3, 4))
        B[0, 0] = B[1, 1] = -1.0
        B[:2, 2], B[2, 2] = (q[1], -q[0]), -1.0
        B[:2, 3], B[2, 3] = float(a @ r) * a + turn * np.array([-arm[1], arm[0]]), turn
        return B

    def jacobian(self, chair: Instant, dock: Array) -> Array:
        """H, (3, 11), of what an image shows of a dock at `dock` (3,), both in odom."""
        heading = float(chair.pose[2])
        R = np.array([[math.cos(heading), -math.sin(heading)], [math.sin(heading), math.cos(heading)]])
        B = self.on(relative(chair.pose, dock))
        H = np.zeros((3, ALL))
        H[:, :3] = np.eye(3)
        H[:2, DRIFT:], H[2, DRIFT:] = R @ B[:2], B[2]
        return H
