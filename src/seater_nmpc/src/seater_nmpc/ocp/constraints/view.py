"""The camera's field of view, in which one of the markers is kept."""

from __future__ import annotations

import math
from dataclasses import dataclass

import casadi as ca
import numpy as np
from numpy.typing import NDArray

from seater_common.geometry import CameraMount, Chair, Dock
from seater_common.se2 import transform_points
from seater_nmpc.ocp.constraints.interface import AreaConstraint, Slack, Stage
from seater_nmpc.parameters import ControlParameters
from seater_nmpc.programme import StageProgramme

Array = NDArray[np.float64]


@dataclass(frozen=True)
class View:
    """The leftmost and the rightmost marker (of whoever comes) [m]: one of them at least stays in the camera's view."""

    left: tuple[float, float]
    right: tuple[float, float]

    def transformed(self, change: Array) -> View:
        """See Area."""
        (x_left, y_left), (x_right, y_right) = (transform_points(change, [p])[0] for p in (self.left, self.right))
        return View((float(x_left), float(y_left)), (float(x_right), float(y_right)))

    def constraint(self, chair: Chair, parameters: ControlParameters, programme: StageProgramme) -> ViewConstraint:
        """See Area."""
        return ViewConstraint(chair.camera, parameters.view_half_angle, programme)


def outermost_markers(dock: Dock) -> View:
    """In the dock's frame."""
    aside = sorted((marker.position[1], marker.position[0]) for marker in dock.markers)
    return View((aside[-1][1], aside[-1][0]), (aside[0][1], aside[0][0]))


class ViewConstraint(AreaConstraint[View]):
    """The right point is inside the left edge of the view and the left point inside the right edge: then one of them is
    in view, as far as they fit into it."""

    slack = Slack.VIEW

    def __init__(self, mount: CameraMount, half_angle: float, programme: StageProgramme) -> None:
        """`half_angle` [rad] of the horizontal field of view."""
        super().__init__()
        self._mount, self._edge = mount, math.tan(half_angle)
        self._p, self._where = programme.parameter("view", 4)

    def margins(self, stage: Stage) -> list[ca.SX]:
        """See AreaConstraint. Across the line of sight [m]."""
        (x_left, y_left), (x_right, y_right) = (self._in_camera(stage.pose, self._p[i : i + 2]) for i in (0, 2))
        return [ca.vertcat(self._edge * x_right - y_right, self._edge * x_left + y_left)]

    def set_instance(self, area: View, p: Array, lower: Array, upper: Array) -> None:
        """See AreaConstraint."""
        p[self._where] = [*area.left, *area.right]

    def _in_camera(self, pose: ca.SX, point: ca.SX) -> tuple[ca.SX, ca.SX]:
        """The point ahead of the camera and to its left [m]."""
        mount, c, s = self._mount, ca.cos(pose[2]), ca.sin(pose[2])
        dx, dy = point[0] - pose[0], point[1] - pose[1]
        x, y = c * dx + s * dy - mount.x, c * dy - s * dx - mount.y
        cm, sm = math.cos(mount.yaw), math.sin(mount.yaw)
        return cm * x + sm * y, cm * y - sm * x
