"""Where the chair is, by the counts of its two encoders."""

from __future__ import annotations

import math
from collections import deque
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from seater_base.protocol import Reading
from seater_base.settings import BaseSettings
from seater_common.device_clock import DeviceClock
from seater_common.se2 import arc_step

Array = NDArray[np.float64]

_WORD = 2**32
_SPEED_TIME = 0.06  # [s] that speeds are means over, so that single counts do not make noise
_LONGEST = 5.0  # [s] between two readings; longer: the base has started anew
_LATER = 1e-4  # [s] at least from one reading to the next, whatever the estimate of the clocks does


@dataclass(frozen=True, eq=False)
class Driven:
    """base_link in odom, and how it moves."""

    time: float  # [s] by the host's steady clock
    pose: Array  # (3,) [m, m, rad]
    pose_covariance: Array  # (3, 3)
    v: float  # [m/s]
    omega: float  # [rad/s]
    speed_sd: tuple[float, float]  # of both


class WheelOdometry:
    """Feed it with every reading. A base that has started anew, or that leaps, moves nothing."""

    def __init__(self, settings: BaseSettings) -> None:
        self._wheels, self._noise = settings.wheels, settings.noise
        self.clock = DeviceClock(period=_WORD * 1e-3)
        self._last: Reading | None = None
        self._recent: deque[tuple[float, float, float]] = deque()  # duration [s], way [m], turn [rad]
        self._time = -math.inf
        self.pose, self._P = np.zeros(3), np.zeros((3, 3))
        self.leaps = 0  # readings that cannot follow the last one

    def disconnected(self) -> None:
        """The next reading is a beginning: what happened meanwhile is not known."""
        self._last = None

    def add(self, reading: Reading, arrival: float) -> Driven | None:
        """`arrival` [s] by the steady clock. None: nothing to tell (a beginning, a repetition, a leap)."""
        before, self._last = self._last, reading
        time = self.clock.to_host(1e-3 * reading.clock, arrival)
        if before is None:
            self._recent.clear()
            return None
        duration = 1e-3 * ((reading.clock - before.clock) % _WORD)
        left = _difference(reading.left, before.left) / self._wheels.left_counts
        right = _difference(reading.right, before.right) / self._wheels.right_counts
        if duration == 0.0:
            return None
        if duration > _LONGEST or max(abs(left), abs(right)) > self._wheels.fastest * duration:
            self.leaps += 1
            self._recent.clear()
            return None
        self._time = max(time, self._time + _LATER)
        return self._drive(self._time, duration, 0.5 * (left + right), (right - left) / self._wheels.separation)

    def _drive(self, time: float, duration: float, way: float, turn: float) -> Driven:
        self._spread(way, turn)
        self.pose = arc_step(self.pose, way / duration, turn / duration, duration)
        self._recent.append((duration, way, turn))
        while sum(step[0] for step in self._recent) - self._recent[0][0] >= _SPEED_TIME:
            self._recent.popleft()
        total, ways, turns = np.sum(list(self._recent), axis=0).tolist()
        count = 1.0 / min(abs(self._wheels.left_counts), abs(self._wheels.right_counts))  # [m]
        sd = (count / total, 2.0 * count / total / self._wheels.separation)
        return Driven(time, self.pose, self._P.copy(), ways / total, turns / total, sd)

    def _spread(self, way: float, turn: float) -> None:
        """P grows as for a unicycle: F P F^T + G Q G^T, with the heading in the middle of the step."""
        heading, n = self.pose[2] + 0.5 * turn, self._noise
        c, s = math.cos(heading), math.sin(heading)
        F = np.array([[1.0, 0.0, -way * s], [0.0, 1.0, way * c], [0.0, 0.0, 1.0]])
        G = np.array([[c, 0.0], [s, 0.0], [0.0, 1.0]])
        Q = np.diag([n.distance**2 * abs(way), n.heading**2 * abs(way) + n.turn**2 * abs(turn)])
        self._P = F @ self._P @ F.T + G @ Q @ G.T


def _difference(after: int, before: int) -> int:
    """Of two counters with 32 bits, the short way round."""
    return (after - before + _WORD // 2) % _WORD - _WORD // 2
