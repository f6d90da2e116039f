"""How a chair rolls while its brakes are open: on a slope, from a push or turn on until they grip again.

A motor without demand gives way to the slope's pull with a steady speed, so the way is that speed times the time with
open brakes: the time of the push and the time until they grip. Across a slope it turns downhill in the same manner. All
three show in the odometry of each stop, after the motors have to stand.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from seater_common.se2 import relative

Array = NDArray[np.float64]

_SEEN = (0.002, 0.004)  # [m, rad] from which on it is a roll: two ticks of a coarse encoder
_NEWEST = 0.5  # weight of the newest stop
_SD, _SHARE = 0.002, 0.15  # [m], and share of the way, by which a roll differs from the last one
_WORTH_SAYING = 5.0  # [mm]
_USUAL_HOLD = 1.0  # [s] from the end of the demand until brakes grip; of powered chairs 0.3 to 2 s


@dataclass(frozen=True)
class Roll:
    """What stops have shown; nothing yet: `speed` is zero."""

    speed: float = 0.0  # [m/s] ahead (negative: back) while the brakes are open
    hold: float = _USUAL_HOLD  # [s] after the end of the demand
    turning: float = 0.0  # [rad/s] meanwhile

    def way(self, pushed: float = 0.0) -> float:
        """[m] ahead, of a move that is pushed for so long [s]."""
        return self.speed * (pushed + self.hold)

    def turn(self, pushed: float = 0.0) -> float:
        """[rad] that it turns beside what it is pushed for."""
        return self.turning * (pushed + self.hold)

    @property
    def seen(self) -> bool:
        """Whether it rolls at all."""
        return self.speed != 0.0 or self.turning != 0.0

    @property
    def in_words(self) -> str:
        """For the text of a result; empty where it hardly rolls."""
        way = 1e3 * self.way()
        return f", as it rolls {abs(way):.0f} mm until its brakes hold" if abs(way) >= _WORTH_SAYING else ""

    @property
    def sd(self) -> float:
        """[m] of `way`."""
        return math.hypot(_SD, _SHARE * self.way())

    def after(self, seen: Roll) -> Roll:
        """With one more stop, in which this one was seen."""
        if not self.seen:
            return seen
        old = 1.0 - _NEWEST
        speed, turning = old * self.speed + _NEWEST * seen.speed, old * self.turning + _NEWEST * seen.turning
        # Where nothing is seen, it did not roll, or not longer than its motors may have run on.
        return Roll(speed, old * self.hold + _NEWEST * seen.hold if seen.seen else self.hold, turning)


class RollWatch:
    """Of one stop: `see` each cycle, then ask what was `seen`."""

    def __init__(self, demand_ends: float, motors_stand: float) -> None:
        """Times [s] at which the last command ends to act, and at which the motors have to stand."""
        self._demand_ends, self._motors_stand = demand_ends, motors_stand
        self._from: Array | None = None
        self._times: list[float] = []  # [s]
        self._ways: list[tuple[float, float]] = []  # rolled, turned [m, rad]

    def see(self, stamp: float, pose: ArrayLike) -> None:
        """Where the chair is (3,), in any frame that does not move."""
        if stamp < self._motors_stand:
            return
        if self._from is None:
            self._from = np.array(pose, dtype=float)
        moved = relative(self._from, pose)
        self._times.append(stamp)
        self._ways.append((float(moved[0]), float(moved[2])))

    @property
    def since(self) -> float:
        """When the motors have to stand [s]."""
        return self._motors_stand

    @property
    def motors_stand(self) -> bool:
        """Whether they had to stand by the last cycle."""
        return self._from is not None

    def would_show(self, known: Roll) -> bool:
        """Whether what is known would have shown: not where brakes held before the motors had to stand."""
        return not known.seen or self.seen.seen or self._motors_stand - self._demand_ends < known.hold

    @property
    def seen(self) -> Roll:
        """Of a chair that stands by now. A steady roll has done half of its way in half of its time, whatever comes
        after it."""
        if self._from is None:
            return Roll()
        times, ways = np.array(self._times), np.array(self._ways) / _SEEN
        by = int(np.argmax(np.abs(ways[-1])))  # the one that shows best when it ended
        if abs(ways[-1, by]) < 1.0:
            return Roll()
        share = ways[:, by] / ways[-1, by]
        later = int(np.argmax(share >= 0.5))
        around = slice(max(later - 1, 0), later + 1)
        duration = max(2.0 * (float(np.interp(0.5, share[around], times[around])) - times[0]), 1e-3)
        speeds = np.where(np.abs(ways[-1]) < 1.0, 0.0, ways[-1] * _SEEN) / duration
        return Roll(float(speeds[0]), float(times[0] + duration - self._demand_ends), float(speeds[1]))
