"""The last correction, if one is needed: one small deliberate move, straight or turning on the spot.

It is timed, as it is over before odometry or images could steer it. Castors that point the wrong way, or carpet, hold
against it like a deadband: that much resistance is learned from how far the last move in the same direction got.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from seater_common.geometry import Limits
from seater_nmpc.drive.axis import AxisDrive, ChairDrive

Array = NDArray[np.float64]

_DURATION = 0.4  # [s] that a move takes about
_LONGEST = 2.0 * _DURATION
_FASTEST = (0.08, 0.35)  # [m/s, rad/s]
_MOST_MORE = (0.03, 0.1)  # [m/s, rad/s] by which the resistance that is reckoned with grows from move to move


@dataclass(frozen=True)
class _Axis:
    drive: AxisDrive
    rate: float  # largest change of the speed per second
    fastest: float
    most_more: float


class FineMove:
    """Ask it for the speeds of each cycle, until there are none. Errors: the chair in the dock's frame (3,)."""

    def __init__(
        self, error: Array, turning: bool, drive: ChairDrive, limits: Limits, before: FineMove | None = None
    ) -> None:
        """`error`: of the standing chair. `before`: the last move of this attempt, from whose result it learns."""
        self.turning, self._index = turning, 2 if turning else 0
        single, rate = (drive.omega, limits.alpha_max) if turning else (drive.v, limits.a_max)
        self._axis = _Axis(single, rate, _FASTEST[turning], _MOST_MORE[turning])
        self._begin = float(error[self._index])
        self._way = abs(self._begin)
        self._learned = {} if before is None else before._learned_after(error)
        self.resistance = self._learned.get((turning, self._begin > 0.0), 0.0)
        wanted = self.resistance + self._way / _DURATION
        self._fastest = min(max(wanted, single.smallest_speed), max(self._axis.fastest, single.smallest_speed))
        self._speed = self._done = self._time = 0.0

    def speeds(self, period: float) -> tuple[float, float] | None:
        """(v [m/s], omega [rad/s]) for the next `period` [s]; None: it is over."""
        half_a_cycle = 0.5 * max(0.0, self._speed - self.resistance) * period
        if self._done >= self._way - half_a_cycle or self._time > _LONGEST:
            return None
        self._speed = min(self._speed + self._axis.rate * period, self._fastest)
        moving = self._axis.drive.effective(self._axis.drive.command(self._speed)) if self._sure() else 0.0
        self._done += max(0.0, moving - self.resistance) * period
        self._time += period if moving > 0.0 else 0.0
        speed = -math.copysign(self._speed, self._begin)
        return (0.0, speed) if self.turning else (speed, 0.0)

    def _sure(self) -> bool:
        return self._speed >= self._axis.drive.smallest_speed

    def _learned_after(self, error: Array) -> dict[tuple[bool, bool], float]:
        """Resistance [m/s or rad/s] by (turning, error was positive), given where the chair stands after this move.

        A move the other way swings the castors: then nothing is known of its axis.
        """
        learned = {key: value for key, value in self._learned.items() if key[0] is not self.turning}
        left = float(error[self._index])
        if left * self._begin > 0.0:
            short = max(0.0, self._done - abs(self._begin - left))
            more = min(short / max(self._time, 0.5 * _DURATION), self._axis.most_more)
            learned[self.turning, self._begin > 0.0] = self.resistance + more
        return learned
