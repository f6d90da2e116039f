"""Whether a sensor sees at all: one that is covered or repeats itself says "nothing there", as an empty room does."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike, NDArray

from seater_common.se2 import wrap_angle
from seater_obstacles.sight import Sight

Array = NDArray[np.float64]

# So far the chair has to go before a measurement that did not change counts as repeated: a sensor without noise says
# the same again and again while it stands.
_DISTANCE = 0.02  # [m]
_TURN = 0.03  # [rad]


class SensorFailsError(ValueError):
    """The sensor does not see, and what it says must not be used."""


class SensorWatch:
    """Tell it each measurement of one sensor, in their order."""

    def __init__(self, least: int) -> None:
        """`least`: so many rays or pixels have to meet something."""
        self._least = least
        self._last: bytes | None = None
        self._place: Array = np.zeros(3)  # of the chair in odom when `_last` came first

    def check(self, sight: Sight, measured: bytes, T_odom_base: ArrayLike, *, too_near: bool = False) -> None:
        """A new measurement.

        Args:
            sight: what it says.
            measured: as the sensor told it, without stamp.
            T_odom_base: (x, y, heading) of the chair at its stamp.
            too_near: a sensor that works may meet nothing here, as the dock is nearer than it can measure.

        Raises:
            SensorFailsError: it meets nothing at all, or is the same as before though the chair has moved.
        """
        if measured != self._last:
            self._last, self._place = measured, np.array(T_odom_base, dtype=float)
        if sight.met < self._least:
            if too_near:
                return
            raise SensorFailsError("the sensor meets nothing at all (covered, without power, or its limits wrong?)")
        dx, dy, turn = np.asarray(T_odom_base, dtype=float) - self._place
        if np.hypot(dx, dy) > _DISTANCE or abs(wrap_angle(turn)) > _TURN:
            raise SensorFailsError("the sensor repeats its measurement though the chair moves")
