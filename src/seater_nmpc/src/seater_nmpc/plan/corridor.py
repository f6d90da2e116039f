"""The corridor that leads into the bay: narrow at the gate, wider ahead of it."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from seater_common.geometry import Chair, Dock
from seater_nmpc.parameters import SequenceParameters
from seater_nmpc.plan.free_space import final_straight_x

Array = NDArray[np.float64]

_WOULD_PASS = 0.5  # of the corridor's width and heading at the gate
_ANSWERS, _LEAST = 4.0, 0.12  # times its reaction that it has to the gate; [m/s]


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

    def speed(self, pose: Array, reaction: float) -> float:
        """Most [m/s] ahead of the gate for a chair that answers within `reaction` [s] and that would not pass it as it
        is at `pose`: it has to have time to mend that, or it has to back out. Infinite where it would."""
        p, ahead = self._parameters, self._gate_x - float(pose[0])
        aside = max(abs(float(pose[1])) / p.corridor_half_width, abs(float(pose[2])) / p.corridor_heading)
        if ahead <= 0.0 or aside <= _WOULD_PASS:
            return math.inf
        return max(_LEAST, ahead / max(_ANSWERS * reaction, 1e-3))


_MOST_BEYOND, _FREE = 0.04, 0.03  # [m] beyond the dock at most; that stay free ahead of the chair


def room_beyond(chair: Chair, dock: Dock) -> float:
    """How far [m] beyond the dock a chair may be driven that will roll back from there: neither to the back wall nor to
    a marker ahead of it."""
    half = 0.5 * chair.width + _FREE
    ahead = [marker.position[0] for marker in dock.markers if abs(marker.position[1]) - 0.5 * marker.size < half]
    room = min([dock.bay.back_wall_x, *ahead]) - chair.length_front - _FREE
    return min(max(room, 0.0), _MOST_BEYOND)


# How much lateral error [m] is left as it is, at these places along the dock's axis [m].
_STRAIGHT_AT, _STRAIGHT_BAND = (-0.50, -0.35, -0.20), (0.0, 0.0005, 0.003)


def straight_in(pose: Array, short: float = 0.0, heading: float = 0.0) -> Array:
    """The target (3,) of the last stretch, in the dock's frame like `pose`: a small lateral error is left as it is.
    `short` [m]: so far before the dock; negative: beyond it. `heading` [rad]: turned by so much there.

    Mending the last millimetres there would end in a heading error: turning needs way, and there is none left.
    """
    band = float(np.interp(pose[0] + short, _STRAIGHT_AT, _STRAIGHT_BAND))
    return np.array([-short, min(max(float(pose[1]), -band), band), heading])
