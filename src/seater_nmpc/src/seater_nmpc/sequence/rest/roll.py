"""How a chair rolls while its brakes are open: on a slope, from a push or turn on until they grip again.

A motor without demand gives way to the slope's pull with a steady speed, so the way is that speed times the time with
open brakes: the time of the push and the time until they grip. Both show in the odometry of each stop, after the motors
have to stand.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from seater_common.se2 import relative

Array = NDArray[np.float64]

_SEEN = 0.002  # [m] rolled from which on it is a roll: two ticks of a coarse encoder
_NEWEST = 0.5  # weight of the newest stop
_SD, _SHARE = 0.002, 0.15  # [m], and share of the way, by which a roll differs from the last one
_USUAL_HOLD = 1.0  # [s] from the end of the demand until brakes grip; of powered chairs 0.3 to 2 s


@dataclass(frozen=True)
class Roll:
    """What stops have shown; nothing yet: `speed` is zero."""

    speed: float = 0.0  # [m/s] ahead (negative: back) while the brakes are open
    hold: float = _USUAL_HOLD  # [s] after the end of the demand

    def way(self, pushed: float = 0.0) -> float:
        """[m] ahead, of a move that is pushed for so long [s]."""
        return self.speed * (pushed + self.hold)

    @property
    def sd(self) -> float:
        """[m] of `way`."""
        return math.hypot(_SD, _SHARE * self.way())

    def after(self, seen: Roll) -> Roll:
        """With one more stop, in which this one was seen."""
        if seen.speed == 0.0:  # it did not roll, or not longer than its motors may have run on
            return Roll((1.0 - _NEWEST) * self.speed, self.hold)
        if self.speed == 0.0:
            return seen
        mean = (1.0 - _NEWEST) * np.array([self.speed, self.hold]) + _NEWEST * np.array([seen.speed, seen.hold])
        return Roll(*mean.tolist())


class RollWatch:
    """Of one stop: `see` each cycle, then ask what was `seen`."""

    def __init__(self, demand_ends: float, motors_stand: float) -> None:
        """Times [s] at which the last command ends to act, and at which the motors have to stand."""
        self._demand_ends, self._motors_stand = demand_ends, motors_stand
        self._from: Array | None = None
        self._ways: list[tuple[float, float]] = []  # (time [s], rolled [m])

    def see(self, stamp: float, pose: ArrayLike) -> None:
        """Where the chair is (3,), in any frame that does not move."""
        if stamp < self._motors_stand:
            return
        if self._from is None:
            self._from = np.array(pose, dtype=float)
        self._ways.append((stamp, float(relative(self._from, pose)[0])))

    @property
    def since(self) -> float:
        """When the motors have to stand [s]."""
        return self._motors_stand

    @property
    def motors_stand(self) -> bool:
        """Whether they had to stand by the last cycle."""
        return self._from is not None

    @property
    def seen(self) -> Roll:
        """Of a chair that stands by now. A steady roll has done half of its way in half of its time, whatever comes
        after it."""
        if self._from is None or abs(self._ways[-1][1]) < _SEEN:
            return Roll()
        begin, half = self._ways[0][0], 0.5 * self._ways[-1][1]
        later = next(k for k, (_, way) in enumerate(self._ways) if way / half >= 1.0)
        (t0, w0), (t1, w1) = self._ways[max(later - 1, 0)], self._ways[later]
        middle = t1 if w1 == w0 else t0 + (t1 - t0) * (half - w0) / (w1 - w0)
        duration = max(2.0 * (middle - begin), 1e-3)
        return Roll(2.0 * half / duration, begin + duration - self._demand_ends)
