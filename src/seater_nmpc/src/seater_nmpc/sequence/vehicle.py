"""The border between the wheelchair and the core, which knows docking forward only.

For a dock that is entered backward, the core drives the chair turned about: base_link' is base_link turned by pi about
z, so what was the back is the front. Odometry is turned on its way in, commands and plans on their way out.
"""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
from numpy.typing import ArrayLike, NDArray

from seater_common.geometry import CameraMount, Chair, Dock
from seater_common.se2 import compose, wrap_angle
from seater_nmpc.control.command import Command
from seater_nmpc.observe.odometry.message import Odometry

Array = NDArray[np.float64]

_T_BASE_TURNED = (0.0, 0.0, math.pi)


def turned_about(chair: Chair) -> Chair:
    """The same chair as seen from base_link'. Raises ValueError when it cannot drive backward."""
    limits = chair.limits
    if limits.v_reverse_max <= 0.0:
        raise ValueError(
            f"limits/v_reverse_max: is {limits.v_reverse_max}, must be > 0 [m/s] for a dock with direction: backward"
        )
    return replace(
        chair,
        length_front=chair.length_rear,
        length_rear=chair.length_front,
        limits=replace(limits, v_max=limits.v_reverse_max, v_reverse_max=limits.v_max),
        camera=_turned_mount(chair.camera),
    )


def _turned_mount(mount: CameraMount) -> CameraMount:
    """Roll and pitch stay, as yaw is applied last: Rz(pi) Rz(yaw) Ry(pitch) Rx(roll)."""
    return replace(mount, x=-mount.x, y=-mount.y, yaw=wrap_angle(mount.yaw + math.pi))


class Vehicle:
    """Turns what goes in and out, or, for a dock that is entered forward, leaves it as it is."""

    def __init__(self, chair: Chair, dock: Dock) -> None:
        """Raises ValueError when the dock is entered backward and the chair cannot drive so."""
        self._turned = dock.direction == "backward"
        self.chair = turned_about(chair) if self._turned else chair  # what the core is to drive

    def odometry(self, odometry: Odometry) -> Odometry:
        """Of base_link in, of the core's base out; what is not finite stays so."""
        if not self._turned or not odometry.is_finite():
            return odometry
        return replace(odometry, pose=self.pose(odometry.pose), v=0.0 - odometry.v)

    def command(self, command: Command) -> Command:
        """Of the core in; speeds and plan for base_link out."""
        if not self._turned:
            return command
        path = np.array([self.pose(pose) for pose in command.path]).reshape(-1, 3)
        return replace(command, v=0.0 - command.v, path=path)  # 0.0 - v: zero stays +0.0

    def pose(self, pose: ArrayLike) -> Array:
        """Base_link from the core's base, and the other way round; (x, y, heading) in any frame [m, m, rad]."""
        return compose(pose, _T_BASE_TURNED) if self._turned else np.asarray(pose, dtype=float)
