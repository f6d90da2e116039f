"""The front castors, taken as one: while they swing round, they push the chair.

A castor of trail L whose stem moves with speed u turns towards the direction of u. With e the angle between them,

    de/ds = -sin(e) / L,   so   tan(e(s) / 2) = tan(e(0) / 2) exp(-s / L),

(the towed wheel's tractrix). Across (e = 90 degrees) it pushes sideways and so turns the chair; pointing the wrong way
(e = 180 degrees) it only brakes.
"""

from __future__ import annotations

import math

_AHEAD = 0.45  # [m] of the driven axle
_TRAIL = 0.07  # [m]
_FULL_SPEED = 0.05  # [m/s] of the stem from which on the push is whole; a standing chair is not pushed


class Castors:
    """Direction of the castors in the chair, and what they do to it."""

    def __init__(self, omega: float, v: float, direction: float) -> None:
        """`omega` [rad/s], `v` [m/s]: largest push; `direction` [rad]: at the start."""
        self._omega, self._v, self.direction = omega, v, direction

    def step(self, v: float, omega: float, duration: float) -> tuple[float, float]:
        """(v, omega) of the push, for a chair that drives with these speeds [m/s, rad/s] for `duration` [s]."""
        if self._omega == 0.0 and self._v == 0.0:
            return 0.0, 0.0
        across = omega * _AHEAD
        speed = math.hypot(v, across)
        if speed < 1e-6:
            return 0.0, 0.0
        off = math.remainder(self.direction - math.atan2(across, v), 2.0 * math.pi)
        whole = min(1.0, speed / _FULL_SPEED)
        after = 2.0 * math.atan(math.tan(0.5 * off) * math.exp(-speed * duration / _TRAIL))
        self.direction += after - off
        braking = 0.5 * (1.0 - math.cos(off))
        return -math.copysign(1.0, v) * self._v * braking * whole, self._omega * math.sin(off) * whole
