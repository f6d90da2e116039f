"""What stands in the way, and whether the chair stops short of it."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np
from numpy.typing import ArrayLike, NDArray

from seater_common.geometry import Bay, Chair
from seater_common.separation import convex_outline
from seater_nmpc.control.braking import BrakingCheck
from seater_nmpc.drive.axis import ChairDrive
from seater_nmpc.parameters import ControlParameters

Array = NDArray[np.float64]

# Margin from the bay's walls: [m], and [s] of delay that nobody told and that is not learned yet; at most a share of
# the margin of the plan, in a narrow bay little.
_FROM_WALLS, _UNTOLD, _SHARE = 0.005, 0.15, 0.6


class Clearance:
    """Of one chair, from the walls of its bay and the obstacles that were `set` last."""

    def __init__(self, chair: Chair, bay: Bay, parameters: ControlParameters) -> None:
        p = parameters
        self._possible, self._lag, self._a_max = p.walls, p.prediction.motor_lag, chair.limits.a_max
        self._braking = BrakingCheck(chair, p.stop_margin, p.control_period, self._lag)
        self._from_walls, self._most = BrakingCheck(chair, 0.0, p.control_period, self._lag), _SHARE * p.margin
        self._walls = bay.outlines()
        corners = np.concatenate(self._walls)
        self._box = corners.min(axis=0), corners.max(axis=0)
        self._radius = float(np.max(np.hypot(*chair.corners().T)))
        self.outlines: list[Array] = []  # convex, anticlockwise, (n, 2) in the dock's frame [m]

    def set(self, polygons: Sequence[ArrayLike]) -> None:
        """Corners (n, 2) of each in the dock's frame [m]. Raises: as `DockingController.set_obstacles`."""
        outlines = [convex_outline(polygon) for polygon in polygons]
        if outlines and not self._possible:
            raise ValueError("control/walls: is false, must be true for obstacles to be kept clear of")
        self.outlines = outlines

    def too_near(
        self, at: Array, speed: float, v: float, omega: float, path: Array | None, period: float, drive: ChairDrive
    ) -> str:
        """What a command v [m/s], omega [rad/s] would bring the chair too near to, that begins to act at the pose `at`
        (3,) in the dock's frame, where the chair drives at `speed` [m/s], and holds for `period` [s]; empty: nothing.
        `path` (n, 3): the plan's poses from there on."""
        hold = period + max(drive.lag_v, drive.lag_omega, self._lag)
        self._braking.hold = self._from_walls.hold = hold
        self._from_walls.margin = min(_FROM_WALLS + _UNTOLD * max(abs(v), abs(speed)), self._most)
        if self.outlines and not self._braking.passes(at, v, omega, self.outlines, path):
            return "an obstacle is within the stopping distance"
        if self._reaches(at, v, hold) and not self._from_walls.passes(at, v, omega, self._walls, path):
            return "a wall of the bay is within the stopping distance"
        return ""

    def _reaches(self, at: Array, v: float, hold: float) -> bool:
        """Whether the chair may come near the walls at all before it stands."""
        if not self._possible:
            return False
        way = abs(v) * hold + 0.5 * v * v / self._a_max + self._most
        low, high = self._box
        off = np.maximum(np.maximum(low - at[:2], at[:2] - high), 0.0)
        return math.hypot(*off) <= self._radius + way
