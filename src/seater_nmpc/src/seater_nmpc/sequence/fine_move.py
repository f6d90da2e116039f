"""The last correction, if one is needed: one small deliberate move, straight or turning on the spot.

It is driven at a speed that surely moves the chair, and it ends when the chair, coasting, would come to rest where it
should. Where nothing moves, the speed grows until it does.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from seater_nmpc.drive.axis import ChairDrive

Array = NDArray[np.float64]

_SPEED, _OMEGA = 0.02, 0.05  # [m/s, rad/s] of a move by a chair without a deadband
_SURE = 1.6  # times the deadband
_FASTEST_SPEED, _FASTEST_OMEGA = 0.08, 0.25
_MOVED = 0.2  # fraction of the speed from which on the chair moves
_PATIENCE = 0.3  # [s] beyond delay and lag, after which a chair that does not move is asked for more
_MORE = 1.25
_LONGEST = 6.0  # [s]


class FineMove:
    """Ask it for the speeds of each cycle, until there are none. Errors: the chair in the dock's frame (3,)."""

    def __init__(self, error: Array, turning: bool, drive: ChairDrive, delay: float, now: float) -> None:
        """`error`: of the standing chair. `delay` [s] of a command."""
        self.turning, self._began, self._asked_since = turning, now, now
        self._axis, axis = (2, drive.omega) if turning else (0, drive.v)
        self._forward = -math.copysign(1.0, float(error[self._axis]))
        self._speed = max(_OMEGA if turning else _SPEED, _SURE * axis.smallest_speed)
        self._fastest = _FASTEST_OMEGA if turning else _FASTEST_SPEED
        self._response = delay + 2.0 * (drive.lag_omega if turning else drive.lag_v) + _PATIENCE

    def speeds(self, now: float, rest_error: Array, motion: tuple[float, float], period: float) -> Array | None:
        """(v, omega) for the next `period` [s]; None: it has been asked for enough.

        `rest_error`: where the chair will come to rest if nothing more is asked. `motion`: measured speeds.
        """
        to_go = -self._forward * float(rest_error[self._axis])
        if to_go <= 0.5 * self._speed * period or now - self._began > _LONGEST:
            return None
        moves = self._forward * motion[1 if self.turning else 0] >= _MOVED * self._speed
        if moves:
            self._asked_since = now
        elif now - self._asked_since > self._response:
            self._speed = min(_MORE * self._speed, self._fastest)
            self._asked_since = now - self._response + _PATIENCE
        speed = self._forward * self._speed
        return np.array([0.0, speed]) if self.turning else np.array([speed, 0.0])
