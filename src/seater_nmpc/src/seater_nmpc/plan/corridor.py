"""The corridor that leads into the bay: narrow at the gate, wider ahead of it."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from seater_common.geometry import Chair, Dock
from seater_nmpc.parameters import SequenceParameters
from seater_nmpc.plan.free_space import final_straight_x

Array = NDArray[np.float64]


class Corridor:
    """Decides when the final straight may begin and when the bay was missed; poses: base_link in the dock's frame."""

    def __init__(self, chair: Chair, dock: Dock, parameters: SequenceParameters) -> None:
        self._parameters = parameters
        self._gate_x = final_straight_x(chair, dock) - parameters.gate_distance

    def contains(self, pose: Array) -> bool:
        """Whether lateral and heading error are small enough at this distance from the gate."""
        p = self._parameters
        ahead = max(0.0, self._gate_x - float(pose[0]))
        lateral = p.corridor_half_width + p.corridor_slope * ahead
        heading = p.corridor_heading + p.corridor_heading_slope * ahead
        return abs(float(pose[1])) <= lateral and abs(float(pose[2])) <= heading

    def missed(self, pose: Array) -> bool:
        """Whether the chair is past the gate and outside the corridor."""
        return float(pose[0]) > self._gate_x and not self.contains(pose)


# How much lateral error [m] is left as it is, at these places along the dock's axis [m].
_STRAIGHT_AT, _STRAIGHT_BAND = (-0.50, -0.35, -0.20), (0.0, 0.0005, 0.003)


def straight_in(pose: Array, short: float = 0.0) -> Array:
    """The target (3,) of the last stretch, in the dock's frame like `pose`: a small lateral error is left as it is.
    `short` [m]: so far before the dock.

    Mending the last millimetres there would end in a heading error: turning needs way, and there is none left.
    """
    band = float(np.interp(pose[0] + short, _STRAIGHT_AT, _STRAIGHT_BAND))
    return np.array([-short, min(max(float(pose[1]), -band), band), 0.0])
