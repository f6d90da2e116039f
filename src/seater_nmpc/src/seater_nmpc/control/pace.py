"""How fast the chair may drive now, beside its own limits: what others ask for, slow cycles, weak motors."""

from __future__ import annotations

import math
from collections import deque

from seater_common.geometry import Limits
from seater_nmpc.drive.axis import ChairDrive

LONGEST_PERIOD = 0.5  # [s] between two cycles; longer is a pause
_WAY_PER_CYCLE, _TURN_PER_CYCLE = 0.06, 0.08  # [m, rad] most that is driven from one cycle to the next
_CYCLES = 3  # in a row that are longer than configured before they are reckoned with
_NOISE_OF_STAMPS = 1.1  # times the configured period: not longer


class Pace:
    """Tell it the time of each `cycle`."""

    def __init__(self, limits: Limits, control_period: float) -> None:
        """`limits`: the chair's own; `control_period` [s]: as configured."""
        self._limits, self._configured = limits, control_period
        self.period = control_period  # [s] measured between cycles, at least the configured one
        self._elapsed: deque[float] = deque(maxlen=_CYCLES)
        self.limit()
        self.cap()
        self.restart()

    def limit(self, v: float = math.inf, omega: float = math.inf, why: str = "") -> None:
        """Limits of |v| [m/s] and |omega| [rad/s] beside the chair's own from now on; without arguments: none."""
        self._limit, self._why = (max(0.0, v), max(0.0, omega)), why

    def cap(self, v: float = math.inf, omega: float = math.inf) -> None:
        """What a person wants at most, |v| [m/s] and |omega| [rad/s], whatever `limit` says."""
        self._cap = (max(0.0, v), max(0.0, omega))

    def restart(self) -> None:
        """The next cycle is the first; its period is the configured one, until several were longer."""
        self._last_stamp = -math.inf
        self._elapsed.append(0.0)

    def cycle(self, stamp: float) -> None:
        """A cycle, at this time [s]; only several in a row that were longer than configured make the period longer.

        Pauses do not count: a small move after one is planned for cycles that are as slow as those before.
        """
        elapsed, self._last_stamp = stamp - self._last_stamp, stamp
        if 0.0 < elapsed <= LONGEST_PERIOD:
            self._elapsed.append(elapsed)
        usual = min(self._elapsed)
        self.period = usual if usual > _NOISE_OF_STAMPS * self._configured else self._configured

    def limits(self, drive: ChairDrive) -> tuple[float, float] | None:
        """Those that hold now, of |v| and |omega|; None: the chair's own. A chair whose motors make less of a command
        than it says cannot be faster than its largest one makes it."""
        v, omega = self._asked()
        v = min(v, drive.v.effective(self._limits.v_max))
        omega = min(omega, drive.omega.effective(self._limits.omega_max))
        return (v, omega) if self._slower(v, omega) else None

    @property
    def why(self) -> str:
        """Why the chair drives slower than it may; empty when it does not."""
        if not self._slower(*self._asked()):
            return ""
        slow = self.period > self._configured
        return f"odometry comes only every {self.period:.2f} s" if slow else self._why

    def _asked(self) -> tuple[float, float]:
        """By others, and by slow cycles: what is not seen for long must not matter."""
        v, omega = (min(limits) for limits in zip(self._limit, self._cap, strict=True))
        if self.period > self._configured:
            v, omega = min(v, _WAY_PER_CYCLE / self.period), min(omega, _TURN_PER_CYCLE / self.period)
        return v, omega

    def _slower(self, v: float, omega: float) -> bool:
        return v < self._limits.v_max or omega < self._limits.omega_max
