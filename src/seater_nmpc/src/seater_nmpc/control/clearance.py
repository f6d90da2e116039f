"""What stands in the way, and whether the chair stops short of it."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import ArrayLike, NDArray

from seater_common.geometry import Chair
from seater_common.separation import convex_outline
from seater_nmpc.control.braking import BrakingCheck
from seater_nmpc.drive.axis import ChairDrive
from seater_nmpc.parameters import ControlParameters

Array = NDArray[np.float64]

TOO_NEAR = "an obstacle is within the stopping distance"


class Clearance:
    """Of one chair, among the obstacles that were `set` last."""

    def __init__(self, chair: Chair, parameters: ControlParameters) -> None:
        self._possible, self._lag = parameters.walls, parameters.prediction.motor_lag
        self._braking = BrakingCheck(chair, parameters.stop_margin, parameters.control_period, self._lag)
        self.outlines: list[Array] = []  # convex, anticlockwise, (n, 2) in the dock's frame [m]

    def set(self, polygons: Sequence[ArrayLike]) -> None:
        """Corners (n, 2) of each in the dock's frame [m]. Raises: as `DockingController.set_obstacles`."""
        outlines = [convex_outline(polygon) for polygon in polygons]
        if outlines and not self._possible:
            raise ValueError("control/walls: is false, must be true for obstacles to be kept clear of")
        self.outlines = outlines

    def is_kept(
        self, acts_at: Array, v: float, omega: float, path: Array | None, period: float, drive: ChairDrive
    ) -> bool:
        """By a command v [m/s], omega [rad/s] that begins to act at `acts_at` (3,) in the dock's frame and holds for
        `period` [s]; `path` (n, 3): the plan's poses from there on."""
        if not self.outlines:
            return True
        self._braking.hold = period + max(drive.lag_v, drive.lag_omega, self._lag)
        return self._braking.passes(acts_at, v, omega, self.outlines, path)
