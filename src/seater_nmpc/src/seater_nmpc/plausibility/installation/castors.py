"""Where castors swing round, wheels do not tell how the chair moves.

A castor that does not trail pushes the chair, in part against tyres that give way, so that no wheel shows it. That is
no noise: it has the same sign at each reversal, and would look like a camera mounted elsewhere.

Which way they point is followed as a trailer follows (the tractrix): with e the angle between a castor and the way of
its stem, s that way and L the trail, tan(e / 2) shrinks as exp(-s / L). One that points the wrong way (e = pi) comes
round after a way that nobody knows; one that stands across (straight on, then a turn on the spot) at once.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from seater_nmpc.observe.odometry.instant import Instant

Array = NDArray[np.float64]

_TRAIL = 0.08  # [m] of a large indoor castor
_WRONG_WAY = 60.0  # tangent of half the angle, at most: it has come round after 0.3 m, and trails after 0.5 m
_ARM = 0.5  # [m] from the drive axle to the castors
_ALONG = 0.3  # standard deviation of way not seen, per way that the castors roll in one step, pointing the wrong way
_TURN = 1.0  # [rad/m] the same of turning
_TRAILS = 0.1  # tangent of half the angle from which on a castor trails


class Castors:
    """Follows which way they roll."""

    def __init__(self) -> None:
        self._points: float | None = None  # [rad] direction in the chair, of one that trails; None: not known

    def noise(self, last: Instant, now: Instant, dock: Array) -> Array:
        """Covariance (3, 3) of what the castors move the `dock` (3,) in odom, from `last` to `now`, that wheels do not
        show; zero where they trail."""
        step, heading = now.pose - last.pose, float(now.pose[2])
        along = np.array([math.cos(heading), math.sin(heading)])
        way, turn = float(step[:2] @ along), math.remainder(float(step[2]), 2.0 * math.pi)
        rolled, ahead = math.hypot(way, _ARM * turn), math.atan2(_ARM * turn, way)
        off = self._off(ahead)
        self._points = ahead + math.copysign(2.0 * math.atan(abs(off) * math.exp(-rolled / _TRAIL)), off)
        if abs(off) < _TRAILS:
            return np.zeros((3, 3))
        share = off * off / (1.0 + off * off)  # sin^2(e / 2): 1 where it points the wrong way
        line = np.array([*along, 0.0])
        swing = np.array([now.pose[1] - dock[1], dock[0] - now.pose[0], 1.0])
        by_way, by_turn = (_ALONG * rolled * share) ** 2, (_TURN * rolled) ** 2 * share
        return by_way * np.outer(line, line) + by_turn * np.outer(swing, swing)

    def _off(self, ahead: float) -> float:
        """Tangent of half the angle from the way that they roll to where they point."""
        if self._points is None:
            return _WRONG_WAY
        half = 0.5 * math.remainder(self._points - ahead, 2.0 * math.pi)
        return max(-_WRONG_WAY, min(_WRONG_WAY, math.tan(half)))
