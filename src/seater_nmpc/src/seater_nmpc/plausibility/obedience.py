"""Whether the chair does what it is asked to, by its odometry: runaway, wrong direction, blocked.

Nothing here needs to know how the motors follow, only bounds of it: a command may act late by the delay, the lag and
RESPONSE more, and a chair that is asked to stop slows down by at least half of what its limits allow.
"""

from __future__ import annotations

import math
from collections import deque
from dataclasses import dataclass

from seater_common.geometry import Limits
from seater_nmpc.drive.prediction import CommandHistory
from seater_nmpc.observe.odometry.buffer import OdometryBuffer
from seater_nmpc.parameters import PlausibilityParameters
from seater_nmpc.plausibility.contradiction import Contradiction, Kind
from seater_nmpc.plausibility.slowing import Slowing

Speeds = tuple[float, float]  # v [m/s], omega [rad/s]

RESPONSE = 0.25  # [s] beyond the believed delay and lag, after which a command surely acts
_GAIN = 1.3  # speed over command up to which it is no runaway
_SLOWS_DOWN = 0.5  # times the limits of acceleration
_SENDERS = (1.0, 4)  # [s], jumps of the pose in it: one that is corrected, or started anew, jumps once
_MEAN = 0.15  # [s] over which speeds are taken
_MEMORY = 5.0  # [s]
_STANDS = (0.004, 0.04)  # [m, rad] farthest that a blocked chair is moved meanwhile (a gyro's bias turns its odom)
_AGAINST = ((0.03, 0.04), (0.2, 0.08))  # [m/s, rad/s] per axis: asked for at least, driven the other way at least
_DISOBEYS = 0.6  # times its speed: a chair that is asked for less than this all the while should slow down
_KEEPS = 0.05  # [s] how long a chair has to keep a speed that it was to slow down from
_BRAKES = ((0.25, 0.02), (0.25, 0.05))  # [s, m/s or rad/s] per axis: a chair that slows down by this obeys
# Motors that have pushed a chair over a sill let it go for a moment: one that slows down by this share of its peak has
# so much longer [s].
_SLOWED, _LET_GO = 0.1, 0.3


@dataclass(frozen=True)
class _Asked:
    stamp: float
    speeds: Speeds


class Obedience:
    """Tell it what is asked for in each cycle, and `check`."""

    def __init__(self, history: CommandHistory, limits: Limits, parameters: PlausibilityParameters) -> None:
        self._history, self._parameters = history, parameters
        self._rates = (_SLOWS_DOWN * limits.a_max, _SLOWS_DOWN * limits.alpha_max)
        self._slowing = Slowing(history, limits)
        self.restart(0.0)

    def restart(self, now: float) -> None:
        """A goal begins at `now` [s]. The speeds of the chair at the first `check` count as asked for, by whomever."""
        self._begun, self._last = now, now
        self._asked: deque[_Asked] = deque()
        self._measured: deque[_Asked] = deque()
        self._bounds = [0.0, 0.0]  # of the speeds, as far as what was asked for explains them
        # Runaway and wrong direction of both axes, and a speed that is kept.
        self._wrong_since = [math.inf, math.inf, math.inf, math.inf, math.inf]
        self._slowing.restart()

    def asked(self, stamp: float, v: float, omega: float) -> None:
        """What this cycle sends; of two for one stamp the later one counts (the first are the chair's own speeds)."""
        if len(self._asked) > 1 and self._asked[-1].stamp == stamp:
            self._asked.pop()
        self._asked.append(_Asked(stamp, (v, omega)))
        while self._asked[0].stamp < stamp - _MEMORY:
            self._asked.popleft()

    def check(self, now: float, odometry: OdometryBuffer) -> Contradiction | None:
        """At message time `now` [s], once in each cycle."""
        jumps = odometry.jumps_since(now - _SENDERS[0])
        if jumps >= _SENDERS[1]:
            text = f"its poses have jumped {jumps} times in {_SENDERS[0]:g} s: do two nodes publish it?"
            return Contradiction(Kind.ODOMETRY_WRONG, f"the odometry contradicts itself, {text}")
        speeds = odometry.mean_speeds(_MEAN)
        if speeds is None:
            return None
        if not self._measured:
            self._asked.appendleft(_Asked(now, speeds))
        self._measured.append(_Asked(now, speeds))
        while self._measured[0].stamp < now - _MEMORY:
            self._measured.popleft()
        keeps = self._keeps(now, speeds)
        found = self._runaway(now, speeds) or keeps or self._wrong_direction(now, speeds)
        found = found or self._blocked(now, odometry)
        self._last = now
        return found

    def _hold(self, axis: int) -> float:
        drive = self._history.drive
        return self._history.delay + (drive.lag_v, drive.lag_omega)[axis] + RESPONSE

    def _recent(self, now: float, axis: int, duration: float) -> list[float]:
        """What was asked for over the last `duration` [s], the command before that included."""
        values: list[float] = []
        for asked in reversed(self._asked):
            values.append(asked.speeds[axis])
            if asked.stamp <= now - duration:
                break
        return values

    def _runaway(self, now: float, speeds: Speeds) -> Contradiction | None:
        p, drive = self._parameters, self._history.drive
        excess = (p.runaway_speed, p.runaway_turning)
        for axis, name, unit in ((0, "drives", "m/s"), (1, "turns", "rad/s")):
            asked = [abs(value) for value in self._recent(now, axis, self._hold(axis))]
            turning = abs(drive.curvature * speeds[0]) if axis else 0.0  # by itself, as learned
            gain = max(_GAIN, _GAIN * (drive.v, drive.omega)[axis].gain)
            wanted = gain * max(asked, default=0.0)
            self._bounds[axis] = max(wanted, self._bounds[axis] - self._rates[axis] * (now - self._last))
            size = abs(speeds[axis]) - turning - excess[axis]
            disobeys = max(asked, default=0.0) < _DISOBEYS * abs(speeds[axis]) and not self._braking(now, axis)
            beyond = size > self._bounds[axis] or (size > _DISOBEYS * excess[axis] and disobeys)
            if self._lasts(now, axis, beyond, p.runaway_time + self._let_go(now, axis)):
                text = f"{name} at {speeds[axis]:.2f} {unit} though at most {max(asked, default=0.0):.2f} is asked for"
                return Contradiction(Kind.RUNAWAY, f"{text} (motor controller, brake, or somebody pushes?)")
        return None

    def _keeps(self, now: float, speeds: Speeds) -> Contradiction | None:
        expected = self._slowing.keeps(now, speeds[0], self._asked_at)
        if not self._lasts(now, 4, expected is not None, _KEEPS) or expected is None:
            return None
        text = f"drives at {speeds[0]:.2f} m/s though it was asked to slow down to {expected:.2f} by now"
        return Contradiction(Kind.RUNAWAY, f"{text} (motor controller, or brake?)")

    def _asked_at(self, stamp: float) -> float:
        """The speed that was asked for at a time [s], the first one before that."""
        earlier = (one.speeds[0] for one in reversed(self._asked) if one.stamp <= stamp)
        return next(earlier, self._asked[0].speeds[0])

    def _wrong_direction(self, now: float, speeds: Speeds) -> Contradiction | None:
        for axis, name, unit in ((0, "drives", "m/s"), (1, "turns", "rad/s")):
            asked, (least, against) = self._recent(now, axis, self._hold(axis)), _AGAINST[axis]
            same = bool(asked) and self._asked[0].stamp <= now - self._hold(axis)
            sign = math.copysign(1.0, asked[0]) if asked else 1.0
            same = same and all(sign * value >= least for value in asked)
            wrong = same and -sign * speeds[axis] >= against and not self._braking(now, axis)
            if self._lasts(now, 2 + axis, wrong, self._parameters.runaway_time):
                text = f"{name} at {speeds[axis]:.2f} {unit} though {asked[0]:.2f} is asked for"
                return Contradiction(Kind.WRONG_DIRECTION, f"{text} (a motor or an encoder connected the wrong way?)")
        return None

    def _braking(self, now: float, axis: int) -> bool:
        duration, least = _BRAKES[axis]
        before = next((m for m in reversed(self._measured) if m.stamp <= now - duration), self._measured[0])
        return abs(before.speeds[axis]) - abs(self._measured[-1].speeds[axis]) >= least

    def _let_go(self, now: float, axis: int) -> float:
        """[s] that a chair has which slows down from a peak."""
        duration, least = _BRAKES[axis]
        recent = [abs(m.speeds[axis]) for m in self._measured if m.stamp >= now - duration]
        return _LET_GO if max(recent) - recent[-1] >= max(least, _SLOWED * max(recent)) else 0.0

    def _lasts(self, now: float, which: int, wrong: bool, duration: float) -> bool:
        if not wrong:
            self._wrong_since[which] = math.inf
            return False
        self._wrong_since[which] = min(self._wrong_since[which], now)
        return now - self._wrong_since[which] >= duration - 1e-6

    def _blocked(self, now: float, odometry: OdometryBuffer) -> Contradiction | None:
        p, newest = self._parameters, odometry.newest
        before = odometry.at(now - p.blocked_time)
        if newest is None or before is None or now - self._begun < p.blocked_time:
            return None
        moved = newest.driven - before.driven, newest.turned - before.turned
        if moved[0] > _STANDS[0] or moved[1] > _STANDS[1]:
            return None
        for axis, least in ((0, p.blocked_speed), (1, p.blocked_turning)):
            window = p.blocked_time + self._hold(axis)
            asked = self._recent(now, axis, window)
            if not asked or self._asked[0].stamp > now - window:
                continue
            if min(asked) >= least or max(asked) <= -least:
                unit = ("m/s", "rad/s")[axis]
                text = f"stood for {p.blocked_time:.1f} s though {asked[0]:.2f} {unit} is asked for"
                text += " (something in the way, a wheel stuck, motors off, or odometry frozen?)"
                return Contradiction(Kind.BLOCKED, text, on_the_spot=axis == 1)
        return None
