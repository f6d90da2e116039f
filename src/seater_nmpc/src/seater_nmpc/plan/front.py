"""Whether the chair is in front of the bay, from where the markers can be seen all the way in."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from seater_common.field_of_view import FieldOfView
from seater_common.geometry import Chair, Dock
from seater_common.se2 import wrap_angle
from seater_common.sight import Sight
from seater_nmpc.ocp.constraints.view import kept_markers

Array = NDArray[np.float64]

_ALL_AHEAD = FieldOfView.symmetric(0.49 * math.pi)  # whatever the camera: the chair can turn


class Front:
    """Of one dock. Poses: base_link in the dock's frame."""

    def __init__(self, chair: Chair, dock: Dock) -> None:
        self._yaw = chair.camera.yaw
        self._sight, self._markers = Sight(chair.camera, dock, _ALL_AHEAD), kept_markers(dock)
        self._middle = np.mean([dock.markers[index].position[:2] for index in self._markers], axis=0)

    def hidden(self, pose: Array) -> bool:
        """Whether, from this place, side walls or the prints' backs hide all markers by which the chair drives in,
        however it turns. It may be that another marker is seen."""
        turned = np.array([[pose[0], pose[1], float(pose[2]) + self.aside(pose)]])
        return not bool(np.any(self._sight.seen(turned, self._markers)))

    def aside(self, pose: Array) -> float:
        """Angle [rad] from the camera's axis to the direction in which the markers are, positive to the left."""
        towards = math.atan2(self._middle[1] - pose[1], self._middle[0] - pose[0])
        return wrap_angle(towards - self._yaw - float(pose[2]))
