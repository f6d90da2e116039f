"""Where castors swing round, wheels do not tell how the chair moves.

A castor that does not trail pushes the chair, in part against tyres that give way, so that no wheel shows it. That is
no noise: it has the same sign at each reversal, and would look like a camera mounted elsewhere.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from seater_nmpc.observe.odometry import Instant

Array = NDArray[np.float64]

_SWING = 0.3  # [m] that castors roll until they trail: five times the trail of an indoor chair's
_ARM = 0.5  # [m] from the drive axle to the castors
_ALONG = 0.3  # standard deviation of way not seen, per way that the castors roll in one step
_TURN = 1.0  # [rad/m] the same of turning


class Castors:
    """Follows which way they roll."""

    def __init__(self) -> None:
        self._direction = 0
        self._left = _SWING  # where they point at first is not known

    def noise(self, last: Instant, now: Instant, dock: Array) -> Array:
        """Covariance (3, 3) of what the castors move the `dock` (3,) in odom, from `last` to `now`, that wheels do not
        show; zero where they trail."""
        step, heading = now.pose - last.pose, float(now.pose[2])
        along = np.array([math.cos(heading), math.sin(heading)])
        way, turn = float(step[:2] @ along), now.turned - last.turned
        direction = int(np.sign(way)) if abs(way) > _ARM * turn else 0
        rolled = abs(way) + _ARM * turn
        if direction == 0 or direction != self._direction:
            self._left, self._direction = _SWING, direction
        swings, self._left = self._left > 0.0, self._left - rolled
        if not swings:
            return np.zeros((3, 3))
        line = np.array([*along, 0.0])
        swing = np.array([now.pose[1] - dock[1], dock[0] - now.pose[0], 1.0])
        return (_ALONG * rolled) ** 2 * np.outer(line, line) + (_TURN * rolled) ** 2 * np.outer(swing, swing)
