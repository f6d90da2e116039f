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
_MOST_MORE, _MOST_EFFORT = 2.0, 6.0


class FineMove:
    """Ask it for the speeds of each cycle, until there are none. Errors: the chair in the dock's frame (3,)."""

    def __init__(
        self, error: Array, turning: bool, drive: ChairDrive, delay: float, now: float, *, effort: float = 1.0
    ) -> None:
        """`error`: of the standing chair. `delay` [s] of a command. `effort`: how many times more than the way to go
        is asked for, as the last move fell short (see `fell_short`)."""
        self.turning, self._error, self._effort = turning, np.array(error, dtype=float), effort
        self._began, self._asked_since = now, now
        self._axis, axis = (2, drive.omega) if turning else (0, drive.v)
        self._forward = -math.copysign(1.0, float(error[self._axis]))
        self._fastest = _FASTEST_OMEGA if turning else _FASTEST_SPEED
        slow = max(_OMEGA if turning else _SPEED, _SURE * axis.smallest_speed)
        self._speed = min(slow * effort, max(self._fastest, slow))
        self._response = delay + 2.0 * (drive.lag_omega if turning else drive.lag_v) + _PATIENCE

    def speeds(self, now: float, rest_error: Array, motion: tuple[float, float], period: float) -> Array | None:
        """(v, omega) for the next `period` [s]; None: it has been asked for enough.

        `rest_error`: where the chair will come to rest if nothing more is asked. `motion`: measured speeds.
        """
        begin, now_at = float(self._error[self._axis]), float(rest_error[self._axis])
        to_go = -self._forward * (self._effort * begin + (now_at - begin))
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

    def effort_after(self, error: Array) -> float:
        """The effort for the next move in the same direction, given where the chair stands after this one.

        Castors that point the wrong way, or carpet, take most of a small move.
        """
        begin, left = float(self._error[self._axis]), float(error[self._axis])
        if begin * left <= 0.0:
            return 1.0  # overshot: what held it is overcome
        done = 1.0 - left / begin
        return min(self._effort * min(max(1.0 / max(done, 1e-3), 1.0), _MOST_MORE), _MOST_EFFORT)
